#include "cascade/update.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

namespace voxcone {

bool ClipmapUpdate::touches(int level) const {
    const auto at = [level](const Region& region) { return region.level == level; };
    return std::any_of(fixed.begin(), fixed.end(), at) || std::any_of(moving.begin(), moving.end(), at);
}

VoxelBox voxelBox(const Bounds& b, double voxelSize) {
    const auto index = [](const glm::dvec3& p) {
        return glm::ivec3(glm::clamp(glm::floor(p), glm::dvec3(-1e9), glm::dvec3(1e9)));
    };
    if (b.empty()) return {};
    // A hair more: vertices are rounded to floats before they are voxelized.
    const glm::dvec3 hair = 1e-6 * glm::max(glm::abs(b.min), glm::abs(b.max)) / voxelSize + 1e-3;
    return {index(b.min / voxelSize - hair), index(b.max / voxelSize + hair) + 1};
}

std::vector<VoxelBox> disjoint(const std::vector<VoxelBox>& boxes) {
    std::vector<VoxelBox> out;
    for (const VoxelBox& box : boxes) {
        std::vector<VoxelBox> rest;
        if (!box.empty()) rest.push_back(box);
        for (std::size_t i = 0, known = out.size(); i < known; ++i) {
            std::vector<VoxelBox> next;
            for (const VoxelBox& piece : rest)
                for (const VoxelBox& left : exposedSlabs(out[i], piece)) next.push_back(left);
            rest = std::move(next);
        }
        out.insert(out.end(), rest.begin(), rest.end());
    }
    return out;
}

std::vector<ClipmapUpdate> byLevel(const ClipmapLayout& layout, const ClipmapUpdate& update,
                                   const std::vector<VoxelBox>& before) {
    std::vector<VoxelBox> windows = before;
    if (update.all) {
        windows = update.windows;
        for (VoxelBox& window : windows) window.high = window.low;
    }
    std::vector<ClipmapUpdate> parts;
    for (int level = layout.levels - 1; level >= 0; --level) {
        ClipmapUpdate part;
        const auto take = [level](const std::vector<Region>& from, std::vector<Region>& to) {
            std::copy_if(from.begin(), from.end(), std::back_inserter(to),
                         [level](const Region& region) { return region.level == level; });
        };
        take(update.fixed, part.fixed);
        take(update.moving, part.moving);
        if (part.empty()) continue;
        // Mips are made with the last level.
        const auto end = level == layout.levels - 1 ? update.windows.end() : update.windows.begin() + level + 1;
        std::copy(update.windows.begin() + level, end, windows.begin() + level);
        part.windows = windows;
        part.all = update.all && parts.empty();
        parts.push_back(std::move(part));
    }
    return parts;
}

namespace {

/// Boxes that a level voxelizes one by one; where there are more, neighbours along x share their hull.
constexpr std::size_t kMostBoxes = 32;

std::vector<VoxelBox> joined(std::vector<VoxelBox> boxes) {
    std::erase_if(boxes, [](const VoxelBox& box) { return box.empty(); });
    if (boxes.size() <= kMostBoxes) return boxes;
    std::sort(boxes.begin(), boxes.end(), [](const VoxelBox& a, const VoxelBox& b) {
        return std::tuple(a.low.x, a.low.y, a.low.z, a.high.x, a.high.y, a.high.z) <
               std::tuple(b.low.x, b.low.y, b.low.z, b.high.x, b.high.y, b.high.z);
    });
    std::vector<VoxelBox> out;
    const std::size_t share = (boxes.size() + kMostBoxes - 1) / kMostBoxes;
    for (std::size_t first = 0; first < boxes.size(); first += share) {
        VoxelBox hull = boxes[first];
        for (std::size_t i = first; i < std::min(first + share, boxes.size()); ++i)
            hull = {glm::min(hull.low, boxes[i].low), glm::max(hull.high, boxes[i].high)};
        out.push_back(hull);
    }
    return out;
}

}  // namespace

ClipmapSchedule::ClipmapSchedule(const ClipmapLayout& layout, int budget, bool anyMoving)
    : layout_(layout), budget_(budget), anyMoving_(anyMoving) {
    reset();
}

void ClipmapSchedule::reset() {
    windows_.clear();
    moved_.assign(static_cast<std::size_t>(layout_.levels), {});
    placed_ = moved_;
    turn_ = waiting_ = 0;
}

std::vector<char> ClipmapSchedule::chosen(const std::vector<VoxelBox>& wanted, const glm::dvec3& center) {
    const auto levels = static_cast<std::size_t>(layout_.levels);
    std::vector<char> chosen(levels, windows_.empty() || budget_ == 0);
    if (chosen[0]) return chosen;
    int left = budget_;
    waiting_ = 0;
    const auto stale = [&](std::size_t l) {
        return windows_[l] != wanted[l] || !moved_[l].empty() || !placed_[l].empty();
    };
    for (std::size_t l = 0; l < levels; ++l) {
        // A camera that has left the inner half of a window can wait no longer: there is less than half a level to
        // read.
        const glm::dvec3 c = center / layout_.voxelSizeOf(static_cast<int>(l));
        const glm::dvec3 reach = glm::min(c - glm::dvec3(windows_[l].low), glm::dvec3(windows_[l].high) - c);
        if (!layout_.moves(static_cast<int>(l)) || std::min({reach.x, reach.y, reach.z}) > 0.25 * layout_.resolution)
            continue;
        chosen[l] = 1;
        --left;
    }
    const int first = turn_;
    for (int i = 0; i < layout_.levels; ++i) {
        const auto l = static_cast<std::size_t>((first + i) % layout_.levels);
        if (chosen[l] || !stale(l)) continue;
        if (left <= 0) {
            ++waiting_;
            continue;
        }
        chosen[l] = 1;
        --left;
        turn_ = static_cast<int>(l + 1) % layout_.levels;
    }
    return chosen;
}

ClipmapUpdate ClipmapSchedule::next(const glm::dvec3& center, const std::vector<Bounds>& moved,
                                    const std::vector<Bounds>& placed) {
    std::vector<VoxelBox> wanted;
    for (int level = 0; level < layout_.levels; ++level) wanted.push_back(clipmapWindow(layout_, level, center));
    if (!windows_.empty()) {
        for (auto& boxes : moved_) boxes.insert(boxes.end(), moved.begin(), moved.end());
        for (auto& boxes : placed_) boxes.insert(boxes.end(), placed.begin(), placed.end());
    }
    const std::vector<char> follow = chosen(wanted, center);

    ClipmapUpdate update;
    update.all = windows_.empty();
    windows_.resize(wanted.size());
    for (int level = 0; level < layout_.levels; ++level) {
        const auto l = static_cast<std::size_t>(level);
        if (!follow[l]) continue;
        std::vector<VoxelBox> boxes = exposedSlabs(windows_[l], wanted[l]);
        const auto add = [&](const std::vector<Bounds>& changed) {
            for (const Bounds& b : changed)
                boxes.push_back(intersection(voxelBox(b, layout_.voxelSizeOf(level)), wanted[l]));
        };
        if (!placed_[l].empty()) {
            add(placed_[l]);
            boxes = disjoint(joined(std::move(boxes)));
        }
        for (const VoxelBox& box : boxes) update.fixed.push_back({level, box});
        if (anyMoving_) {
            add(moved_[l]);
            for (const VoxelBox& box : disjoint(joined(std::move(boxes)))) update.moving.push_back({level, box});
        }
        windows_[l] = wanted[l];
        moved_[l].clear();
        placed_[l].clear();
    }
    update.windows = windows_;
    for (int mip = layout_.levels; mip < layout_.count(); ++mip) {
        const int shift = mip - layout_.levels + 1;
        const VoxelBox& last = windows_.back();
        update.windows.push_back({last.low >> glm::ivec3(shift), last.high >> glm::ivec3(shift)});
    }
    return update;
}

}  // namespace voxcone
