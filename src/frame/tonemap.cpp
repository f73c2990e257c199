#include "frame/tonemap.h"

#include <array>
#include <cmath>

#include "core/check.h"
#include "gl/bindings.h"

namespace voxcone {
namespace {

constexpr std::array<const char*, 4> kLayers = {"u_layer0", "u_layer1", "u_layer2", "u_layer3"};
constexpr int kLayerUnit = gl::kPassTextureUnit + GBuffer::kUnits;
constexpr int kSkyUnit = kLayerUnit + static_cast<int>(kLayers.size());

}  // namespace

Sky skyOf(const gl::GpuEnvironment& environment) {
    return {environment.color, environment.panorama ? &environment.panorama : nullptr, environment.rotation};
}

Composite::Composite(const gl::ShaderLibrary& shaders, const GBuffer& gbuffer, const Sky& sky) {
    resize(gbuffer.width(), gbuffer.height());
    gl::Defines defines = gbuffer.defines();
    defines["SKY"] = std::to_string(sky.kind());
    program_ = shaders.compute("frame/composite.comp", defines);
}

void Composite::resize(int width, int height) {
    beauty_ = gl::Texture::create2D(GL_RGBA32F, width, height);
}

void Composite::run(const GBuffer& gbuffer, const Sky& sky, const std::vector<const gl::Texture*>& layers,
                    double exposure, gl::PassTimers& timers) {
    VOXCONE_CHECK(layers.size() <= kLayers.size(), "{} layers", layers.size());
    const auto pass = timers.pass("composite");
    gbuffer.bind(program_, gl::kPassTextureUnit);
    for (std::size_t i = 0; i < layers.size(); ++i) {
        VOXCONE_CHECK(layers[i]->width() == gbuffer.width() && layers[i]->height() == gbuffer.height(), "layer {}", i);
        layers[i]->bindTo(kLayerUnit + static_cast<int>(i));
    }
    for (std::size_t i = 0; i < kLayers.size(); ++i) program_.set(kLayers[i], kLayerUnit + static_cast<int>(i));
    program_.set("u_layers", static_cast<int>(layers.size()));
    program_.set("u_exposureScale", std::exp2(exposure));
    if (sky.panorama) sky.panorama->bindTo(kSkyUnit);
    program_.set("u_environment", kSkyUnit);
    program_.set("u_environmentColor", sky.color);
    program_.set("u_environmentRotation", sky.rotation);
    beauty_.bindImage(0, 0, GL_WRITE_ONLY);
    gl::dispatch(program_, gl::groupsFor(gbuffer.width(), 8), gl::groupsFor(gbuffer.height(), 8), 1);
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

Readout::Readout(const gl::ShaderLibrary& shaders)
    : mean_(shaders.compute("frame/downsample.comp")),
      toneMap_(shaders.compute("frame/downsample.comp", {{"TONE_MAP", "1"}})) {}

gl::Texture Readout::run(gl::Program& program, const gl::Texture& source, int supersample) {
    VOXCONE_CHECK(supersample > 0 && source.width() % supersample == 0 && source.height() % supersample == 0,
                  "{}×{} by {}", source.width(), source.height(), supersample);
    gl::Texture output = gl::Texture::create2D(GL_RGBA32F, source.width() / supersample, source.height() / supersample);
    // Passes that wrote `source` may have done so through an image.
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    source.bindTo(gl::kPassTextureUnit);
    program.set("u_source", gl::kPassTextureUnit);
    program.set("u_supersample", supersample);
    output.bindImage(0, 0, GL_WRITE_ONLY);
    gl::dispatch(program, gl::groupsFor(output.width(), 8), gl::groupsFor(output.height(), 8), 1);
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return output;
}

Image Readout::read(const gl::Texture& source, int channels, int supersample) {
    return imageFromTexture(run(mean_, source, supersample), channels);
}

gl::Texture Readout::displayTexture(const gl::Texture& beauty, ToneMap curve, int supersample) {
    toneMap_.set("u_curve", static_cast<int>(curve));
    return run(toneMap_, beauty, supersample);
}

Image Readout::display(const gl::Texture& beauty, ToneMap curve, int supersample) {
    return imageFromTexture(displayTexture(beauty, curve, supersample), 3);
}

}  // namespace voxcone
