#include "cone/inspect.h"

#include <cmath>

#include "gl/bindings.h"

namespace voxcone {
namespace {

constexpr int kInspectedStorage = 4, kRecordedStorage = 5;  // shaders/cone/inspect.comp
constexpr int kSamples = 512;                               ///< kept of a cone

struct Sample {
    glm::vec4 place, radiance;
};
struct Traced {
    glm::vec4 surface, normal, share, origin, direction, radiance, sky;
};

}  // namespace

const char* nameOf(ConeLobe lobe) {
    constexpr const char* kNames[] = {"diffuse", "specular", "beam", "scattered"};
    return kNames[static_cast<int>(lobe)];
}

const char* channelOf(ConeLobe lobe) {
    constexpr const char* kNames[] = {"indirect_diffuse", "indirect_specular", "transmission", "transmission"};
    return kNames[static_cast<int>(lobe)];
}

glm::vec3 PixelCones::radiance() const {
    glm::vec3 sum(0);
    for (const InspectedCone& cone : cones) sum += static_cast<float>(cone.weight) * cone.total();
    return sum;
}

ConeInspector::ConeInspector(ConeLobe lobe, const gl::ShaderLibrary& shaders, const Settings& settings,
                             const Scene& scene, const Voxels& voxels, const Sky& sky,
                             const gl::Defines& gbufferDefines, const gl::Texture& specularAlbedo)
    : lobe_(lobe), settings_(settings), specularAlbedo_(specularAlbedo) {
    gl::Defines defines = lobe == ConeLobe::diffuse ? diffuseDefines(settings, voxels, sky, gbufferDefines)
                          : lobe == ConeLobe::specular
                              ? specularDefines(settings, voxels, sky, gbufferDefines)
                              : refractionDefines(settings, scene, voxels, sky, gbufferDefines);
    cones_ = lobe == ConeLobe::beam ? 1 : std::stoi(defines["CONES"]);
    defines["LOBE"] = std::to_string(static_cast<int>(lobe));
    defines["INVOCATIONS"] = std::to_string(cones_);
    defines["SAMPLES"] = std::to_string(kSamples);
    program_ = shaders.compute("cone/inspect.comp", defines);
}

PixelCones ConeInspector::inspect(const glm::ivec2& pixel, const RadianceVolume& volume, const Sky& sky,
                                  const BindGBuffer& bindGBuffer) {
    constexpr int kConeUnit = gl::kPassTextureUnit;
    const auto cones = static_cast<std::size_t>(cones_);
    gl::Buffer results(cones * sizeof(Traced)), samples(cones * kSamples * sizeof(Sample));
    if (lobe_ == ConeLobe::diffuse) setDiffuseUniforms(program_, settings_, sky, volume, kConeUnit);
    if (lobe_ == ConeLobe::specular) setSpecularUniforms(program_, settings_, sky, volume, kConeUnit);
    if (lobe_ == ConeLobe::beam || lobe_ == ConeLobe::scattered)
        setRefractionUniforms(program_, settings_, sky, volume, kConeUnit);
    if (specularAlbedo_) {
        specularAlbedo_.bindTo(gl::kEnvironmentUnit);
        program_.set("u_specularAlbedo", gl::kEnvironmentUnit);
    }
    program_.set("u_pixel", pixel);
    bindGBuffer(program_, kConeUnit + kConeUnits);
    results.bindBase(GL_SHADER_STORAGE_BUFFER, kInspectedStorage);
    samples.bindBase(GL_SHADER_STORAGE_BUFFER, kRecordedStorage);
    gl::dispatch(program_, gl::groupsFor(cones_, 32), 1, 1);
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);

    const Voxels& voxels = *volume.voxels;
    const double voxel = voxels.layout.voxelSize;
    const auto world = [&](const glm::vec4& v) { return voxels.origin + voxel * glm::dvec3(v); };
    const auto traced = results.read<Traced>();
    const auto taken = samples.read<Sample>();
    PixelCones out;
    out.lobe = lobe_;
    out.position = world(traced.front().surface);
    double weights = 0;
    for (std::size_t i = 0; i < cones; ++i) {
        const Traced& t = traced[i];
        if (t.origin.w <= 0) continue;
        out.normal = glm::vec3(t.normal);
        out.share = glm::vec3(t.share);
        InspectedCone cone;
        cone.origin = world(t.origin);
        cone.direction = glm::dvec3(t.direction);
        cone.tanHalfAngle = static_cast<double>(t.normal.w);
        cone.skyTanHalfAngle = static_cast<double>(t.radiance.w);
        cone.weight = static_cast<double>(t.origin.w);
        cone.radiance = glm::vec3(t.radiance);
        cone.sky = glm::vec3(t.sky);
        cone.transmittance = static_cast<double>(t.sky.w);
        cone.openness = static_cast<double>(t.share.w);
        const auto count = static_cast<std::size_t>(t.direction.w);
        cone.truncated = count > kSamples;
        for (std::size_t k = 0; k < std::min<std::size_t>(count, kSamples); ++k) {
            const Sample& s = taken[i * kSamples + k];
            ConeSample sample;
            sample.distance = voxel * static_cast<double>(s.place.x);
            sample.length = voxel * static_cast<double>(s.place.y);
            sample.level = static_cast<double>(s.place.z);
            sample.footprint = voxel * std::exp2(sample.level);
            sample.transmittance = static_cast<double>(s.place.w);
            sample.openness = static_cast<double>(s.radiance.w);
            sample.radiance = glm::vec3(s.radiance);
            cone.samples.push_back(sample);
        }
        weights += cone.weight;
        out.cones.push_back(std::move(cone));
    }
    for (InspectedCone& cone : out.cones) cone.weight /= weights;
    return out;
}

}  // namespace voxcone
