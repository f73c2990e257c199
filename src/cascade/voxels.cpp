#include "cascade/voxels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/check.h"

namespace voxcone {

std::uint64_t Voxels::volumeBytes() const {
    return index.bytes() + movingIndex.bytes() + coveragePositive.bytes() + coverageNegative.bytes() +
           leafDepth.bytes();
}

std::uint64_t Voxels::recordBytes() const {
    return places.bytes() + faces.bytes() + emission.bytes() + coverage.bytes() + matter.bytes() + freeSlots.bytes() +
           fresh.bytes();
}

double Voxels::radius() const {
    double radius = layout.radius();
    // Not of the last level: what may be read there is readable(), and one that moves has a wider snap of its own.
    for (int level = 0; level < layout.levels - 1; ++level) {
        const VoxelBox& window = windows[static_cast<std::size_t>(level)];
        const glm::dvec3 c = center / layout.voxelSizeOf(level);
        const glm::dvec3 reach = glm::min(c - glm::dvec3(window.low), glm::dvec3(window.high) - c);
        radius = std::min(radius, std::min({reach.x, reach.y, reach.z}) - 1);
    }
    // A camera that no index can follow reads the last level alone.
    return std::max(radius, 1e-3);
}

std::pair<glm::dvec3, glm::dvec3> Voxels::readable(bool anyCamera) const {
    const int last = layout.levels - 1;
    const VoxelBox& window = windows[static_cast<std::size_t>(last)];
    const double scale = static_cast<double>(1 << last);
    const glm::dvec3 low = glm::dvec3(window.low) * scale, high = glm::dvec3(window.high) * scale;
    if (layout.fixedLast) return {low, high};
    const double half = layout.lastRadius() * scale, border = static_cast<double>(1 << layout.mips) / 2 * scale;
    if (anyCamera) return {low + border, high - border};
    const glm::dvec3 c = center / layout.voxelSize;
    return {glm::max(low + border, c - half), glm::min(high - border, c + half)};
}

void Voxels::setClipmapUniforms(gl::Program& program) const {
    program.set("u_resolution", layout.resolution);
    program.set("u_levels", layout.levels);
    program.set("u_firstFixed", layout.firstFixed());
    program.set("u_rows", ClipmapVolume(layout, 0).rows);
    std::array<glm::ivec3, 16> lows{};
    VOXCONE_CHECK(windows.size() <= lows.size(), "{} levels", windows.size());
    for (std::size_t l = 0; l < windows.size(); ++l) lows[l] = windows[l].low;
    program.set("u_windowLow", std::span<const glm::ivec3>(lows));
}

void Voxels::bindIndex(gl::Program& program, int unit) const {
    index.bindTo(unit);
    program.set("u_index", unit);
    if (!anyMoving()) return;
    movingIndex.bindTo(unit + 1);
    program.set("u_movingIndex", unit + 1);
}

void Voxels::bindRecords(gl::Program& program, int unit) const {
    setClipmapUniforms(program);
    bindIndex(program, unit);
    faces.bindBase(GL_SHADER_STORAGE_BUFFER, kFaceStorage);
}

}  // namespace voxcone
