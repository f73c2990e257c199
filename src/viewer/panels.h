// The panels of the side bar. Each draws one section with Dear ImGui and does what its controls say to the session.
#pragma once

#include <set>
#include <string>

#include "viewer/session.h"

namespace voxcone {

struct Panel {
    const char* name;
    int key;  ///< GLFW key that opens and closes it
    void (*draw)(Session&);
    bool open = false;
};

/// All of them, in the order of the side bar.
std::vector<Panel> makePanels();

/// Draws a control for every field of the tree, in groups, or those that Session::settingsFilter is part of; answers
/// the keys of those that are not in a closed group.
std::set<std::string> drawSettings(Session& session);

/// Colour of a clipmap level, as the channel `cascade` has it: 0xAABBGGRR.
std::uint32_t levelColor(int level, float alpha = 1);

/// Lists keys and mouse.
void drawHelp(bool& open);

}  // namespace voxcone
