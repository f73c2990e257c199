#include "reference/geometry.h"

#include <array>
#include <cmath>
#include <limits>

#include "core/check.h"
#include "reference/sampler.h"

namespace voxcone {
namespace {

// Sixteen roundings of a coordinate: what interpolation, transformation and Embree's intersection add up to.
constexpr float kPositionError = 1e-6f;

struct RayContext {
    RTCIntersectContext base;  // first, as Embree hands out a pointer to it
    std::uint32_t seed;
};

const std::array<float, 256> kLinearFromSrgb8 = [] {
    std::array<float, 256> table{};
    for (std::size_t k = 0; k < table.size(); ++k) {
        const double s = static_cast<double>(k) / 255;
        table[k] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return table;
}();

/// The two texels around a coordinate along one axis, and the weight of the second.
struct TexelPair {
    int first, second;
    float weight;
};

TexelPair texelPair(float coordinate, int size, Wrap wrap, bool nearest) {
    float t = coordinate;
    switch (wrap) {
        case Wrap::repeat:
            t -= std::floor(t);
            break;
        case Wrap::mirrored_repeat:
            t -= 2 * std::floor(0.5f * t);
            break;
        case Wrap::clamp_to_edge:
            t = std::min(t, 1.0f);
            break;
    }
    if (!(t >= 0)) t = 0;  // negative under clamping, NaN of an infinite coordinate
    const float p = t * static_cast<float>(size) - (nearest ? 0.0f : 0.5f), low = std::floor(p);
    const auto fold = [&](int k) {
        const int period = wrap == Wrap::mirrored_repeat ? 2 * size : size;
        if (wrap == Wrap::clamp_to_edge) return std::clamp(k, 0, size - 1);
        if (k < 0) k += period;
        if (k >= period) k -= period;
        return k < size ? k : 2 * size - 1 - k;
    };
    const int k = static_cast<int>(low);
    return {fold(k), fold(k + 1), nearest ? 0.0f : p - low};
}

// Level 0, bilinear unless the texture asks for nearest.
glm::vec4 sampleTexture(const Texture& texture, const glm::vec2& uv, bool srgb) {
    const TexelPair x = texelPair(uv.x, texture.width, texture.wrapS, texture.nearest);
    const TexelPair y = texelPair(uv.y, texture.height, texture.wrapT, texture.nearest);
    glm::vec4 sum(0);
    const auto add = [&](int column, int row, float weight) {
        const std::uint8_t* p =
            texture.rgba8.data() + 4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(texture.width) +
                                        static_cast<std::size_t>(column));
        const float byte = weight / 255;
        if (srgb)
            sum += glm::vec4(weight * kLinearFromSrgb8[p[0]], weight * kLinearFromSrgb8[p[1]],
                             weight * kLinearFromSrgb8[p[2]], byte * static_cast<float>(p[3]));
        else
            sum += byte * glm::vec4(p[0], p[1], p[2], p[3]);
    };
    add(x.first, y.first, (1 - x.weight) * (1 - y.weight));
    if (texture.nearest) return sum;
    add(x.second, y.first, x.weight * (1 - y.weight));
    add(x.first, y.second, (1 - x.weight) * y.weight);
    add(x.second, y.second, x.weight * y.weight);
    return sum;
}

template <class T>
T interpolate(const std::vector<T>& values, const glm::uvec3& corners, const glm::vec3& weights) {
    return weights.x * values[corners.x] + weights.y * values[corners.y] + weights.z * values[corners.z];
}

glm::vec3 unitOr(const glm::vec3& v, const glm::vec3& fallback) {
    const float length2 = glm::dot(v, v);
    return length2 > 1e-30f ? v / std::sqrt(length2) : fallback;
}

}  // namespace

Geometry::Geometry(const Scene& scene, double time) : scene_(&scene) {
    const Pose pose = scene.pose(time);
    const Bounds bounds = scene.bounds(time);
    space_.origin = bounds.center();
    const glm::dvec3 half = 0.5 * bounds.size();
    const double extent = std::max(half.x, std::max(half.y, half.z));
    if (extent > 0) space_.scale = std::exp2(-std::ceil(std::log2(extent)));
    space_.halfExtent = glm::vec3(half * space_.scale);

    device_ = rtcNewDevice(nullptr);
    VOXCONE_CHECK(device_ != nullptr, "Embree error {}", static_cast<int>(rtcGetDeviceError(nullptr)));
    bvh_ = rtcNewScene(device_);
    // Robust: rays must not slip between neighbouring triangles of a sealed room.
    rtcSetSceneFlags(bvh_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
    instances_.reserve(scene.instances.size());
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const voxcone::Instance& placed = scene.instances[i];
        const Mesh& mesh = scene.meshes[static_cast<std::size_t>(placed.mesh)];
        const Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
        const glm::dmat4& world = pose.instances[i];
        if (!pose.deformations[i].rigid()) deformed_.push_back(deform(mesh, pose.deformations[i]));
        const DeformedVertices* deformed = pose.deformations[i].rigid() ? nullptr : &deformed_.back();
        const std::vector<glm::vec3>& objectPositions = deformed ? deformed->positions : mesh.positions;

        Instance instance;
        instance.owner = this;
        instance.mesh = &mesh;
        instance.normals = deformed ? &deformed->normals : &mesh.normals;
        instance.tangents = deformed ? &deformed->tangents : &mesh.tangents;
        instance.material = &material;
        const glm::dmat3 linear(world);
        const glm::dmat3 unscaled = linear * space_.scale;
        instance.direction = glm::mat3(unscaled);
        instance.mirrored = glm::determinant(unscaled) < 0;
        instance.scale = static_cast<float>(std::cbrt(std::abs(glm::determinant(linear))));
        anyTransmission_ |= material.transmits();
        const double side = instance.mirrored ? -1 : 1;
        instance.normal = glm::mat3(glm::dmat3(side * glm::cross(unscaled[1], unscaled[2]),
                                               side * glm::cross(unscaled[2], unscaled[0]),
                                               side * glm::cross(unscaled[0], unscaled[1])));

        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* positions = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), mesh.positions.size()));
        auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.indices.size() / 3));
        VOXCONE_CHECK(mesh.indices.empty() || (positions != nullptr && indices != nullptr), "Embree error {}",
                      static_cast<int>(rtcGetDeviceError(device_)));
        for (std::size_t k = 0; k < objectPositions.size(); ++k)
            positions[k] = space_.fromWorld(glm::dvec3(world * glm::dvec4(glm::dvec3(objectPositions[k]), 1)));
        std::copy(mesh.indices.begin(), mesh.indices.end(), indices);
        instance.positions = positions;
        instances_.push_back(instance);  // never reallocates: Embree keeps its address

        rtcSetGeometryUserData(geometry, &instances_.back());
        if (material.alphaMode != AlphaMode::opaque) {
            rtcSetGeometryIntersectFilterFunction(geometry, &Geometry::filterTransparent);
            rtcSetGeometryOccludedFilterFunction(geometry, &Geometry::filterTransparent);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(bvh_, geometry, static_cast<unsigned>(instances_.size() - 1));
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(bvh_);
    const RTCError error = rtcGetDeviceError(device_);
    VOXCONE_CHECK(error == RTC_ERROR_NONE, "Embree error {}", static_cast<int>(error));
}

