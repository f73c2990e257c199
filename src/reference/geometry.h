// The scene's triangles in an Embree BVH, and what their materials are at a hit. All lengths here are in a space of our
// own: the bounds' centre is its origin and its unit a power of two times the metre that makes the bounds fit in [−1,
// 1]³, so that neither size nor place of a scene costs precision.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <deque>
#include <glm/glm.hpp>
#include <vector>

#include "scene/brdf.h"
#include "scene/deform.h"
#include "scene/scene.h"

namespace voxcone {

/// World to path tracing space and back.
struct TracingSpace {
    glm::dvec3 origin{0};
    double scale = 1;         ///< a power of two
    glm::vec3 halfExtent{0};  ///< of the scene's bounds, in tracing space

    glm::vec3 fromWorld(const glm::dvec3& p) const { return glm::vec3((p - origin) * scale); }
    glm::dvec3 toWorld(const glm::vec3& p) const { return origin + glm::dvec3(p) / scale; }
};

/// A point on a triangle.
struct Hit {
    std::uint32_t instance = 0, triangle = 0;
    float u = 0, v = 0;  ///< weights of the triangle's second and third vertex
    float distance = 0;
    glm::vec3 position{0};
    glm::vec3 normal{0};  ///< unit, of the plane, on the front side
    float offset = 0;     ///< how far off the plane a ray must start to leave the triangle behind
};

/// Material at a hit, seen from one side.
struct Shading {
    Surface surface;  ///< all zero for unlit materials
    Transmission transmission;
    bool solid = false;  ///< bounds a medium: a closed body with a thickness; else light that passes meets a thin sheet
    bool inside = false;  ///< the viewer is in that medium
    glm::vec3 baseColor{0};
    glm::vec3 emission{0};     ///< radiance towards the viewer, before transparency
    float coverage = 1;        ///< probability that a ray stops here: alpha of BLEND, 0 or 1 of MASK
    glm::vec3 planeNormal{0};  ///< of the triangle, on the viewer's side
    glm::vec3 normal{0};       ///< interpolated and normal mapped, within the viewer's hemisphere of the plane
};

class Geometry {
  public:
    /// `scene` must outlive this object.
    Geometry(const Scene& scene, double time);
    ~Geometry();
    Geometry(const Geometry&) = delete;
    Geometry& operator=(const Geometry&) = delete;

    const TracingSpace& space() const { return space_; }

    enum class RayKind { camera, light };
    /// Nearest hit along unit `direction` between `nearDistance` and `farDistance`. Camera rays pass through the backs
    /// of single-sided materials. `seed` decides where rays pass through transparent materials.
    bool intersect(RayKind kind, const glm::vec3& origin, const glm::vec3& direction, float nearDistance,
                   float farDistance, std::uint32_t seed, Hit& hit) const;
    /// Whether anything lies on `origin` + t·`direction`, 0 < t < `far`.
    bool occluded(const glm::vec3& origin, const glm::vec3& direction, float far, std::uint32_t seed) const;

    /// What transmitting surfaces on `origin` + t·`direction`, 0 < t < `far`, leave of the light of an analytic light
    /// there, which goes straight (straightTransmittance, and absorption inside of solids): 0 where anything else lies,
    /// 1 where nothing does.
    glm::vec3 transmittance(const glm::vec3& origin, const glm::vec3& direction, float far, std::uint32_t seed) const;

    /// Material at `hit` as seen along unit `toViewer`.
    Shading shade(const Hit& hit, const glm::vec3& toViewer) const;

    /// A point of a triangle by barycentric weights.
    Hit pointOn(std::uint32_t instance, std::uint32_t triangle, float u, float v) const;

    /// How far off its plane a ray from `position` must start; `magnitude` bounds the coordinates in the plane.
    static float offset(const glm::vec3& position, const glm::vec3& normal, const glm::vec3& magnitude);

    std::size_t instanceCount() const { return instances_.size(); }
    std::size_t triangleCount(std::size_t instance) const { return instances_[instance].mesh->indices.size() / 3; }
    const Material& material(std::size_t instance) const { return *instances_[instance].material; }
    float area(std::uint32_t instance, std::uint32_t triangle) const;

  private:
    struct Instance {
        const Geometry* owner = nullptr;
        const Mesh* mesh = nullptr;
        const Material* material = nullptr;
        const glm::vec3* positions = nullptr;             ///< in tracing space; memory is Embree's
        const std::vector<glm::vec3>* normals = nullptr;  ///< of the mesh, or deformed
        const std::vector<glm::vec4>* tangents = nullptr;
        glm::mat3 direction{1};  ///< of tangents
        glm::mat3 normal{1};     ///< cofactors of the above, turned to keep the outside out
        bool mirrored = false;
        float scale = 1;  ///< mean length in the world of a unit of the mesh
    };

    static void filterTransparent(const RTCFilterFunctionNArguments* arguments);
    static void filterCamera(const RTCFilterFunctionNArguments* arguments);

    glm::vec4 texel(const TextureSlot& slot, const Mesh& mesh, const glm::uvec3& corners, const glm::vec3& weights,
                    bool srgb) const;
    glm::vec4 baseColor(const Instance& instance, const glm::uvec3& corners, const glm::vec3& weights) const;
    static float coverage(const Material& material, float alpha);
    static glm::uvec3 corners(const Mesh& mesh, std::uint32_t triangle);
    static glm::vec3 planeNormal(const Instance& instance, const glm::uvec3& corners);

    const Scene* scene_;
    TracingSpace space_;
    RTCDevice device_ = nullptr;
    RTCScene bvh_ = nullptr;
    std::vector<Instance> instances_;
    std::deque<DeformedVertices> deformed_;  ///< of instances that are not rigid
    bool anyTransmission_ = false;
};

}  // namespace voxcone
