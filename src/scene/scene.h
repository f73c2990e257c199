// The scene as plain CPU data: what the renderer and the path tracer both read. Right-handed, y up, metres, linear Rec.
// 709 radiometric values. Nothing here knows OpenGL.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene/track.h"

namespace voxcone {

enum class Wrap : int { repeat, mirrored_repeat, clamp_to_edge };
enum class AlphaMode : int { opaque, mask, blend };
/// How cones add up the surfaces of a material: `solid` as parts of walls, `leaves` as scattered by chance. automatic:
/// leaves where some of the material lets light through by its alpha (Scene::isLeaves).
enum class Matter : int { automatic, solid, leaves };

/// Decoded image: `width`×`height` texels of 4 components, row 0 on top (v = 0, as in glTF). Eight bits a component;
/// whether RGB is sRGB or linear is decided by the slot of the material that uses it.
struct Texture {
    std::string name;  ///< for messages: URI or "images[3]"
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba8;
    Wrap wrapS = Wrap::repeat, wrapT = Wrap::repeat;
    bool nearest = false;  ///< magnification filter is NEAREST
};

/// Use of a texture by a material slot; `texture` < 0 means none.
struct TextureSlot {
    int texture = -1;
    int texCoord = 0;                           ///< 0 or 1: index in Mesh::texCoords
    glm::mat3x2 uvTransform{1, 0, 0, 1, 0, 0};  ///< KHR_texture_transform: uv' = uvTransform · (u, v, 1)
};

/// glTF metallic-roughness material with the extensions that voxcone models or stores.
struct Material {
    std::string name;
    glm::vec4 baseColor{1};        ///< linear, alpha last
    TextureSlot baseColorTexture;  ///< sRGB
    float metallic = 1, roughness = 1;
    TextureSlot metallicRoughnessTexture;  ///< linear; G roughness, B metallic
    TextureSlot normalTexture;             ///< linear, tangent space
    float normalScale = 1;
    TextureSlot occlusionTexture;  ///< stored, unused: occlusion is what this program computes
    float occlusionStrength = 1;
    glm::vec3 emission{0};        ///< emissiveFactor × KHR_materials_emissive_strength, radiance W/(m² sr)
    TextureSlot emissionTexture;  ///< sRGB
    AlphaMode alphaMode = AlphaMode::opaque;
    float alphaCutoff = 0.5f;
    bool doubleSided = false;
    bool unlit = false;  ///< KHR_materials_unlit: base colour is emitted as is, nothing is reflected
    float transmission =
        0;  ///< KHR_materials_transmission: share of light that the base lets through, tinted by baseColor
    TextureSlot transmissionTexture;  ///< linear; R scales it
    float thickness = 0;              ///< KHR_materials_volume, metres in the mesh's space; 0 = thin sheet
    TextureSlot thicknessTexture;     ///< linear; G scales it
    float attenuationDistance = 0;    ///< metres after which light has attenuationColor left; 0 = clear
    glm::vec3 attenuationColor{1};
    float diffuseTransmission = 0;  ///< KHR_materials_diffuse_transmission: share of diffuse light that leaves behind
    TextureSlot diffuseTransmissionTexture;  ///< linear; A scales it
    glm::vec3 diffuseTransmissionColor{1};
    TextureSlot diffuseTransmissionColorTexture;  ///< sRGB
    float ior = 1.5f;                             ///< KHR_materials_ior; F0 = ((ior−1)/(ior+1))²
    float specularFactor = 1;    ///< KHR_materials_specular: scales dielectric F0 and F90; 0 = pure Lambert
    glm::vec3 specularColor{1};  ///< KHR_materials_specular: tints dielectric F0
    /// glTF extras "voxcone_matter".
    Matter matter = Matter::automatic;

    /// Its emission is that of analytic lights (scene/extract.h): it is seen, but voxels leave it out.
    bool extracted = false;

