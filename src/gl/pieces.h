// Long work on the device in pieces, so that somebody may be asked in between whether to go on.
#pragma once

#include <functional>

namespace voxcone::gl {

/// Asked between pieces of long work; true ends it. Empty: never.
using Stop = std::function<bool()>;

/// Does `work(first, end)` for pieces of the items from `next` to `count`, waits for the device after each, and then
/// asks `stop`; at least one piece is done. Without `stop` all is one piece, and nobody waits. `next`: the first item
/// that is left. `piece`: items at a time, adapted so that a piece takes about 20 ms. True when all is done.
bool inPieces(int& next, int count, int& piece, const Stop& stop, const std::function<void(int first, int end)>& work);

}  // namespace voxcone::gl
