// Scenes built in code, for tests whose answer is known: shapes, pure materials, and a builder that places them.
#pragma once

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace voxcone::test {

/// Pure Lambert reflector: no Fresnel, no specular lobe. `emission` is radiance in W/(m² sr).
Material lambert(const glm::vec3& albedo, const glm::vec3& emission = glm::vec3(0));
/// The same, grey.
Material lambert(float albedo, float emission = 0);
/// Two-sided sheet of albedo 0.8 that scatters (0.5, 1, 0.2) times a quarter of the light to its other side.
Material greenLeaf();
/// Solid that transmits a tint of (1, 0.9, 0.8), of roughness 0.1 and thickness 0.6.
Material tintedGlass();
/// Directional light along +y, irradiance 2.
Light sunFromBelow();
/// glTF metallic-roughness material without emission; dielectric F0 = 0.04.
Material glossy(const glm::vec3& baseColor, float metallic, float roughness);

// Meshes in object space, metres, flat unit normals except on spheres, material 0. `closed` is set on all triangles of
// boxes, slabRoom, hollowBox and outward spheres, clear on all others.

/// Rectangle in the xz plane around the origin, facing +y, of `divisions`² cells. Has texture coordinates: u along +x,
/// v along +z.
Mesh quad(double sizeX, double sizeZ, int divisions = 1);
/// Disc in the xz plane around the origin, facing +y.
Mesh disc(double radius, int segments = 128);
/// Axis-aligned box around the origin, facing outwards.
Mesh box(const glm::dvec3& size);
/// Axis-aligned box around the origin, facing inwards: walls without thickness.
Mesh room(const glm::dvec3& size);
/// Sealed room of inner size `inner` with walls of `thickness` > 0: six outward closed boxes that touch and do not
/// overlap. The x and z walls stand between floor and ceiling, the z walls between the x walls.
Mesh slabRoom(const glm::dvec3& inner, double thickness);
/// The same solid as its boundary alone: an outward box of inner + 2·thickness around an inward box of `inner`.
Mesh hollowBox(const glm::dvec3& inner, double thickness);
/// Sphere around the origin with smooth normals: icosahedron, each triangle split in four `subdivisions` times,
/// vertices on the sphere (20·4^subdivisions triangles).
Mesh sphere(double radius, int subdivisions = 4);
/// The same seen from inside.
Mesh inwardSphere(double radius, int subdivisions = 4);
/// `second` appended to `first`; its attributes must be present in both or neither.
Mesh merged(const Mesh& first, const Mesh& second);

// Placements.

glm::dmat4 translation(const glm::dvec3& offset);
glm::dmat4 scaling(const glm::dvec3& factors);
/// Rotation by `degrees` about `axis` through the origin, counter-clockwise seen against the axis.
glm::dmat4 rotation(double degrees, const glm::dvec3& axis);
/// Rotation that takes +y to unit `direction`: lays a quad or disc along another normal.
glm::dmat4 yTo(const glm::dvec3& direction);

/// Collects placed objects; one material, mesh, node and instance each.
class SceneBuilder {
  public:
    SceneBuilder& add(Mesh mesh, const Material& material, const glm::dmat4& placement = glm::dmat4(1));
    SceneBuilder& light(const Light& light);
    SceneBuilder& sky(const glm::vec3& radiance);
    /// Moves everything that was added so far (objects and lights) by a rigid or uniformly scaling matrix;
    /// sizes of lights follow, their intensities do not.
    SceneBuilder& transform(const glm::dmat4& matrix);
    /// The scene so far.
    Scene build() const { return scene_; }

  private:
    Scene scene_;
};

/// A scene of one object under constant sky radiance.
Scene oneObject(Mesh mesh, const Material& material, const glm::dmat4& placement = glm::dmat4(1),
                const glm::vec3& skyRadiance = glm::vec3(0));

/// World-space camera.
Camera camera(const glm::dvec3& position, const glm::dvec3& target, double verticalFovDeg = 45,
              const glm::dvec3& up = glm::dvec3(0, 1, 0));

}  // namespace voxcone::test
