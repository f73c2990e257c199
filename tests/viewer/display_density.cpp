#include "display_density.h"

#include <X11/Xatom.h>
#include <X11/Xlib.h>

#include <string>

namespace voxcone {

DisplayDensity::DisplayDensity(int dpi) : display_(XOpenDisplay(nullptr)) {
    auto* display = static_cast<Display*>(display_);
    if (!display) return;
    const std::string resources = "Xft.dpi:\t" + std::to_string(dpi) + "\n";
    XChangeProperty(display, DefaultRootWindow(display), XA_RESOURCE_MANAGER, XA_STRING, 8, PropModeReplace,
                    reinterpret_cast<const unsigned char*>(resources.data()), static_cast<int>(resources.size()));
    XSync(display, False);
}

DisplayDensity::~DisplayDensity() {
    auto* display = static_cast<Display*>(display_);
    if (!display) return;
    XDeleteProperty(display, DefaultRootWindow(display), XA_RESOURCE_MANAGER);
    XCloseDisplay(display);
}

}  // namespace voxcone
