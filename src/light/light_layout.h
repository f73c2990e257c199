// The lights as the shaders read them, and which depth maps their shadows need: plain arithmetic, no OpenGL.
//
// One mechanism serves every light: a light is a few sample points (one for point and spot lights; the
// centres of equal strata for spheres and rectangles, and for directional lights with an angular radius), each sample
// point has one or more views, and each view is a square tile of one depth atlas. A view of a half or whole space is
// made of the five or six faces of a cube in the frame of the light. The GLSL twins of the records stand in
// shaders/light/lights.glsl.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scene/scene.h"

namespace voxcone {

/// std430. Positions are relative to the scene's origin, in metres; frames are unit and orthogonal.
struct LightRecord {
    glm::vec3 position{0};
    std::uint32_t type = 0;         ///< LightType
    glm::vec3 direction{0, 0, -1};  ///< the way the light travels
    float range = 0;                ///< 0 = unlimited
    glm::vec3 intensity{0};         ///< as Light::intensity
    float radius = 0;               ///< metres; sine of the angular radius of a directional light
    glm::vec3 right{1, 0, 0};
    float halfWidth = 0;
    glm::vec3 up{0, 1, 0};
    float halfHeight = 0;
    float cosInnerCone = 1, cosOuterCone = 0;  ///< of the half-angles
    float stratumSize = 0;  ///< half the edge of the square that one sample point stands for, metres; a metre
                            ///< away for directional lights
    std::uint32_t padding0 = 0;
    std::uint32_t firstView = 0;  ///< sample i has the views firstView + i·faces and following
    std::uint32_t faces = 0;      ///< views of a sample: 1, 5 (no face looks backwards) or 6
    std::uint32_t samples = 0;
    std::uint32_t padding1 = 0;
};

/// std430. A tile of the depth atlas. With p = position − origin in the view's frame, a perspective view has the plane
/// coordinate t = p.xy / p.z, a parallel one t = p.xy; the tile shows abs(t)·scale ≤ 1.
struct ShadowViewRecord {
    glm::vec3 origin{0};  ///< of a perspective view its eye, which is the sample point
    float texel = 0;      ///< width of a texel in units of t
    glm::vec3 right{1, 0, 0};
    float scale = 0;
    glm::vec3 up{0, 1, 0};
    float perspective = 0;  ///< 1 or 0
    glm::vec3 forward{0, 0, -1};
    float maxKernel = 0;  ///< widest filter half-width in texels that stays within the tile's border
    glm::vec2 tileCenter{0}, tileHalfSize{0};  ///< atlas texture coordinates
    /// Window depth: depth.x − depth.y / p.z (perspective) or depth.x + depth.y·p.z (parallel).
    glm::vec2 depth{0};
    float filterRadius = 0;  ///< texels
    float padding = 0;
};

/// Place of a view in the atlas, texels.
struct ShadowTile {
    int x = 0, y = 0, size = 0;
};

struct LightLayout {
    std::vector<LightRecord> lights;
    std::vector<ShadowViewRecord> views;
    std::vector<ShadowTile> tiles;  ///< one a view
    int atlasWidth = 0, atlasHeight = 0;
    int shrunk = 0;  ///< how often tile sizes were halved to fit `maxAtlasSize`
};

/// Lays out `worldLights` (worldLight() applied). `bounds` are the scene's in world space; lights of a scene without
/// geometry get no views. `origin` is subtracted in double. `resolution`: tile size in texels of directional and spot
/// lights; half of it for a face of a point light, a quarter for a face of an area light's sample point. `filter`:
/// radius of the shadow filter in texels. `maxAtlasSize`: largest edge of the atlas; tiles are halved until they fit,
/// and DeviceError says so when even small ones do not.
///
/// Near plane: occluders nearer to a light than 1/2048 of the scene's diagonal are ignored, as are surfaces in the
/// plane of a rectangle light (an emissive panel does not shadow the light that stands for it).
LightLayout layoutLights(const std::vector<Light>& worldLights, const Bounds& bounds, const glm::dvec3& origin,
                         int resolution, double filter, int maxAtlasSize);

}  // namespace voxcone