    bool emits() const { return emission.x > 0 || emission.y > 0 || emission.z > 0; }
    /// Some light passes through the surface, by either kind of transmission.
    bool transmits() const { return !unlit && metallic < 1 && (transmission > 0 || diffuseTransmission > 0); }
    /// Beer-Lambert coefficient of the medium inside, 1/m: light keeps exp(−absorption·distance). A colour of 0 counts
    /// as a millionth.
    glm::vec3 absorption() const {
        if (attenuationDistance <= 0) return glm::vec3(0);
        return -glm::log(glm::max(attenuationColor, glm::vec3(1e-6f))) / attenuationDistance;
    }
};

/// What a weight of 1 adds to a mesh's vertices (glTF morph target). Arrays have the size of Mesh::positions, or are
/// empty for no change; tangents change without their handedness.
struct MorphTarget {
    std::vector<glm::vec3> positions, normals, tangents;
};

/// One glTF primitive as an indexed triangle list in object space. All per-vertex arrays have the size of `positions`.
struct Mesh {
    std::string name;  ///< "meshes[2].primitives[0]" with the mesh's name, for messages
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;   ///< unit; made from the faces when the file has none (flat)
    std::vector<glm::vec4> tangents;  ///< w = handedness ±1; empty unless the material has a normal map
    std::array<std::vector<glm::vec2>, 2> texCoords;  ///< empty where no texture of the material uses the set
    std::vector<glm::vec4> colors;                    ///< linear COLOR_0; empty means white
    std::vector<std::uint32_t> indices;               ///< 3 a triangle, all in range, counter-clockwise front
    int material = 0;                                 ///< index in Scene::materials, always valid
    bool flatNormals = false;  ///< normals are those of the faces: no two triangles share a vertex
    /// Joints that carry a vertex, as indices in Skin::joints, and their weights, which add up to 1. Empty for meshes
    /// without a skin.
    std::vector<std::array<std::uint16_t, 4>> joints;
    std::vector<glm::vec4> jointWeights;
    std::vector<MorphTarget> morphTargets;
    std::vector<float> morphWeights;  ///< one a target: where neither node nor animation says otherwise
    /// One a triangle, in the mesh as it is without skin and morph targets: 1 when the triangle belongs to a
    /// watertight, outward-oriented part (welded by position), whose inside light can never see; 0 for sheets and
    /// anything open. Voxelization stores one side of the former, both of the latter.
    std::vector<std::uint8_t> closed;
};

/// Scene graph node. World transforms are computed in double: origins may be 1e6 away.
struct Node {
    std::string name;
    int fileIndex = -1;         ///< in the file's "nodes"
    int parent = -1;            ///< always smaller than the node's own index
    glm::dmat4 localMatrix{1};  ///< used when `hasMatrix`, otherwise translation · rotation · scale
    bool hasMatrix = false;
    glm::dvec3 translation{0};
    glm::dquat rotation{1, 0, 0, 0};
    glm::dvec3 scale{1};
    std::vector<float> morphWeights;  ///< of the node's mesh; empty = the mesh's own
};

/// Nodes that carry the vertices of a mesh.
struct Skin {
    std::string name;
    std::vector<int> joints;                      ///< indices in Scene::nodes, at least one
    std::vector<glm::dmat4> inverseBindMatrices;  ///< one a joint: from the mesh's space to the joint's
};

/// A mesh placed by a node, or by the joints of a skin, which make the node's own transform meaningless.
struct Instance {
    int mesh = 0;
    int node = 0;
    int skin = -1;  ///< index in Scene::skins; only for meshes with joints
};

/// Changes of a light over time, in the space that the light is given in; what has no keys stays as it is.
struct LightTrack {
    Track position;   ///< metres
    Track direction;  ///< of any length above 0
    Track intensity;  ///< of the light's own unit; values below 0 count as 0
    bool operator==(const LightTrack&) const = default;
};

enum class LightType : int { directional, point, spot, sphere, rectangle };

/// Analytic light. Position and frame are in world space when `node` < 0, else in that node's space.
/// Emission along −z of the light's frame for directional, spot and rectangle, as in KHR_lights_punctual.
struct Light {
    std::string name;
    LightType type = LightType::point;
    /// directional: irradiance on a facing plane, W/m². point, spot: radiant intensity, W/sr. sphere: total radiant
    /// intensity W/sr seen from far away (radiance = intensity / (π radius²)). rectangle: radiance, W/(m² sr),
    /// one-sided.
    glm::vec3 intensity{1};
    int node = -1;
    glm::dvec3 position{0};
    glm::dvec3 direction{0, -1, 0};  ///< unit, the way the light travels
    glm::dvec3 up{0, 0, 1};          ///< rectangle: unit, along its height; perpendicular to direction
    double range = 0;                ///< KHR_lights_punctual range in metres, 0 = unlimited
    double innerConeAngle = 0, outerConeAngle = 0.7853981633974483;  ///< spot, half-angles in radians
    double radius = 0;                                               ///< sphere, metres
    double angularRadius = 0;      ///< directional: radians, the disc that is seen in the sky; 0 = a point of it
    double width = 0, height = 0;  ///< rectangle, metres
    LightTrack track;
    /// Stands for part of the panorama or for an emitting mesh (scene/extract.h), which the path tracer samples
    /// instead.
    bool extracted = false;
    bool operator==(const Light&) const = default;
};

/// Perspective camera looking along −z of its frame. In world space when `node` < 0.
struct Camera {
    std::string name;
    int node = -1;
    glm::dvec3 position{0};
    glm::dvec3 target{0, 0, -1};
    glm::dvec3 up{0, 1, 0};
    double verticalFovDeg = 45;
    double near = 0;  ///< metres; 0 = chosen from the scene's size
    double far = 0;
};

/// Light from infinity: constant radiance, or an equirectangular panorama (row 0 = +y, column centre = −z, x to the
/// right).
struct Environment {
    glm::vec3 color{0};  ///< radiance; multiplies the image when there is one
    int width = 0, height = 0;
    std::vector<glm::vec3> radiance;  ///< width·height texels or empty
    /// What of `radiance` analytic lights leave to cones (scene/extract.h); empty = all of it.
    std::vector<glm::vec3> residual;
    double rotationDeg = 0;  ///< about +y, counter-clockwise seen from above
    bool black() const { return color.x <= 0 && color.y <= 0 && color.z <= 0; }
};

enum class AnimatedProperty : int { translation, rotation, scale, morph_weights };

/// One glTF animation channel with its sampler.
struct AnimationChannel {
    int node = 0;
    AnimatedProperty property = AnimatedProperty::translation;
    Interpolation interpolation = Interpolation::linear;  ///< linear, step or cubic_spline
    std::vector<double> times;                            ///< seconds, strictly increasing
    std::vector<glm::vec4>
        values;  ///< one a key, three (in-tangent, value, out-tangent) for cubic splines; xyz or xyzw
    /// For morph_weights instead of `values`: the same with as many numbers for each value as there are targets.
    std::vector<float> weights;
};

struct Animation {
    std::string name;
    std::vector<AnimationChannel> channels;
};

struct Bounds {
    glm::dvec3 min{1e300}, max{-1e300};
    bool empty() const { return min.x > max.x; }
    void add(const glm::dvec3& p) { min = glm::min(min, p), max = glm::max(max, p); }
    glm::dvec3 size() const { return empty() ? glm::dvec3(0) : max - min; }
    glm::dvec3 center() const { return empty() ? glm::dvec3(0) : 0.5 * (min + max); }
};

/// Box around the eight corners of `box` under `matrix`; empty for an empty box.
Bounds transformed(const Bounds& box, const glm::dmat4& matrix);

/// What bends an instance's mesh at some time: for scene/deform.h. Both empty for a rigid instance.
struct Deformation {
    std::vector<float> weights;      ///< one a morph target
    std::vector<glm::dmat4> joints;  ///< one a joint of the skin: from the mesh's space to that of the instance
    bool rigid() const { return weights.empty() && joints.empty(); }
    bool operator==(const Deformation&) const = default;
};

/// Where everything is at some time.
struct Pose {
    std::vector<glm::dmat4> nodes;          ///< world matrix of every node
    std::vector<glm::dmat4> instances;      ///< from the space of the instance's (deformed) vertices to the world
    std::vector<Deformation> deformations;  ///< one an instance
};

struct Scene {
    std::filesystem::path file;
    std::vector<Texture> textures;
    std::vector<Material>
        materials;  ///< never empty once loaded: the default material is last when a primitive needs it
    std::vector<Mesh> meshes;
    std::vector<Node> nodes;  ///< parents before children
    std::vector<Skin> skins;
    std::vector<Instance> instances;
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    std::vector<Animation> animations;
    Environment environment;