Geometry::~Geometry() {
    rtcReleaseScene(bvh_);
    rtcReleaseDevice(device_);
}

glm::uvec3 Geometry::corners(const Mesh& mesh, std::uint32_t triangle) {
    const std::size_t k = 3 * static_cast<std::size_t>(triangle);
    return {mesh.indices[k], mesh.indices[k + 1], mesh.indices[k + 2]};
}

glm::vec3 Geometry::planeNormal(const Instance& instance, const glm::uvec3& corners) {
    const glm::vec3 a = instance.positions[corners.x];
    const glm::vec3 n = glm::cross(instance.positions[corners.y] - a, instance.positions[corners.z] - a);
    return instance.mirrored ? -n : n;
}

float Geometry::coverage(const Material& material, float alpha) {
    switch (material.alphaMode) {
        case AlphaMode::mask:
            return alpha < material.alphaCutoff ? 0.0f : 1.0f;
        case AlphaMode::blend:
            return glm::clamp(alpha, 0.0f, 1.0f);
        default:
            return 1;
    }
}

void Geometry::filterTransparent(const RTCFilterFunctionNArguments* arguments) {
    const auto& instance = *static_cast<const Instance*>(arguments->geometryUserPtr);
    const std::uint32_t triangle = RTCHitN_primID(arguments->hit, 1, 0);
    const float u = RTCHitN_u(arguments->hit, 1, 0), v = RTCHitN_v(arguments->hit, 1, 0);
    const float alpha =
        instance.owner->baseColor(instance, corners(*instance.mesh, triangle), glm::vec3(1 - u - v, u, v)).a;
    const float stops = coverage(*instance.material, alpha);
    if (stops >= 1) return;
    // One decision a ray and triangle, however often the BVH offers the pair.
    const std::uint32_t seed = reinterpret_cast<const RayContext*>(arguments->context)->seed;
    const std::uint32_t geometry = RTCHitN_geomID(arguments->hit, 1, 0);
    if (unitFloat(hashCombine(hashCombine(seed, geometry), triangle)) >= stops) arguments->valid[0] = 0;
}

