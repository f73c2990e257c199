#include "cone/gather.h"

#include <algorithm>

#include "gl/bindings.h"

namespace voxcone {

namespace {

// The cones come first, the G-buffer behind them, and one more is a pass' own.
constexpr int kConeUnit = gl::kPassTextureUnit, kGBufferUnit = kConeUnit + kConeUnits, kOwnUnit = gl::kEnvironmentUnit;
constexpr int kOutputImage = 0;
constexpr int kShadowCones = 16;
// Roughness 0.14: voxels do not resolve smoother lobes (docs/accuracy.md).
constexpr float kSmoothAlpha = 0.02f;

gl::Defines merged(gl::Defines a, const gl::Defines& b) {
    a.insert(b.begin(), b.end());
    return a;
}

void dispatchPixels(gl::Program& program, const gl::Texture& output, const char* image, GLenum format) {
    output.bindImage(kOutputImage, 0, GL_WRITE_ONLY, format);
    program.set(image, kOutputImage);
    gl::dispatch(program, gl::groupsFor(output.width(), 8), gl::groupsFor(output.height(), 8), 1);
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

/// The same for shaders that count pixels from u_firstPixel: in pieces, after each of which `stop` is asked.
void dispatchPieces(gl::Program& program, const gl::Texture& output, const char* image, GLenum format, int& piece,
                    const Stop& stop) {
    constexpr int kGroup = 8;
    const int columns = gl::groupsFor(output.width(), kGroup), rows = gl::groupsFor(output.height(), kGroup);
    output.bindImage(kOutputImage, 0, GL_WRITE_ONLY, format);
    program.set(image, kOutputImage);
    int next = 0;
    gl::inPieces(next, columns * rows, piece, stop, [&](int first, int end) {
        // The rest of a row, whole rows, the beginning of a row.
        while (first < end) {
            const int column = first % columns, count = end - first;
            const int wide = std::min(count, columns - column), high = wide == columns ? count / columns : 1;
            program.set("u_firstPixel", kGroup * glm::ivec2(column, first / columns));
            gl::dispatch(program, wide, high, 1);
            first += wide * high;
        }
    });
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

float inverseVoxelSize(const RadianceVolume& volume) {
    return static_cast<float>(1 / volume.voxels->layout.voxelSize);
}

}  // namespace

gl::Defines diffuseDefines(const Settings& settings, const Voxels& voxels, const Sky& sky,
                           const gl::Defines& gbufferDefines) {
    gl::Defines defines = merged(coneSetDefines(settings, voxels, sky, settings.cone.diffuse), gbufferDefines);
    defines["ROTATE"] = settings.cone.rotate ? "1" : "0";
    return defines;
}

gl::Defines specularDefines(const Settings& settings, const Voxels& voxels, const Sky& sky,
                            const gl::Defines& gbufferDefines) {
    const bool ggx = settings.specular.aperture == SpecularAperture::ggx;
    gl::Defines defines = merged(coneDefines(settings, voxels, sky), gbufferDefines);
    defines["APERTURE_GGX"] = ggx ? "1" : "0";
    defines["CONES"] = std::to_string(ggx ? settings.specular.cones : 1);
    defines["SPIRAL"] = "1";
    defines["ROTATE"] = settings.cone.rotate ? "1" : "0";
    defines["AO_DISTANCE"] = "0";
    return defines;
}

void setDiffuseUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                        int unit) {
    setConeUniforms(program, settings, sky, volume, settings.cone.step, unit);
    setConeSetUniforms(program, settings.cone.diffuse);
    program.set("u_inverseVoxelSize", inverseVoxelSize(volume));
}

void setSpecularUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                         int unit) {
    setConeUniforms(program, settings, sky, volume, settings.specular.step, unit);
    // Few of the cones of a lobe run along the surface, as those at the rim of a diffuse set do.
    program.set("u_footprintCap", 0.5 * settings.cone.footprintCap);
    program.set("u_inverseVoxelSize", inverseVoxelSize(volume));
    program.set("u_smoothAlpha", kSmoothAlpha);
}

DiffusePass::DiffusePass(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels,
                         const Sky& sky, const gl::Defines& gbufferDefines, int width, int height)
    : settings_(settings),
      samples_(shaders, "cone/diffuse.comp", diffuseDefines(settings, voxels, sky, gbufferDefines)) {
    gl::Defines defines = diffuseDefines(settings, voxels, sky, gbufferDefines);
    gather_ = shaders.compute("cone/diffuse.comp", defines);
    gl::Defines filterDefines = gbufferDefines;
    filterDefines["ROTATE"] = defines["ROTATE"];
    filterDefines["CASCADES"] = defines["CASCADES"];
    filter_ = shaders.compute("cone/filter.comp", filterDefines);
    resize(width, height);
}

void DiffusePass::resize(int width, int height) {
    gathered_ = gl::Texture::create2D(GL_RGBA32F, width, height);
    diffuse_ = gl::Texture::create2D(GL_RGBA32F, width, height);
}

void DiffusePass::gather(gl::Program& program, const RadianceVolume& volume, const Sky& sky,
                         const BindGBuffer& bindGBuffer, SeamSide side, const Stop& stop) {
    setDiffuseUniforms(program, settings_, sky, volume, kConeUnit);
    setContainmentUniforms(program, *volume.voxels, side == SeamSide::blended);
    program.set("u_coarserSide", side == SeamSide::coarser);
    bindGBuffer(program, kGBufferUnit);
    dispatchPieces(program, gathered_, "u_gathered", GL_RGBA32F, piece_, stop);
}

std::uint64_t DiffusePass::countSamples(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer) {
    return samples_.count(
        [&](gl::Program& program) { gather(program, volume, sky, bindGBuffer, SeamSide::blended, {}); });
}

void DiffusePass::run(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer,
                      gl::PassTimers& timers, SeamSide side, const Stop& stop) {
    {
        const auto pass = timers.pass("cones: diffuse");
        gather(gather_, volume, sky, bindGBuffer, side, stop);
    }
    if (stop && stop()) return;
    const auto pass = timers.pass("cones: filter");
    gathered_.bindTo(kOwnUnit);
    filter_.set("u_gathered", kOwnUnit);
    setContainmentUniforms(filter_, *volume.voxels);
    filter_.set("u_voxelSize", static_cast<float>(volume.voxels->layout.voxelSize));
    bindGBuffer(filter_, kGBufferUnit);
    dispatchPixels(filter_, diffuse_, "u_diffuse", GL_RGBA32F);
}

SpecularPass::SpecularPass(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels,
                           const Sky& sky, const gl::Defines& gbufferDefines, const gl::Texture& specularAlbedo,
                           int width, int height)
    : settings_(settings),
      specularAlbedo_(specularAlbedo),
      samples_(shaders, "cone/specular.comp", specularDefines(settings, voxels, sky, gbufferDefines)) {
    gl::Defines defines = specularDefines(settings, voxels, sky, gbufferDefines);
    gather_ = shaders.compute("cone/specular.comp", defines);
    gl::Defines filterDefines = gbufferDefines;
    for (const char* name : {"CONES", "ROTATE", "CASCADES"}) filterDefines[name] = defines[name];
    filter_ = shaders.compute("cone/specular_filter.comp", filterDefines);
    resize(width, height);
}

void SpecularPass::resize(int width, int height) {
    gathered_ = gl::Texture::create2D(GL_RGBA32F, width, height);
    specular_ = gl::Texture::create2D(GL_RGBA32F, width, height);
}

void SpecularPass::gather(gl::Program& program, const RadianceVolume& volume, const Sky& sky,
                          const BindGBuffer& bindGBuffer, const Stop& stop) {
    setSpecularUniforms(program, settings_, sky, volume, kConeUnit);
    bindGBuffer(program, kGBufferUnit);
    dispatchPieces(program, gathered_, "u_gathered", GL_RGBA32F, piece_, stop);
}

std::uint64_t SpecularPass::countSamples(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer) {
    return samples_.count([&](gl::Program& program) { gather(program, volume, sky, bindGBuffer, {}); });
}

void SpecularPass::run(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer,
                       gl::PassTimers& timers, const Stop& stop) {
    {
        const auto pass = timers.pass("cones: specular");
        gather(gather_, volume, sky, bindGBuffer, stop);
    }
    if (stop && stop()) return;
    const auto pass = timers.pass("cones: specular filter");
    gathered_.bindTo(kOwnUnit);
    filter_.set("u_gathered", kOwnUnit);
    specularAlbedo_.bindTo(kConeUnit);
    filter_.set("u_specularAlbedo", kConeUnit);
    filter_.set("u_smoothAlpha", kSmoothAlpha);
    setContainmentUniforms(filter_, *volume.voxels);
    filter_.set("u_voxelSize", static_cast<float>(volume.voxels->layout.voxelSize));
    bindGBuffer(filter_, kGBufferUnit);
    dispatchPixels(filter_, specular_, "u_specular", GL_RGBA32F);
}

SoftShadowPass::SoftShadowPass(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels,
                               const gl::Defines& gbufferDefines, int width, int height)
    : settings_(settings) {
    gl::Defines defines = merged(coneSetDefines(settings, voxels, Sky{}, kShadowCones), gbufferDefines);
    defines["AO_DISTANCE"] = "0";
    defines["SHADOW_CONES"] = std::to_string(settings.shadow.coneCount);
    program_ = shaders.compute("cone/soft_shadow.comp", defines);
    resize(width, height);
}

void SoftShadowPass::resize(int width, int height) {
    visibility_ = gl::Texture::create2D(GL_R32F, width, height);
}

void SoftShadowPass::run(const RadianceVolume& volume, const std::function<void(gl::Program&)>& bindLights,
                         const BindGBuffer& bindGBuffer, gl::PassTimers& timers) {
    const auto pass = timers.pass("cones: soft shadow");
    setConeUniforms(program_, settings_, Sky{}, volume, settings_.cone.step, kConeUnit);
    program_.set("u_inverseVoxelSize", inverseVoxelSize(volume));
    bindLights(program_);
    bindGBuffer(program_, kGBufferUnit);
    dispatchPixels(program_, visibility_, "u_visibility", GL_R32F);
}

}  // namespace voxcone
