// What shaders/cone/*.glsl need to be told.
#pragma once

#include "cascade/voxels.h"
#include "core/settings.h"
#include "gl/program.h"
#include "gl/shader_library.h"
#include "gl/texture.h"

namespace voxcone {

/// Sky as cones see it: shaders/cone/sky.glsl.
struct Sky {
    glm::vec3 color{0};
    const gl::Texture* panorama = nullptr;  ///< null: constant colour
    float rotation = 0;                     ///< radians
    /// 0 black, 1 constant, 2 panorama.
    int kind() const { return color == glm::vec3(0) ? 0 : panorama ? 2 : 1; }
};

/// Radiance of the voxels with what is needed to read it.
struct RadianceVolume {
    const Voxels* voxels = nullptr;
    const gl::Buffer* radiance = nullptr;  ///< as shaders/cone/trace.glsl reads it
    float scale = 1;                       ///< stored values times this are W/(m² sr)
};

constexpr int kConeUnits = 6;

/// Defines of cone/trace.glsl and cone/sky.glsl for these settings and the shape of `voxels`.
gl::Defines coneDefines(const Settings& settings, const Voxels& voxels, const Sky& sky);

/// Adds those of cone/cone_set.glsl.
gl::Defines coneSetDefines(const Settings& settings, const Voxels& voxels, const Sky& sky, int cones);

/// Binds volumes and sky from texture unit `unit` (kConeUnits of them) and sets the uniforms of cone/trace.glsl and
/// cone/sky.glsl.
/// `anyCamera`: Voxels::readable.
void setConeUniforms(gl::Program& program, const Settings& settings, const Sky& sky, const RadianceVolume& volume,
                     double step, int unit, bool anyCamera = false);

/// Uniforms of cascade/containment.glsl. Without `blend` levels end where the next one begins.
void setContainmentUniforms(gl::Program& program, const Voxels& voxels, bool blend = true);

/// Uniforms of cone/cone_set.glsl.
void setConeSetUniforms(gl::Program& program, int cones);

}  // namespace voxcone
