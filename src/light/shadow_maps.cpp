#include "light/shadow_maps.h"

#include "core/check.h"
#include "core/log.h"
#include "gl/framebuffer.h"

namespace voxcone {

ShadowMaps::ShadowMaps(const gl::Context& context, const gl::ShaderLibrary& shaders, const Settings::Light& settings)
    : context_(context), shaders_(shaders), settings_(settings) {}

bool ShadowMaps::update(const gl::GpuScene& scene, gl::PassTimers& timers) {
    const State now{scene.time(), scene.origin()};
    if (state_ == now) return false;
    state_ = now;
    layOut(scene);
    if (layout_.views.empty()) return false;
    const auto pass = timers.pass("shadow_maps");
    draw(scene);
    return true;
}

void ShadowMaps::layOut(const gl::GpuScene& scene) {
    std::vector<Light> lights;
    for (const Light& light : scene.scene().lights) lights.push_back(worldLight(light, scene.worldMatrices()));
    layout_ = layoutLights(lights, scene.bounds(), scene.origin(), settings_.shadowResolution, settings_.shadowFilter,
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
    atlas_.filter(GL_LINEAR, GL_LINEAR);
    atlas_.compare(GL_LEQUAL);
    rawSampler_ = gl::Sampler(GL_NEAREST, GL_NEAREST, GL_CLAMP_TO_EDGE, GL_CLAMP_TO_EDGE);
}

void ShadowMaps::draw(const gl::GpuScene& scene) {
    const std::vector<std::string> stages = {"light/shadow.vert", "light/shadow.frag"};
    if (!opaqueProgram_) opaqueProgram_ = shaders_.graphics(stages, {{"ALPHA_TEST", "0"}});
    const bool alphaTest = scene.anyAlphaTest();
    if (alphaTest && !alphaProgram_) alphaProgram_ = shaders_.graphics(stages, {{"ALPHA_TEST", "1"}});

    gl::Framebuffer framebuffer;
    framebuffer.attachDepth(atlas_);
    framebuffer.clearDepth(1);
    gl::DrawState state;
    state.depthTest = true;
    state.depthWrite = true;
    state.apply();
    viewBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kShadowViewStorage);
    const auto isOpaque = [](const gl::Batch& batch) { return batch.alphaMode == AlphaMode::opaque; };
    for (std::size_t i = 0; i < layout_.views.size(); ++i) {
        const ShadowTile& tile = layout_.tiles[i];
        gl::Framebuffer::viewport(tile.x, tile.y, tile.size, tile.size);
        opaqueProgram_.set("u_view", static_cast<int>(i));
        scene.draw(opaqueProgram_, isOpaque);
        if (alphaTest) {
            alphaProgram_.set("u_view", static_cast<int>(i));
            scene.draw(alphaProgram_, [&](const gl::Batch& batch) { return !isOpaque(batch); });
        }
    }
    // Attachment writes are ordered before later texture fetches of the same context: no barrier is needed.
}

void ShadowMaps::bind(gl::Program& program) const {
    VOXCONE_CHECK(!layout_.lights.empty(), "a scene without lights has nothing to bind");
    lightBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kLightStorage);
    viewBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kShadowViewStorage);
    atlas_.bindTo(kShadowCompareUnit);
    atlas_.bindTo(kShadowDepthUnit);
    rawSampler_.bindTo(kShadowDepthUnit);
    program.set("u_lightCount", lightCount());
}

void ShadowMaps::unbind() const {
    gl::Sampler::unbind(kShadowDepthUnit);
}

}  // namespace voxcone