    /// World matrix of every node at `time` seconds (all animations applied together), in double.
    std::vector<glm::dmat4> worldMatrices(double time = 0) const;

    /// Nodes and instances at `time`. The space of a skinned instance moves with the skin's first joint: only its
    /// place (and mirroring), so that floats are precise far away.
    Pose pose(double time = 0) const;

    /// World bounds of all instances at `time`; empty for a scene without triangles.
    Bounds bounds(double time = 0) const;

    /// Box that holds the scene at every time of its animations: at all keys and at up to 16 times from one to the
    /// next, fewer where there are thousands of keys or millions of vertices to deform. Equals bounds() where nothing
    /// moves.
    Bounds motionBounds() const;

    /// World lights at `time`: lightAt() and the nodes' transforms applied.
    std::vector<Light> lightsAt(double time = 0) const;

    /// One an instance: 1 where an animation drives its morph weights, or its node or one of its joints or an ancestor
    /// of these.
    std::vector<std::uint8_t> movingInstances() const;

    /// Whether cones take the surfaces of a material for leaves, as Matter says.
    bool isLeaves(const Material& material) const;

    /// Triangles over all instances.
    std::size_t triangleCount() const;
};

/// `light` as its track has it at `time` seconds, without a track. `up` turns with the direction by the shortest way.
Light lightAt(const Light& light, double time);

/// A light or camera with its node's transform applied. Intensities do not change with scale, sizes do.
Light worldLight(const Light& light, const std::vector<glm::dmat4>& worldMatrices);
Camera worldCamera(const Camera& camera, const std::vector<glm::dmat4>& worldMatrices);

/// World-to-view matrix (camera at the origin looking along −z), translation in double.
glm::dmat4 viewMatrix(const Camera& worldCamera);

}  // namespace voxcone
