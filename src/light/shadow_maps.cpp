#include "light/shadow_maps.h"

#include <algorithm>
#include <vector>

#include "core/check.h"
#include "core/log.h"
#include "gl/framebuffer.h"

namespace voxcone {
namespace {

/// False when a box, relative to the scene's origin, is certainly outside of the view: all corners are beyond one of
/// its four sides, or behind the eye.
bool mayBeSeen(const ShadowViewRecord& view, const Bounds& box) {
    const bool perspective = view.perspective > 0;
    int left = 0, right = 0, below = 0, above = 0, behind = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p = glm::dvec3(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                                        corner & 4 ? box.max.z : box.min.z) -
                             glm::dvec3(view.origin);
        const double z = glm::dot(p, glm::dvec3(view.forward)), limit = perspective ? z : 1.0;
        const double x = static_cast<double>(view.scale) * glm::dot(p, glm::dvec3(view.right));
        const double y = static_cast<double>(view.scale) * glm::dot(p, glm::dvec3(view.up));
        left += x < -limit;
        right += x > limit;
        below += y < -limit;
        above += y > limit;
        behind += perspective && z <= 0;
    }
    return std::max({left, right, below, above, behind}) < 8;
}

}  // namespace

ShadowMaps::ShadowMaps(const gl::Context& context, const gl::ShaderLibrary& shaders, const Settings::Light& settings)
    : context_(context), shaders_(shaders), settings_(settings) {}

bool ShadowMaps::update(const gl::GpuScene& scene, gl::PassTimers& timers) {
    const State now{scene.anyMoving() ? scene.time() : 0, scene.scene().lightsAt(scene.time()), scene.origin()};
    if (state_ == now) return false;
    state_ = now;
    layOut(scene);
    if (layout_.views.empty()) return !layout_.lights.empty();
    const auto pass = timers.pass("shadow_maps");
    draw(scene);
    return true;
}

void ShadowMaps::layOut(const gl::GpuScene& scene) {
    // Bounds over all times: texels stay where they are while things move.
    if (!bounds_) bounds_ = scene.scene().motionBounds();
    layout_ = layoutLights(state_->lights, *bounds_, scene.origin(), settings_.shadowResolution, settings_.shadowFilter,
                           context_.info().max2DTextureSize);
    if (layout_.shrunk > 0) {
        log::warn("{} shadow maps are drawn at {} of light.shadow_resolution to fit in one texture",
                  layout_.views.size(), fmt::format("1/{}", 1 << layout_.shrunk));
    }
    if (layout_.lights.empty()) return;
    lightBuffer_ = gl::Buffer::of(layout_.lights);
    // Lights of a scene without geometry have no views, but the block must be backed.
    viewBuffer_ =
        layout_.views.empty() ? gl::Buffer::of(std::vector<ShadowViewRecord>(1)) : gl::Buffer::of(layout_.views);
    const int width = std::max(layout_.atlasWidth, 1), height = std::max(layout_.atlasHeight, 1);
    if (atlas_ && atlas_.width() == width && atlas_.height() == height) return;
    atlas_ = {};
    atlas_ = gl::Texture::create2D(GL_DEPTH_COMPONENT32F, width, height);
    atlas_.filter(GL_NEAREST, GL_NEAREST);
}

void ShadowMaps::draw(const gl::GpuScene& scene) {
    const std::vector<std::string> stages = {"light/shadow.vert", "light/shadow.frag"};
    if (!opaqueProgram_) opaqueProgram_ = shaders_.graphics(stages, {{"ALPHA_TEST", "0"}});
    const bool alphaTest = scene.anyAlphaTest() || scene.anyTransmission();
    if (alphaTest && !alphaProgram_) alphaProgram_ = shaders_.graphics(stages, {{"ALPHA_TEST", "1"}});

    gl::Framebuffer framebuffer;
    framebuffer.attachDepth(atlas_);
    framebuffer.clearDepth(1);
    gl::DrawState state;
    state.depthTest = true;
    state.depthWrite = true;
    state.apply();
    viewBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kShadowViewStorage);
    const auto isOpaque = [](const gl::Batch& batch) {
        return batch.alphaMode == AlphaMode::opaque && !batch.transmits;
    };
    std::vector<char> seen(scene.objectCount());
    for (std::size_t i = 0; i < layout_.views.size(); ++i) {
        const ShadowTile& tile = layout_.tiles[i];
        for (std::size_t k = 0; k < seen.size(); ++k) {
            Bounds box;
            box.add(scene.objectBounds(k).min - scene.origin());
            box.add(scene.objectBounds(k).max - scene.origin());
            seen[k] = mayBeSeen(layout_.views[i], box);
        }
        const auto anySeen = [&](const gl::Batch& batch) {
            const auto first = seen.begin() + batch.firstObject;
            return std::any_of(first, first + batch.objectCount, [](char s) { return s != 0; });
        };
        gl::Framebuffer::viewport(tile.x, tile.y, tile.size, tile.size);
        opaqueProgram_.set("u_view", static_cast<int>(i));
        scene.draw(opaqueProgram_, [&](const gl::Batch& batch) { return isOpaque(batch) && anySeen(batch); });
        if (alphaTest) {
            alphaProgram_.set("u_view", static_cast<int>(i));
            scene.draw(alphaProgram_, [&](const gl::Batch& batch) { return !isOpaque(batch) && anySeen(batch); });
        }
    }
    // Attachment writes are ordered before later texture fetches of the same context: no barrier is needed.
}

void ShadowMaps::bind(gl::Program& program) const {
    VOXCONE_CHECK(!layout_.lights.empty(), "a scene without lights has nothing to bind");
    lightBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kLightStorage);
    viewBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kShadowViewStorage);
    atlas_.bindTo(kShadowDepthUnit);
    program.set("u_lightCount", lightCount());
}

}  // namespace voxcone
