#include "cone/probe.h"

#include "gl/bindings.h"

namespace voxcone {

namespace {
constexpr int kProbeStorage = 4, kResultStorage = 5;  // shaders/cone/probe.comp
}

ConeProber::ConeProber(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels, const Sky& sky)
    : settings_(settings),
      program_(shaders.compute("cone/probe.comp", coneSetDefines(settings, voxels, sky, settings.cone.diffuse))) {}

std::vector<ConeProbeResult> ConeProber::gather(const std::vector<ConeProbe>& probes, const RadianceVolume& volume,
                                                const Sky& sky) {
    if (probes.empty()) return {};
    const Voxels& voxels = *volume.voxels;
    std::vector<glm::vec4> packed;
    for (const ConeProbe& probe : probes) {
        packed.emplace_back((probe.position - voxels.origin) / voxels.layout.voxelSize, 0);
        packed.emplace_back(glm::normalize(probe.normal), 0);
    }
    const gl::Buffer points = gl::Buffer::of(packed);
    const gl::Buffer results(probes.size() * sizeof(glm::vec4));
    points.bindBase(GL_SHADER_STORAGE_BUFFER, kProbeStorage);
    results.bindBase(GL_SHADER_STORAGE_BUFFER, kResultStorage);
    program_.set("u_probeCount", static_cast<std::uint32_t>(probes.size()));
    program_.set("u_turns", settings_.cone.rotate ? 16 : 1);
    setConeUniforms(program_, settings_, sky, volume, settings_.cone.step, gl::kPassTextureUnit);
    setConeSetUniforms(program_, settings_.cone.diffuse);
    gl::dispatch(program_, gl::groupsFor(static_cast<int>(probes.size()), 64), 1, 1);
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    std::vector<ConeProbeResult> out;
    for (const glm::vec4& r : results.read<glm::vec4>()) out.push_back({glm::vec3(r), r.w});
    return out;
}

}  // namespace voxcone