void Geometry::filterCamera(const RTCFilterFunctionNArguments* arguments) {
    const auto& instance = *static_cast<const Instance*>(arguments->geometryUserPtr);
    if (instance.material->doubleSided) return;
    const glm::vec3 direction(RTCRayN_dir_x(arguments->ray, 1, 0), RTCRayN_dir_y(arguments->ray, 1, 0),
                              RTCRayN_dir_z(arguments->ray, 1, 0));
    const glm::uvec3 triangle = corners(*instance.mesh, RTCHitN_primID(arguments->hit, 1, 0));
    if (glm::dot(planeNormal(instance, triangle), direction) > 0) arguments->valid[0] = 0;
}

bool Geometry::intersect(RayKind kind, const glm::vec3& origin, const glm::vec3& direction, float nearDistance,
                         float farDistance, std::uint32_t seed, Hit& hit) const {
    RayContext context;
    rtcInitIntersectContext(&context.base);
    context.seed = seed;
    if (kind == RayKind::camera) context.base.filter = &Geometry::filterCamera;
    RTCRayHit query{};
    query.ray.org_x = origin.x;
    query.ray.org_y = origin.y;
    query.ray.org_z = origin.z;
    query.ray.dir_x = direction.x;
    query.ray.dir_y = direction.y;
    query.ray.dir_z = direction.z;
    query.ray.tnear = nearDistance;
    query.ray.tfar = farDistance;
    query.ray.mask = ~0u;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(bvh_, &context.base, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit = pointOn(query.hit.geomID, query.hit.primID, query.hit.u, query.hit.v);
    hit.distance = query.ray.tfar;
    return true;
}

bool Geometry::occluded(const glm::vec3& origin, const glm::vec3& direction, float far, std::uint32_t seed) const {
    RayContext context;
    rtcInitIntersectContext(&context.base);
    context.seed = seed;
    RTCRay ray{};
    ray.org_x = origin.x;
    ray.org_y = origin.y;
    ray.org_z = origin.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = far;
    ray.mask = ~0u;
    rtcOccluded1(bvh_, &context.base, &ray);
    return ray.tfar < 0;
}

glm::vec3 Geometry::transmittance(const glm::vec3& origin, const glm::vec3& direction, float far,
                                  std::uint32_t seed) const {
    if (!anyTransmission_) return glm::vec3(occluded(origin, direction, far, seed) ? 0.0f : 1.0f);
    constexpr int kMostSurfaces = 256;
    const float length = glm::length(direction);
    const float metres = static_cast<float>(static_cast<double>(length) / space_.scale);
    glm::vec3 result(1);
    float near = 0, entered = 0;
    for (int surfaces = 0; surfaces < kMostSurfaces; ++surfaces) {
        Hit hit;
        if (!intersect(RayKind::light, origin, direction, near, far, seed, hit)) return result;
        const Shading shading = shade(hit, -direction / length);
        result *= straightTransmittance(shading.surface, shading.transmission,
                                        std::abs(glm::dot(shading.normal, direction)) / length);
        if (shading.inside) result *= glm::exp(-shading.transmission.absorption * ((hit.distance - entered) * metres));
        if (!(maxComponent(result) > 0)) return glm::vec3(0);
        entered = hit.distance;
        near = hit.distance * (1 + kPositionError) + hit.offset / length;
    }
    return glm::vec3(0);
}

Hit Geometry::pointOn(std::uint32_t instanceIndex, std::uint32_t triangle, float u, float v) const {
    const Instance& instance = instances_[instanceIndex];
    const glm::uvec3 c = corners(*instance.mesh, triangle);
    const glm::vec3 &p0 = instance.positions[c.x], &p1 = instance.positions[c.y], &p2 = instance.positions[c.z];
    Hit hit;
    hit.instance = instanceIndex;
    hit.triangle = triangle;
    hit.u = u;
    hit.v = v;
    hit.position = (1 - u - v) * p0 + u * p1 + v * p2;
    hit.normal = unitOr(planeNormal(instance, c), glm::vec3(0, 1, 0));
    const glm::vec3 magnitude = glm::max(glm::abs(p0), glm::max(glm::abs(p1), glm::abs(p2)));
    hit.offset = offset(hit.position, hit.normal, magnitude);
    return hit;
}

float Geometry::offset(const glm::vec3& position, const glm::vec3& normal, const glm::vec3& magnitude) {
    // The first term is the error across the plane, the second keeps a ray off planes through the origin.
    return kPositionError * (glm::dot(glm::abs(normal), magnitude) + 1e-3f * maxComponent(glm::abs(position)));
}

float Geometry::area(std::uint32_t instance, std::uint32_t triangle) const {
    return 0.5f * glm::length(planeNormal(instances_[instance], corners(*instances_[instance].mesh, triangle)));
}

glm::vec4 Geometry::texel(const TextureSlot& slot, const Mesh& mesh, const glm::uvec3& corners,
                          const glm::vec3& weights, bool srgb) const {
    if (slot.texture < 0) return glm::vec4(1);
    const auto& coordinates = mesh.texCoords[static_cast<std::size_t>(slot.texCoord)];
    const glm::vec2 uv = coordinates.empty() ? glm::vec2(0) : interpolate(coordinates, corners, weights);
    return sampleTexture(scene_->textures[static_cast<std::size_t>(slot.texture)], slot.uvTransform * glm::vec3(uv, 1),
                         srgb);
}

glm::vec4 Geometry::baseColor(const Instance& instance, const glm::uvec3& corners, const glm::vec3& weights) const {
    const Mesh& mesh = *instance.mesh;
    glm::vec4 color =
        instance.material->baseColor * texel(instance.material->baseColorTexture, mesh, corners, weights, true);
    if (!mesh.colors.empty()) color *= interpolate(mesh.colors, corners, weights);
    return color;
}

Shading Geometry::shade(const Hit& hit, const glm::vec3& toViewer) const {
    const Instance& instance = instances_[hit.instance];
    const Mesh& mesh = *instance.mesh;
    const Material& material = *instance.material;
    const glm::uvec3 c = corners(mesh, hit.triangle);
    const glm::vec3 weights(1 - hit.u - hit.v, hit.u, hit.v);

    Shading shading;
    const glm::vec4 color = baseColor(instance, c, weights);
    shading.baseColor = glm::vec3(color);
    shading.coverage = coverage(material, color.a);

    const bool front = glm::dot(hit.normal, toViewer) >= 0;
    const bool emits = front || material.doubleSided;
    if (material.unlit) {
        if (emits) shading.emission = shading.baseColor;
    } else {
        const glm::vec4 rough = texel(material.metallicRoughnessTexture, mesh, c, weights, false);
        shading.surface = surfaceFromMaterial(shading.baseColor, glm::clamp(material.metallic * rough.b, 0.0f, 1.0f),
                                              glm::clamp(material.roughness * rough.g, 0.0f, 1.0f), material.ior,
                                              material.specularFactor, material.specularColor);
        if (emits && material.emits())
            shading.emission = material.emission * glm::vec3(texel(material.emissionTexture, mesh, c, weights, true));
        if (material.transmits()) {
            const float dielectric = 1 - glm::clamp(material.metallic * rough.b, 0.0f, 1.0f);
            const float beam = material.transmission * texel(material.transmissionTexture, mesh, c, weights, false).r;
            const float scattered =
                material.diffuseTransmission * texel(material.diffuseTransmissionTexture, mesh, c, weights, false).a;
            shading.transmission.color = shading.baseColor * (beam * dielectric);
            shading.transmission.diffuseColor =
                material.diffuseTransmissionColor *
                glm::vec3(texel(material.diffuseTransmissionColorTexture, mesh, c, weights, true)) *
                (scattered * (1 - beam) * dielectric);
            shading.surface.diffuseColor *= (1 - beam) * (1 - scattered);
            if (material.thickness > 0) {
                if (!mesh.closed.empty() && mesh.closed[hit.triangle] != 0) {
                    shading.solid = true;
                    shading.inside = !front;
                    shading.transmission.ior = std::max(material.ior, 1.0f);
                    shading.transmission.absorption = material.absorption();
                } else {
                    const float thickness = material.thickness * instance.scale *
                                            texel(material.thicknessTexture, mesh, c, weights, false).g;
                    shading.transmission.color *= glm::exp(-material.absorption() * thickness);
                }
            }
        }
    }

    const float side = front ? 1.0f : -1.0f;
    shading.planeNormal = side * hit.normal;
    glm::vec3 normal = unitOr(instance.normal * interpolate(*instance.normals, c, weights), hit.normal);
    if (material.normalTexture.texture >= 0 && !instance.tangents->empty()) {
        const glm::vec4 tangent = interpolate(*instance.tangents, c, weights);
        glm::vec3 t = instance.direction * glm::vec3(tangent);
        t = unitOr(t - normal * glm::dot(normal, t), glm::vec3(0));
        const float handedness = (tangent.w < 0) != instance.mirrored ? -1.0f : 1.0f;
        const glm::vec3 b = handedness * glm::cross(normal, t);
        glm::vec3 map = 2.0f * glm::vec3(texel(material.normalTexture, mesh, c, weights, false)) - 1.0f;
        map *= glm::vec3(material.normalScale, material.normalScale, 1);
        normal = unitOr(map.x * t + map.y * b + map.z * normal, normal);
    }
    normal *= side;
    // A normal that leans behind its own triangle says nothing about light in front of it.
    shading.normal = glm::dot(normal, shading.planeNormal) > 0 ? normal : shading.planeNormal;
    return shading;
}

}  // namespace voxcone
