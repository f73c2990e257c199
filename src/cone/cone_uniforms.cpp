#include "cone/cone_uniforms.h"

#include "cone/cone_set.h"

namespace voxcone {

namespace {

/// Exact planes need the faces of six_face storage, and hide what is behind them as the linear rule has it.
bool nearField(const Settings& settings, const Voxels& voxels) {
    return settings.cone.nearField > 0 && settings.cone.start == StartOffset::normal &&
           settings.cone.compositing == Compositing::linear && voxels.sixFace();
}

}  // namespace

gl::Defines coneDefines(const Settings& settings, const Voxels& voxels, const Sky& sky) {
    const auto is = [](bool value) { return value ? "1" : "0"; };
    const Settings::Cone& cone = settings.cone;
    return {
        {"SIX_FACE", is(voxels.sixFace())},
        {"SH1", is(settings.voxel.storage == VoxelStorage::sh1)},
        {"CASCADES", is(voxels.layout.levels > 1)},
        {"LAYERS", voxels.anyMoving() ? "2" : "1"},
        {"LEAVES", is(voxels.leaves)},
        {"COMPOSITING_LINEAR", is(cone.compositing == Compositing::linear)},
        {"COMPOSITING_EXPONENTIAL", is(cone.compositing == Compositing::exponential)},
        {"COMPOSITING_ALPHA", is(cone.compositing == Compositing::alpha)},
        {"START_NORMAL", is(cone.start == StartOffset::normal)},
        {"FOOTPRINT_CAP", is(cone.footprintCap > 0)},
        {"NEAR_FIELD", is(nearField(settings, voxels))},
        {"AO_DISTANCE", is(settings.ao.distance > 0)},
        {"COUNT_SAMPLES", "0"},
        {"SKY", std::to_string(sky.kind())},
    };
}

gl::Defines coneSetDefines(const Settings& settings, const Voxels& voxels, const Sky& sky, int cones) {
    gl::Defines defines = coneDefines(settings, voxels, sky);
    defines["CONES"] = std::to_string(cones);
    defines["SPIRAL"] = coneSet(cones).spiral ? "1" : "0";
    return defines;
}

void setContainmentUniforms(gl::Program& program, const Voxels& voxels, bool blend) {
    voxels.setClipmapUniforms(program);
    program.set("u_cascadeCenter", glm::vec3(voxels.center / voxels.layout.voxelSize));
    program.set("u_cascadeRadius", voxels.radius());
    program.set("u_cascadeBlend", blend ? 1.0f : 0.0f);
    program.set("u_cascadeBand", voxels.layout.band * voxels.layout.resolution / voxels.layout.radius());
}

void setConeUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                     double step, int unit, bool anyCamera) {
    const Voxels& voxels = *volume.voxels;
    const auto inverseVoxelSize = static_cast<float>(1 / voxels.layout.voxelSize);
    program.set("u_coarsest", voxels.layout.count() - 1);
    program.set("u_coneStep", step);
    program.set("u_coneGain", settings.cone.gain);
    program.set("u_footprintCap", settings.cone.footprintCap);
    program.set("u_startOffset", settings.cone.offset);
    program.set("u_nearDistance", settings.cone.nearField);
    program.set("u_nudge", settings.cone.nudge);
    program.set("u_coneMaxDistance", static_cast<float>(settings.cone.maxDistance) * inverseVoxelSize);
    program.set("u_aoDistance", static_cast<float>(settings.ao.distance) * inverseVoxelSize);
    program.set("u_aoFalloff", static_cast<int>(settings.ao.falloff));
    program.set("u_radianceScale", volume.scale);
    const auto [low, high] = voxels.readable(anyCamera);
    program.set("u_readableLow", glm::vec3(low));
    program.set("u_readableHigh", glm::vec3(high));
    setContainmentUniforms(program, voxels);

    volume.radiance->bindBase(GL_SHADER_STORAGE_BUFFER, kRadianceStorage);
    voxels.faces.bindBase(GL_SHADER_STORAGE_BUFFER, kFaceStorage);
    (voxels.leaves ? voxels.matter : voxels.coverage).bindBase(GL_SHADER_STORAGE_BUFFER, kTracedStorage);
    const auto bind = [&](const char* name, const gl::Texture& texture, int at) {
        if (!texture) return;
        texture.bindTo(at);
        program.set(name, at);
    };
    bind("u_coveragePositive", voxels.coveragePositive, unit);
    bind("u_coverageNegative", voxels.coverageNegative, unit + 1);
    voxels.bindIndex(program, unit + 2);
    if (sky.kind() == 2) bind("u_environment", *sky.panorama, unit + 4);
    bind("u_leaves", voxels.leafDepth, unit + 5);
    program.set("u_environmentColor", sky.color);
    program.set("u_environmentRotation", sky.rotation);
}

void setConeSetUniforms(gl::Program& program, int cones) {
    const ConeSet set = coneSet(cones);
    std::vector<glm::vec4> packed;
    for (std::size_t i = 0; i < set.directions.size(); ++i) packed.emplace_back(set.directions[i], set.weights[i]);
    if (!set.spiral) program.set("u_cones", std::span<const glm::vec4>(packed));
    program.set("u_coneTanHalfAngle", set.tanHalfAngle);
}

}  // namespace voxcone
