#include "cone/refraction.h"

#include <algorithm>

#include "gl/bindings.h"

namespace voxcone {

gl::Defines refractionDefines(const Settings& settings, const Scene& scene, const Voxels& voxels, const Sky& sky,
                              const gl::Defines& gbufferDefines) {
    const auto any = [&](auto&& test) {
        return std::any_of(scene.materials.begin(), scene.materials.end(), test) ? "1" : "0";
    };
    gl::Defines defines = coneSetDefines(settings, voxels, sky, settings.cone.diffuse);
    defines.insert(gbufferDefines.begin(), gbufferDefines.end());
    defines["AO_DISTANCE"] = "0";
    defines["BEAMS"] = any([](const Material& m) { return m.transmission > 0; });
    defines["SCATTERING"] = any([](const Material& m) { return m.diffuseTransmission > 0; });
    return defines;
}

void setRefractionUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                           int unit) {
    setConeUniforms(program, settings, sky, volume, settings.specular.step, unit);
    setConeSetUniforms(program, settings.cone.diffuse);
    program.set("u_inverseVoxelSize", static_cast<float>(1 / volume.voxels->layout.voxelSize));
}

RefractionPass::RefractionPass(const gl::ShaderLibrary& shaders, const Settings& settings, const Scene& scene,
                               const Voxels& voxels, const Sky& sky, const gl::Defines& gbufferDefines,
                               const gl::Texture& specularAlbedo, int width, int height)
    : settings_(settings),
      specularAlbedo_(specularAlbedo),
      samples_(shaders, "cone/refraction.comp", refractionDefines(settings, scene, voxels, sky, gbufferDefines)) {
    program_ = shaders.compute("cone/refraction.comp", refractionDefines(settings, scene, voxels, sky, gbufferDefines));
    resize(width, height);
}

void RefractionPass::resize(int width, int height) {
    transmission_ = gl::Texture::create2D(GL_RGBA32F, width, height);
}

void RefractionPass::gather(gl::Program& program, const RadianceVolume& volume, const Sky& sky,
                            const BindGBuffer& bindGBuffer) {
    constexpr int kTableUnit = gl::kEnvironmentUnit, kConeUnit = gl::kPassTextureUnit;
    setRefractionUniforms(program, settings_, sky, volume, kConeUnit);
    specularAlbedo_.bindTo(kTableUnit);
    program.set("u_specularAlbedo", kTableUnit);
    bindGBuffer(program, kConeUnit + kConeUnits);
    transmission_.bindImage(0, 0, GL_WRITE_ONLY, GL_RGBA32F);
    program.set("u_transmission", 0);
    gl::dispatch(program, gl::groupsFor(transmission_.width(), 8), gl::groupsFor(transmission_.height(), 8), 1);
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

std::uint64_t RefractionPass::countSamples(const RadianceVolume& volume, const Sky& sky,
                                           const BindGBuffer& bindGBuffer) {
    return samples_.count([&](gl::Program& program) { gather(program, volume, sky, bindGBuffer); });
}

void RefractionPass::run(const RadianceVolume& volume, const Sky& sky, const BindGBuffer& bindGBuffer,
                         gl::PassTimers& timers) {
    const auto pass = timers.pass("cones: refraction");
    gather(program_, volume, sky, bindGBuffer);
}

}  // namespace voxcone
