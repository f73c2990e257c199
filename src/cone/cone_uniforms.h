// What shaders/cone/*.glsl need to be told.
#pragma once

#include "core/settings.h"
#include "gl/program.h"
#include "gl/shader_library.h"
#include "gl/texture.h"
#include "voxelize/voxelizer.h"

namespace voxcone {

/// Sky as cones see it: shaders/cone/sky.glsl.
struct Sky {
    glm::vec3 color{0};
    const gl::Texture* panorama = nullptr;  ///< null: constant colour
    float rotation = 0;                     ///< radians
    /// 0 black, 1 constant, 2 panorama.
    int kind() const { return color == glm::vec3(0) ? 0 : panorama ? 2 : 1; }
};

/// The radiance volume with what is needed to read it.
struct RadianceVolume {
    const Voxels* voxels = nullptr;
    const gl::Texture* radiance = nullptr;
    float scale = 1;  ///< stored values times this are W/(m² sr)
};

/// Defines of cone/trace.glsl and cone/sky.glsl for these settings.
gl::Defines coneDefines(const Settings& settings, const Sky& sky);

/// Adds those of cone/cone_set.glsl.
gl::Defines coneSetDefines(const Settings& settings, const Sky& sky, int cones);

/// Binds volumes and sky from texture unit `unit` (four units) and sets the uniforms of cone/trace.glsl and
/// cone/sky.glsl.
void setConeUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                     double step, int unit);

/// Uniforms of cone/cone_set.glsl.
void setConeSetUniforms(gl::Program& program, int cones);

}  // namespace voxcone
