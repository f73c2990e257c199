// Binding points that scene data always has. Twin of shaders/shared/bindings.glsl.
#pragma once

namespace voxcone::gl {

/// Texture units of the material that is drawn. Passes that draw none use kEnvironmentUnit, kPassTextureUnit and up.
enum MaterialUnit : int {
    kBaseColorUnit = 0,
    kMetallicRoughnessUnit = 1,
    kNormalUnit = 2,
    kEmissionUnit = 3,
    kTransmissionUnit = 4,
    kThicknessUnit = 5,
    kDiffuseTransmissionUnit = 6,
    kDiffuseTransmissionColorUnit = 7,
};
constexpr int kMaterialUnits = 8;
constexpr int kEnvironmentUnit = 4;
constexpr int kPassTextureUnit = 5;

/// Shader storage block 0 is the scene's; passes that draw nothing may use it too (light/shadow_maps.h,
/// cascade/buffers.h).
constexpr int kObjectStorage = 0;

/// Uniform block of the material that is drawn.
constexpr int kMaterialBlock = 0;

/// Vertex attributes of GpuScene.
enum VertexLocation : int {
    kPositionLocation = 0,  ///< vec3, object space
    kNormalLocation = 1,    ///< vec3, object space
    kTangentLocation = 2,   ///< vec4, w handedness; 0 without tangents
    kTexCoord0Location = 3,
    kTexCoord1Location = 4,
    kColorLocation = 5,        ///< vec4, linear
    kObjectIndexLocation = 6,  ///< uint, per instance
};

}  // namespace voxcone::gl
