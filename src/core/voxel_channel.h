// Names of pictures of the voxels.
#pragma once

#include <algorithm>
#include <array>
#include <string>

namespace voxcone {

/// A voxel view as scripts and panels name it: voxel_WHAT[:bBOUNCE][:FACE][:LEVEL], as "voxel_radiance:b2:+x:0".
struct VoxelChannel {
    /// albedo, normal, radiance and opacity of a face of each record, and in lobes what cones read of it by direction.
    static constexpr std::array<const char*, 5> kNames{"voxel_albedo", "voxel_normal", "voxel_radiance",
                                                       "voxel_opacity", "voxel_lobes"};
    static constexpr std::array<const char*, 6> kFaces{"+x", "-x", "+y", "-y", "+z", "-z"};
    static constexpr int kLevels = 16;       ///< levels have numbers below
    static constexpr int kMostBounces = 64;  ///< as light.bounces

    std::string base = kNames[0];
    int bounce = -1;  ///< light of this bounce alone, 0 is direct light and emission; −1: all light
    int face = -1;    ///< index into kFaces; −1: the one that looks to the eye
    int level = -1;   ///< all of one level or mip; −1: each level where cones read it

    bool showsLight() const { return base == "voxel_radiance" || base == "voxel_lobes"; }
    bool hasFaces() const { return base != "voxel_lobes"; }

    std::string name() const {
        std::string out = base;
        if (bounce >= 0) out += ":b" + std::to_string(bounce);
        if (face >= 0) out += std::string(":") + kFaces[static_cast<std::size_t>(face)];
        if (level >= 0) out += ":" + std::to_string(level);
        return out;
    }

    /// Reads `name` into `out`. Answers why it is none, empty when it is one. Every view has one name only.
    static std::string parse(const std::string& name, VoxelChannel& out) {
        out = {};
        std::size_t end = std::min(name.find(':'), name.size());
        out.base = name.substr(0, end);
        if (std::find(kNames.begin(), kNames.end(), out.base) == kNames.end())
            return "\"" + out.base + "\" is no voxel view";
        while (end < name.size()) {
            const std::size_t begin = end + 1;
            end = std::min(name.find(':', begin), name.size());
            const std::string part = name.substr(begin, end - begin);
            const auto face = std::find(kFaces.begin(), kFaces.end(), part);
            if (part.starts_with('b') && number(part.substr(1)) >= 0) {
                if (!out.showsLight())
                    return "\"" + out.base + "\" has no bounces; voxel_radiance and voxel_lobes have";
                out.bounce = number(part.substr(1));
                if (out.bounce > kMostBounces)
                    return "\"" + part + "\" is no bounce: b0 to b" + std::to_string(kMostBounces);
            } else if (face != kFaces.end()) {
                if (!out.hasFaces()) return "\"" + out.base + "\" has no faces, it shows all of them";
                out.face = static_cast<int>(face - kFaces.begin());
            } else if (number(part) >= 0 && number(part) < kLevels) {
                out.level = number(part);
            } else {
                return "\"" + name.substr(begin) + "\" is no level: 0 to " + std::to_string(kLevels - 1) +
                       ", nor a face (+x, -x, +y, -y, +z, -z) or bounce (b0, b1, ...) before it";
            }
        }
        return out.name() == name ? "" : "the parts of \"" + name + "\" must stand as in \"" + out.name() + "\"";
    }

  private:
    /// A number of one or two digits as it is written, else −1.
    static int number(const std::string& text) {
        const bool digits = !text.empty() && text.size() <= 2 &&
                            std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
        return digits && (text.size() == 1 || text[0] != '0') ? std::stoi(text) : -1;
    }
};

}  // namespace voxcone
