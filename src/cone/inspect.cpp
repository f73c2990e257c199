#include "cone/inspect.h"

#include <cmath>

#include "cone/cone_set.h"
#include "gl/bindings.h"

namespace voxcone {
namespace {

constexpr int kInspectedStorage = 4, kRecordedStorage = 5;  // shaders/cone/inspect.comp
constexpr int kSamples = 512;                               ///< kept of a cone

struct Sample {
    glm::vec4 place, radiance;
};
struct Traced {
    glm::vec4 origin, direction, radiance, sky, surface;
};

}  // namespace

glm::vec3 PixelCones::radiance() const {
    glm::vec3 sum(0);
    for (const InspectedCone& cone : cones) sum += static_cast<float>(cone.weight) * cone.total();
    return sum;
}

ConeInspector::ConeInspector(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels,
                             const Sky& sky, const gl::Defines& gbufferDefines)
    : settings_(settings) {
    gl::Defines defines = coneSetDefines(settings, voxels, sky, settings.cone.diffuse);
    defines.insert(gbufferDefines.begin(), gbufferDefines.end());
    defines["ROTATE"] = settings.cone.rotate ? "1" : "0";
    defines["SAMPLES"] = std::to_string(kSamples);
    program_ = shaders.compute("cone/inspect.comp", defines);
}

PixelCones ConeInspector::inspect(const glm::ivec2& pixel, const RadianceVolume& volume, const Sky& sky,
                                  const BindGBuffer& bindGBuffer) {
    const auto cones = static_cast<std::size_t>(settings_.cone.diffuse);
    gl::Buffer results(cones * sizeof(Traced)), samples(cones * kSamples * sizeof(Sample));
    setConeUniforms(program_, settings_, sky, volume, settings_.cone.step, gl::kPassTextureUnit);
    setConeSetUniforms(program_, settings_.cone.diffuse);
    const Voxels& voxels = *volume.voxels;
    const double voxel = voxels.layout.voxelSize;
    program_.set("u_inverseVoxelSize", static_cast<float>(1 / voxel));
    program_.set("u_pixel", pixel);
    bindGBuffer(program_, gl::kPassTextureUnit + kConeUnits);
    results.bindBase(GL_SHADER_STORAGE_BUFFER, kInspectedStorage);
    samples.bindBase(GL_SHADER_STORAGE_BUFFER, kRecordedStorage);
    gl::dispatch(program_, gl::groupsFor(settings_.cone.diffuse, 32), 1, 1);
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);

    PixelCones out;
    const auto traced = results.read<Traced>();
    const auto taken = samples.read<Sample>();
    out.hit = traced.front().origin.w > 0;
    if (!out.hit) return out;
    out.position = voxels.origin + voxel * glm::dvec3(traced.front().origin);
    out.normal = glm::vec3(traced.front().surface);
    out.tanHalfAngle = coneSet(settings_.cone.diffuse).tanHalfAngle;
    for (std::size_t i = 0; i < cones; ++i) {
        const Traced& t = traced[i];
        InspectedCone cone;
        cone.direction = glm::dvec3(t.direction);
        cone.weight = static_cast<double>(t.direction.w);
        cone.radiance = glm::vec3(t.radiance);
        cone.sky = glm::vec3(t.sky);
        cone.transmittance = static_cast<double>(t.sky.w);
        cone.openness = static_cast<double>(t.surface.w);
        const auto count = static_cast<std::size_t>(t.radiance.w);
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
        out.cones.push_back(std::move(cone));
    }
    return out;
}

}  // namespace voxcone
