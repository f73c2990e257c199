#include "cone/cone_uniforms.h"

#include "cone/cone_set.h"

namespace voxcone {

gl::Defines coneDefines(const Settings& settings, const Sky& sky) {
    const auto is = [](bool value) { return value ? "1" : "0"; };
    const Settings::Cone& cone = settings.cone;
    return {
        {"SIX_FACE", is(settings.voxel.storage == VoxelStorage::six_face)},
        {"COMPOSITING_LINEAR", is(cone.compositing == Compositing::linear)},
        {"COMPOSITING_EXPONENTIAL", is(cone.compositing == Compositing::exponential)},
        {"COMPOSITING_ALPHA", is(cone.compositing == Compositing::alpha)},
        {"START_NORMAL", is(cone.start == StartOffset::normal)},
        {"FOOTPRINT_CAP", is(cone.footprintCap > 0)},
        {"AO_DISTANCE", is(settings.ao.distance > 0)},
        {"SKY", std::to_string(sky.kind())},
    };
}

gl::Defines coneSetDefines(const Settings& settings, const Sky& sky, int cones) {
    gl::Defines defines = coneDefines(settings, sky);
    defines["CONES"] = std::to_string(cones);
    defines["SPIRAL"] = coneSet(cones).spiral ? "1" : "0";
    return defines;
}

void setConeUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                     double step, int unit) {
    const VoxelGrid& grid = volume.voxels->grid;
    const float inverseVoxelSize = static_cast<float>(1 / grid.voxelSize);
    program.set("u_resolution", grid.resolution);
    program.set("u_levels", gridLevels(grid.resolution));
    program.set("u_coneStep", step);
    program.set("u_coneGain", settings.cone.gain);
    program.set("u_footprintCap", settings.cone.footprintCap);
    program.set("u_startOffset", settings.cone.offset);
    program.set("u_headStart", settings.cone.headStart);
    program.set("u_nudge", settings.cone.nudge);
    program.set("u_coneMaxDistance", static_cast<float>(settings.cone.maxDistance) * inverseVoxelSize);
    program.set("u_aoDistance", static_cast<float>(settings.ao.distance) * inverseVoxelSize);
    program.set("u_aoFalloff", static_cast<int>(settings.ao.falloff));
    program.set("u_radianceScale", volume.scale);

    const auto bind = [&](const char* name, const gl::Texture& texture, int at) {
        texture.bindTo(at);
        program.set(name, at);
    };
    bind("u_radiance", *volume.radiance, unit);
    if (volume.voxels->coveragePositive) {
        bind("u_coveragePositive", volume.voxels->coveragePositive, unit + 1);
        bind("u_coverageNegative", volume.voxels->coverageNegative, unit + 2);
    }
    if (sky.kind() == 2) bind("u_environment", *sky.panorama, unit + 3);
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
