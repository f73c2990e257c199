#include "cone/gather.h"

#include <algorithm>

#include "gl/bindings.h"

namespace voxcone {

namespace {

// The cones come first, the G-buffer behind them, and one more is a pass' own.
constexpr int kConeUnit = gl::kPassTextureUnit, kGBufferUnit = kConeUnit + kConeUnits, kOwnUnit = gl::kEnvironmentUnit;
constexpr int kOutputImage = 0;
constexpr int kShadowCones = 16;

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

/// The same for shaders that count rows from u_firstRow: in bands, before each of which `stop` is asked.
void dispatchBands(gl::Program& program, const gl::Texture& output, const char* image, GLenum format,
                   const Stop& stop) {
    constexpr int kGroup = 8, kPixels = 1 << 14;  // a band: some tens of milliseconds on a software rasteriser
    const int rows = gl::groupsFor(output.height(), kGroup);
    const int band = stop ? std::clamp(kPixels / (kGroup * output.width()), 1, rows) : rows;
    output.bindImage(kOutputImage, 0, GL_WRITE_ONLY, format);
    program.set(image, kOutputImage);
    for (int row = 0; row < rows && !(stop && stop()); row += band) {
        program.set("u_firstRow", kGroup * row);
        gl::dispatch(program, gl::groupsFor(output.width(), kGroup), std::min(band, rows - row), 1);
    }
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

float inverseVoxelSize(const RadianceVolume& volume) {
    return static_cast<float>(1 / volume.voxels->layout.voxelSize);
}

}  // namespace

DiffusePass::DiffusePass(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels,
                         const Sky& sky, const gl::Defines& gbufferDefines, int width, int height)
    : settings_(settings) {
    gl::Defines defines = merged(coneSetDefines(settings, voxels, sky, settings.cone.diffuse), gbufferDefines);
    defines["ROTATE"] = settings.cone.rotate ? "1" : "0";
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

void DiffusePass::run(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer,
                      gl::PassTimers& timers, SeamSide side, const Stop& stop) {
    {
        const auto pass = timers.pass("cones: diffuse");
        setConeUniforms(gather_, settings_, sky, volume, settings_.cone.step, kConeUnit);
        setConeSetUniforms(gather_, settings_.cone.diffuse);
        setContainmentUniforms(gather_, *volume.voxels, side == SeamSide::blended);
        gather_.set("u_coarserSide", side == SeamSide::coarser);
        gather_.set("u_inverseVoxelSize", inverseVoxelSize(volume));
        bindGBuffer(gather_, kGBufferUnit);
        dispatchBands(gather_, gathered_, "u_gathered", GL_RGBA32F, stop);
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
    : settings_(settings), specularAlbedo_(specularAlbedo) {
    const bool ggx = settings.specular.aperture == SpecularAperture::ggx;
    gl::Defines defines = merged(coneDefines(settings, voxels, sky), gbufferDefines);
    defines["APERTURE_GGX"] = ggx ? "1" : "0";
    defines["CONES"] = std::to_string(ggx ? settings.specular.cones : 1);
    defines["SPIRAL"] = "1";
    defines["ROTATE"] = settings.cone.rotate ? "1" : "0";
    defines["AO_DISTANCE"] = "0";
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

void SpecularPass::run(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer,
                       gl::PassTimers& timers, const Stop& stop) {
    // Roughness 0.14: voxels do not resolve smoother lobes (docs/accuracy.md).
    constexpr float kSmoothAlpha = 0.02f;
    {
        const auto pass = timers.pass("cones: specular");
        setConeUniforms(gather_, settings_, sky, volume, settings_.specular.step, kConeUnit);
        // Few of the cones of a lobe run along the surface, as those at the rim of a diffuse set do.
        gather_.set("u_footprintCap", 0.5 * settings_.cone.footprintCap);
        gather_.set("u_inverseVoxelSize", inverseVoxelSize(volume));
        gather_.set("u_smoothAlpha", kSmoothAlpha);
        bindGBuffer(gather_, kGBufferUnit);
        dispatchBands(gather_, gathered_, "u_gathered", GL_RGBA32F, stop);
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
