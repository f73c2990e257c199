// What an update of the clipmap voxelizes: the boxes that moving windows expose, and where things have moved. Pure.
#pragma once

#include <vector>

#include "cascade/clipmap.h"

namespace voxcone {

/// A box of voxels of one level.
struct Region {
    int level = 0;
    VoxelBox box;
};

/// Regions of static and of moving geometry, disjoint in each; those of the mips follow from them.
struct ClipmapUpdate {
    bool all = false;  ///< nothing that was there before is of use
    std::vector<Region> fixed, moving;
    std::vector<VoxelBox> windows;  ///< by level, mips too: what is held afterwards
    bool empty() const { return fixed.empty() && moving.empty(); }
    bool touches(int level) const;
};

/// Voxels that `fromOrigin` (metres) may touch.
VoxelBox voxelBox(const Bounds& fromOrigin, double voxelSize);

/// The union of `boxes` as disjoint boxes.
std::vector<VoxelBox> disjoint(const std::vector<VoxelBox>& boxes);

/// `update` in parts of one level each, the coarsest first, so that finer levels always find what they take light from.
/// `before`: the windows that are held, mips too; empty before the first update, when levels that are yet to come have
/// empty windows. All parts in order do what `update` does.
std::vector<ClipmapUpdate> byLevel(const ClipmapLayout& layout, const ClipmapUpdate& update,
                                   const std::vector<VoxelBox>& before);

/// Decides from frame to frame which levels follow the camera.
class ClipmapSchedule {
  public:
    /// `budget`: levels that a frame may update, in turns; 0 updates all that need it. `anyMoving`: some geometry
    /// moves.
    ClipmapSchedule(const ClipmapLayout& layout, int budget, bool anyMoving);

    /// The next update for a camera at `center`; `moved` are the boxes that moving geometry has left and entered since
    /// the call before, `placed` those of static geometry that was put elsewhere. All relative to the origin, in
    /// metres.
    ClipmapUpdate next(const glm::dvec3& center, const std::vector<Bounds>& moved,
                       const std::vector<Bounds>& placed = {});

    /// Begins anew: the next update is of everything.
    void reset();

    /// Levels that a budget has left behind.
    int waiting() const { return waiting_; }

  private:
    std::vector<char> chosen(const std::vector<VoxelBox>& wanted, const glm::dvec3& center);

    ClipmapLayout layout_;
    int budget_;
    bool anyMoving_;
    std::vector<VoxelBox> windows_;                    ///< by level, without mips; empty before the first update
    std::vector<std::vector<Bounds>> moved_, placed_;  ///< by level: not yet voxelized
    int turn_ = 0;                                     ///< the level that is looked at first
    int waiting_ = 0;
};

}  // namespace voxcone
