#include "gl/gpu_scene.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/check.h"
#include "core/error.h"
#include "gl/alpha_mips.h"
#include "gl/bindings.h"
#include "scene/deform.h"

namespace voxcone::gl {
namespace {

struct Vertex {
    glm::vec3 position, normal;
    glm::vec4 tangent;
    glm::vec2 texCoord0, texCoord1;
    glm::vec4 color;
};
static_assert(sizeof(Vertex) == 18 * sizeof(float));

/// Twin of Object in shaders/shared/objects.glsl.
struct GpuObject {
    glm::mat4 worldFromObject, normalFromObject;
    glm::vec4 mirror;
};

/// Twin of Material in shaders/shared/material.glsl.
struct GpuMaterial {
    glm::vec4 baseColor, emission, metallicRoughness, specular, transmission, absorption, diffuseTransmission;
    std::array<glm::vec4, 2 * kMaterialUnits> uvTransform;
    std::array<glm::ivec4, kMaterialUnits / 4> texCoord;
    glm::ivec4 flags;
};

/// Appends the vertices of `mesh`, deformed ones in their place.
void appendVertices(std::vector<Vertex>& vertices, const Mesh& mesh, const std::vector<glm::vec3>& positions,
                    const std::vector<glm::vec3>& normals, const std::vector<glm::vec4>& tangents) {
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const auto uv = [&](std::size_t set) {
            return mesh.texCoords[set].empty() ? glm::vec2(0) : mesh.texCoords[set][v];
        };
        vertices.push_back({positions[v], normals.empty() ? glm::vec3(0) : normals[v],
                            tangents.empty() ? glm::vec4(0) : tangents[v], uv(0), uv(1),
                            mesh.colors.empty() ? glm::vec4(1) : mesh.colors[v]});
    }
}

GLenum glWrap(Wrap wrap) {
    switch (wrap) {
        case Wrap::repeat:
            return GL_REPEAT;
        case Wrap::mirrored_repeat:
            return GL_MIRRORED_REPEAT;
        case Wrap::clamp_to_edge:
            return GL_CLAMP_TO_EDGE;
    }
    return GL_REPEAT;
}

/// Slots in the order of their texture units, with whether their colour is sRGB.
struct Slot {
    const TextureSlot* slot;
    int unit;
    bool srgb;
};
std::array<Slot, kMaterialUnits> slots(const Material& material) {
    return {{{&material.baseColorTexture, kBaseColorUnit, true},
             {&material.metallicRoughnessTexture, kMetallicRoughnessUnit, false},
             {&material.normalTexture, kNormalUnit, false},
             {&material.emissionTexture, kEmissionUnit, true},
             {&material.transmissionTexture, kTransmissionUnit, false},
             {&material.thicknessTexture, kThicknessUnit, false},
             {&material.diffuseTransmissionTexture, kDiffuseTransmissionUnit, false},
             {&material.diffuseTransmissionColorTexture, kDiffuseTransmissionColorUnit, true}}};
}

/// `box` under `worldFromObject`, wider by more than the floats of a shader, which computes positions relative to
/// `origin`, can be off: a few roundings of the largest term in the sum that makes a coordinate.
Bounds reach(const Bounds& box, const glm::dmat4& worldFromObject, const glm::dvec3& origin) {
    constexpr double kRounding = 1.0 / (1 << 20);  // 16 roundings
    const glm::dvec3 center = box.center(), half = 0.5 * box.size();
    const glm::dvec3 farthest = glm::max(glm::abs(box.min), glm::abs(box.max));
    Bounds result;
    for (int row = 0; row < 3; ++row) {
        double middle = worldFromObject[3][row], radius = 0, magnitude = std::abs(middle - origin[row]);
        for (int column = 0; column < 3; ++column) {
            const double factor = worldFromObject[column][row];
            middle += factor * center[column];
            radius += std::abs(factor) * half[column];
            magnitude += std::abs(factor) * farthest[column];
        }
        radius += kRounding * magnitude;
        result.min[row] = middle - radius;
        result.max[row] = middle + radius;
    }
    return result;
}

bool touch(const Bounds& a, const Bounds& b) {
    return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
}

/// The lowest 21 bits of `x`, each followed by two zeros.
std::uint64_t spread(std::uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffff;
    x = (x | x << 16) & 0x1f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    return (x | x << 2) & 0x1249249249249249;
}

/// Triangles of `mesh` in the order of their centroids' Morton codes, ties in the file's order.
std::vector<std::uint32_t> mortonOrder(const Mesh& mesh) {
    const std::size_t count = mesh.indices.size() / 3;
    Bounds bounds;
    for (const glm::vec3& position : mesh.positions) bounds.add(glm::dvec3(position));
    const glm::dvec3 size = bounds.size();
    const double extent = std::max({size.x, size.y, size.z});
    const double cells = extent > 0 ? 0x1fffff / extent : 0;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(count);
    for (std::size_t t = 0; t < count; ++t) {
        glm::dvec3 centroid(0);
        for (std::size_t k = 0; k < 3; ++k) centroid += glm::dvec3(mesh.positions[mesh.indices[3 * t + k]]) / 3.0;
        const glm::dvec3 cell = glm::max((centroid - bounds.min) * cells, 0.0);
        keys[t] = {spread(static_cast<std::uint64_t>(cell.x)) | spread(static_cast<std::uint64_t>(cell.y)) << 1 |
                       spread(static_cast<std::uint64_t>(cell.z)) << 2,
                   static_cast<std::uint32_t>(t)};
    }
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order;
    order.reserve(count);
    for (const auto& key : keys) order.push_back(key.second);
    return order;
}

/// DrawElementsIndirectCommand of OpenGL 4.3, section 10.3.11.
struct DrawCommand {
    std::uint32_t indexCount, instanceCount, firstIndex;
    std::int32_t baseVertex;
    std::uint32_t baseInstance;
};

void requireStorage(std::size_t bytes, const char* what) {
    GLint64 limit = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    if (bytes > static_cast<std::size_t>(limit)) {
        throw DeviceError(
            fmt::format("the scene's {} need a storage block of {} bytes; the device allows "
                        "GL_MAX_SHADER_STORAGE_BLOCK_SIZE = {}",
                        what, bytes, limit));
    }
}

}  // namespace

GpuScene::GpuScene(const Scene& scene, double time)
    : scene_(scene), pose_(scene.pose(time)), moving_(scene.movingInstances()) {
    uploadGeometry();
    uploadMaterials();
    uploadTextures();
    setTime(time);
    takeMoved();
}

void GpuScene::uploadGeometry() {
    std::vector<char> used(scene_.meshes.size(), 0), rigid(scene_.meshes.size(), 0);
    shapes_.resize(scene_.meshes.size());
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
        const auto mesh = static_cast<std::size_t>(scene_.instances[i].mesh);
        used[mesh] = 1;
        if (pose_.deformations[i].rigid()) {
            rigid[mesh] = 1;
            shapeOf_.push_back(mesh);
        } else {
            shapeOf_.push_back(shapes_.size());
            shapes_.emplace_back();
            shapes_.back().mesh = static_cast<int>(mesh);
            shapes_.back().instance = static_cast<int>(i);
        }
    }
    std::size_t vertexCount = 0, indexCount = 0;
    for (std::size_t m = 0; m < scene_.meshes.size(); ++m) {
        if (used[m]) indexCount += scene_.meshes[m].indices.size();
        if (rigid[m]) vertexCount += scene_.meshes[m].positions.size();
    }
    for (std::size_t k = scene_.meshes.size(); k < shapes_.size(); ++k)
        vertexCount += scene_.meshes[static_cast<std::size_t>(shapes_[k].mesh)].positions.size();
    if (vertexCount > 0x7fffffffu || indexCount > 0x7fffffffu) {
        throw DeviceError("the scene has more than 2^31 vertices or indices");
    }

    std::vector<Vertex> vertices;
    vertices.reserve(vertexCount);
    indices_.reserve(indexCount);
    indexRanges_.resize(scene_.meshes.size());
    for (std::size_t m = 0; m < scene_.meshes.size(); ++m) {
        const Mesh& mesh = scene_.meshes[m];
        IndexRange& range = indexRanges_[m];
        shapes_[m].mesh = static_cast<int>(m);
        if (!used[m]) continue;
        const std::vector<std::uint32_t> order = mortonOrder(mesh);
        for (const bool closed : {true, false}) {
            const std::size_t begin = indices_.size();
            for (const std::size_t t : order) {
                if ((!mesh.closed.empty() && mesh.closed[t] != 0) != closed) continue;
                for (std::size_t k = 0; k < 3; ++k) indices_.push_back(mesh.indices[3 * t + k]);
            }
            (closed ? range.firstClosed : range.firstOpen) = static_cast<std::uint32_t>(begin);
            (closed ? range.closedCount : range.openCount) = static_cast<std::uint32_t>(indices_.size() - begin);
        }
        if (!rigid[m]) continue;
        shapes_[m].baseVertex = static_cast<std::int32_t>(vertices.size());
        appendVertices(vertices, mesh, mesh.positions, mesh.normals, mesh.tangents);
        updateShapeBounds(shapes_[m], mesh.positions);
    }
    for (Shape& shape : shapes_) {
        if (shape.instance < 0) continue;
        const Mesh& mesh = scene_.meshes[static_cast<std::size_t>(shape.mesh)];
        const DeformedVertices deformed = deform(mesh, pose_.deformations[static_cast<std::size_t>(shape.instance)]);
        shape.baseVertex = static_cast<std::int32_t>(vertices.size());
        appendVertices(vertices, mesh, deformed.positions, deformed.normals, deformed.tangents);
        updateShapeBounds(shape, deformed.positions);
    }
    if (vertices.empty() || indices_.empty()) return;
    vertices_ = Buffer::of(vertices);
    indexBuffer_ = Buffer::of(indices_);

    std::vector<std::uint32_t> objectIndices(scene_.instances.size());
    std::iota(objectIndices.begin(), objectIndices.end(), 0u);
    objectIndices_ = Buffer::of(objectIndices);

    const auto attribute = [&](int location, int components, std::size_t offset) {
        vertexArray_.attribute(location, vertices_, components, GL_FLOAT, sizeof(Vertex), offset);
    };
    attribute(kPositionLocation, 3, offsetof(Vertex, position));
    attribute(kNormalLocation, 3, offsetof(Vertex, normal));
    attribute(kTangentLocation, 4, offsetof(Vertex, tangent));
    attribute(kTexCoord0Location, 2, offsetof(Vertex, texCoord0));
    attribute(kTexCoord1Location, 2, offsetof(Vertex, texCoord1));
    attribute(kColorLocation, 4, offsetof(Vertex, color));
    vertexArray_.integerAttribute(kObjectIndexLocation, objectIndices_, 1, GL_UNSIGNED_INT, sizeof(std::uint32_t), 0,
                                  1);
    vertexArray_.indexBuffer(indexBuffer_);
}

void GpuScene::uploadDeformed(Shape& shape) {
    const Mesh& mesh = scene_.meshes[static_cast<std::size_t>(shape.mesh)];
    const DeformedVertices deformed = deform(mesh, pose_.deformations[static_cast<std::size_t>(shape.instance)]);
    std::vector<Vertex> vertices;
    vertices.reserve(deformed.positions.size());
    appendVertices(vertices, mesh, deformed.positions, deformed.normals, deformed.tangents);
    vertices_.upload(vertices.data(), vertices.size() * sizeof(Vertex),
                     static_cast<std::size_t>(shape.baseVertex) * sizeof(Vertex));
    updateShapeBounds(shape, deformed.positions);
}

void GpuScene::updateShapeBounds(Shape& shape, const std::vector<glm::vec3>& positions) const {
    const IndexRange& range = indexRanges_[static_cast<std::size_t>(shape.mesh)];
    shape.bounds = Bounds();
    for (const glm::vec3& position : positions) shape.bounds.add(glm::dvec3(position));
    const auto cut = [&](std::uint32_t first, std::uint32_t count) {
        constexpr std::uint32_t kClusterIndices = 3 * kClusterTriangles;
        std::vector<Bounds> clusters((count + kClusterIndices - 1) / kClusterIndices);
        for (std::uint32_t i = 0; i < count; ++i)
            clusters[i / kClusterIndices].add(glm::dvec3(positions[indices_[first + i]]));
        return clusters;
    };
    shape.closedClusters = cut(range.firstClosed, range.closedCount);
    shape.openClusters = cut(range.firstOpen, range.openCount);
}

void GpuScene::uploadMaterials() {
    if (scene_.materials.empty()) return;
    GLint alignment = 1;
    glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
    const auto unit = static_cast<std::size_t>(alignment);
    materialStride_ = (sizeof(GpuMaterial) + unit - 1) / unit * unit;
    std::vector<std::byte> blocks(scene_.materials.size() * materialStride_);
    std::size_t offset = 0;
    for (const Material& material : scene_.materials) {
        leaves_.push_back(scene_.isLeaves(material) ? 1 : 0);
        GpuMaterial gpu{};
        gpu.baseColor = material.baseColor;
        gpu.emission = glm::vec4(material.emission, material.unlit ? 1.0f : 0.0f);
        gpu.metallicRoughness =
            glm::vec4(material.metallic, material.roughness, material.normalScale, material.alphaCutoff);
        const float root = (material.ior - 1) / (material.ior + 1);
        gpu.specular = glm::vec4(glm::min(root * root * material.specularColor, glm::vec3(1)) * material.specularFactor,
                                 material.specularFactor);
        if (material.transmits())
            gpu.transmission = glm::vec4(material.transmission, material.thickness, std::max(material.ior, 1.0f), 0);
        gpu.absorption = glm::vec4(material.absorption(), 0);
        if (material.transmits())
            gpu.diffuseTransmission = glm::vec4(material.diffuseTransmissionColor, material.diffuseTransmission);
        for (const Slot& slot : slots(material)) {
            const glm::mat3x2& t = slot.slot->uvTransform;
            const auto row = static_cast<std::size_t>(2 * slot.unit);
            gpu.uvTransform[row] = glm::vec4(t[0][0], t[1][0], t[2][0], 0);
            gpu.uvTransform[row + 1] = glm::vec4(t[0][1], t[1][1], t[2][1], 0);
            gpu.texCoord[static_cast<std::size_t>(slot.unit / 4)][slot.unit % 4] = slot.slot->texCoord;
            if (slot.slot->texture >= 0) gpu.flags.w |= 1 << slot.unit;
        }
        gpu.flags.x = static_cast<int>(material.alphaMode);
        gpu.flags.y = (material.doubleSided ? 1 : 0) | (leaves_.back() != 0 ? 2 : 0);
        gpu.flags.z = material.unlit ? 1 : material.extracted ? 2 : 0;
        std::memcpy(blocks.data() + offset, &gpu, sizeof(gpu));
        offset += materialStride_;
    }
    materialBuffer_ = Buffer::of(blocks);
}

void GpuScene::uploadTextures() {
    colorTextures_.resize(scene_.textures.size());
    dataTextures_.resize(scene_.textures.size());
    isotropicSamplers_.resize(scene_.textures.size());
    std::vector<char> usedMaterials(scene_.materials.size(), 0);
    for (const Instance& instance : scene_.instances) {
        usedMaterials[static_cast<std::size_t>(scene_.meshes[static_cast<std::size_t>(instance.mesh)].material)] = 1;
    }
    for (std::size_t m = 0; m < scene_.materials.size(); ++m) {
        if (!usedMaterials[m]) continue;
        for (const Slot& slot : slots(scene_.materials[m])) {
            if (slot.slot->texture < 0) continue;
            const auto index = static_cast<std::size_t>(slot.slot->texture);
            Texture& texture = (slot.srgb ? colorTextures_ : dataTextures_)[index];
            if (texture) continue;
            const voxcone::Texture& image = scene_.textures[index];
            texture = Texture::create2D(slot.srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, image.width, image.height,
                                        fullMipLevels(image.width, image.height));
            if (slot.unit == kBaseColorUnit && scene_.materials[m].alphaMode != AlphaMode::opaque) {
                const Material& material = scene_.materials[m];
                const float cutoff = material.alphaMode == AlphaMode::mask && material.baseColor.a > 0
                                         ? material.alphaCutoff / material.baseColor.a
                                         : 0;
                const auto levels = alphaWeightedMips(image.width, image.height, image.rgba8, cutoff);
                for (std::size_t level = 0; level < levels.size(); ++level) {
                    texture.upload(static_cast<int>(level), GL_RGBA, GL_UNSIGNED_BYTE, levels[level].data());
                }
            } else {
                texture.upload(0, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba8.data());
                texture.generateMipmaps();
            }
            texture.filter(GL_LINEAR_MIPMAP_LINEAR, image.nearest ? GL_NEAREST : GL_LINEAR);
            // Some devices filter magnified texels linearly as soon as there is anisotropy.
            if (!image.nearest) texture.maxAnisotropy(8);
            texture.wrap(glWrap(image.wrapS), glWrap(image.wrapT));
            isotropicSamplers_[index] = Sampler(GL_LINEAR_MIPMAP_LINEAR, image.nearest ? GL_NEAREST : GL_LINEAR,
                                                glWrap(image.wrapS), glWrap(image.wrapT));
        }
    }
}

void GpuScene::setOrigin(const glm::dvec3& origin) {
    origin_ = origin;
    uploadObjects();
}

void GpuScene::setTime(double time) {
    time_ = time;
    const Pose before = std::exchange(pose_, scene_.pose(time));
    // Without triangles there are no objects.
    const std::size_t count = indices_.empty() ? 0 : scene_.instances.size();
    const bool first = instanceBounds_.size() < count;
    instanceBounds_.resize(count);
    moved_.resize(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
        Shape& shape = shapes_[shapeOf_[i]];
        const bool deformed = pose_.deformations[i] != before.deformations[i];
        if (!first && !deformed && pose_.instances[i] == before.instances[i]) continue;
        if (deformed) uploadDeformed(shape);
        instanceBounds_[i] = transformed(shape.bounds, pose_.instances[i]);
        moved_[i] = 1;
    }
    updateBatches();
    uploadObjects();
}

void GpuScene::updateBatches() {
    // Objects are sorted by what a batch has in common, so that every batch draws consecutive ones.
    const std::size_t count = instanceBounds_.size();
    using Key = std::tuple<std::size_t, bool, bool>;  // shape, moving, mirrored
    std::vector<Key> keys;
    for (std::size_t i = 0; i < count; ++i)
        keys.emplace_back(shapeOf_[i], moving_[i] != 0, glm::determinant(glm::dmat3(pose_.instances[i])) < 0);
    objects_.resize(count);
    std::iota(objects_.begin(), objects_.end(), std::size_t{0});
    std::stable_sort(objects_.begin(), objects_.end(), [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });

    batches_.clear();
    for (std::size_t first = 0; first < count;) {
        const auto [shapeIndex, moving, mirrored] = keys[objects_[first]];
        std::size_t last = first + 1;
        while (last < count && keys[objects_[last]] == keys[objects_[first]]) ++last;
        const Shape& shape = shapes_[shapeIndex];
        const IndexRange& range = indexRanges_[static_cast<std::size_t>(shape.mesh)];
        for (const bool closed : {true, false}) {
            Batch batch;
            batch.mesh = shape.mesh;
            batch.material = scene_.meshes[static_cast<std::size_t>(shape.mesh)].material;
            const Material& material = scene_.materials[static_cast<std::size_t>(batch.material)];
            batch.closed = closed;
            batch.mirrored = mirrored;
            batch.moving = moving;
            batch.alphaMode = material.alphaMode;
            batch.doubleSided = material.doubleSided;
            batch.transmits = material.transmits();
            batch.emits = material.unlit || material.emits();
            batch.leaves = leaves_[static_cast<std::size_t>(batch.material)] != 0;
            batch.emitsToCones = batch.emits && !material.extracted;
            batch.firstIndex = closed ? range.firstClosed : range.firstOpen;
            batch.indexCount = closed ? range.closedCount : range.openCount;
            batch.baseVertex = shape.baseVertex;
            batch.firstObject = static_cast<std::uint32_t>(first);
            batch.objectCount = static_cast<std::uint32_t>(last - first);
            if (batch.indexCount > 0) batches_.push_back(batch);
        }
        first = last;
    }
    std::stable_sort(batches_.begin(), batches_.end(), [](const Batch& a, const Batch& b) {
        return std::tuple(a.material, a.closed, a.mesh) < std::tuple(b.material, b.closed, b.mesh);
    });
    if (reversed_) std::reverse(batches_.begin(), batches_.end());
}

void GpuScene::uploadObjects() {
    if (objects_.empty()) return;
    std::vector<GpuObject> data;
    for (const std::size_t instance : objects_) {
        glm::dmat4 world = pose_.instances[instance];
        world[3] -= glm::dvec4(origin_, 0);
        const double determinant = glm::determinant(glm::dmat3(world));
        // A singular transform flattens its object: its normals come out zero, which shaders take for degenerate.
        glm::dmat3 normal = determinant != 0 ? glm::transpose(glm::inverse(glm::dmat3(world))) : glm::dmat3(0);
        double largest = 0;
        for (int c = 0; c < 3; ++c) {
            for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(normal[c][r]));
        }
        if (largest > 0) normal /= largest;  // keeps floats in range for any scale of the scene
        data.push_back({glm::mat4(world), glm::mat4(glm::mat3(normal)),
                        glm::vec4(determinant < 0 ? -1.0f : 1.0f, std::cbrt(std::abs(determinant)), 0, 0)});
    }
    const std::size_t bytes = data.size() * sizeof(GpuObject);
    requireStorage(bytes, "objects");
    if (objectBuffer_.bytes() == bytes) {
        objectBuffer_.upload(data.data(), bytes);
    } else {
        objectBuffer_ = Buffer::of(data, GL_DYNAMIC_DRAW);
    }
}

Bounds GpuScene::bounds() const {
    Bounds all;
    for (const Bounds& box : instanceBounds_) {
        if (box.empty()) continue;
        all.add(box.min);
        all.add(box.max);
    }
    return all;
}

std::uint64_t GpuScene::triangleCount() const {
    std::uint64_t count = 0;
    for (const Batch& batch : batches_) count += std::uint64_t{batch.indexCount / 3} * batch.objectCount;
    return count;
}

bool GpuScene::anyEmission() const {
    return std::any_of(batches_.begin(), batches_.end(), [](const Batch& batch) { return batch.emits; });
}

bool GpuScene::anyEmissionToCones() const {
    return std::any_of(batches_.begin(), batches_.end(), [](const Batch& batch) { return batch.emitsToCones; });
}

bool GpuScene::anyAlphaTest() const {
    return std::any_of(batches_.begin(), batches_.end(),
                       [](const Batch& batch) { return batch.alphaMode != AlphaMode::opaque; });
}

bool GpuScene::anyLeaves() const {
    return std::any_of(batches_.begin(), batches_.end(), [](const Batch& batch) { return batch.leaves; });
}

bool GpuScene::anyTransmission() const {
    return std::any_of(batches_.begin(), batches_.end(), [](const Batch& batch) { return batch.transmits; });
}

bool GpuScene::anyMoving() const {
    return std::any_of(batches_.begin(), batches_.end(), [](const Batch& batch) { return batch.moving; });
}

GpuScene::Moved GpuScene::takeMoved() {
    Moved boxes;
    for (std::size_t i = 0; i < moved_.size(); ++i) {
        if (!moved_[i] || takenBounds_.empty()) continue;
        auto& list = moving_[i] != 0 ? boxes.moving : boxes.fixed;
        list.insert(list.end(), {takenBounds_[i], instanceBounds_[i]});
    }
    std::fill(moved_.begin(), moved_.end(), std::uint8_t{0});
    takenBounds_ = instanceBounds_;
    return boxes;
}

void GpuScene::bindStorage() const {
    vertexArray_.bind();
    if (objectBuffer_) objectBuffer_.bindBase(GL_SHADER_STORAGE_BUFFER, kObjectStorage);
}

void GpuScene::drawBatches(Program& program, const BatchFilter& filter, TextureFiltering filtering,
                           const std::function<void(const Batch&)>& issue) const {
    program.use();
    bindStorage();
    int boundMaterial = -1;
    for (const Batch& batch : batches_) {
        if (filter && !filter(batch)) continue;
        if (batch.material != boundMaterial) {
            boundMaterial = batch.material;
            materialBuffer_.bindRange(GL_UNIFORM_BUFFER, kMaterialBlock,
                                      static_cast<std::size_t>(batch.material) * materialStride_, sizeof(GpuMaterial));
            for (const Slot& slot : slots(scene_.materials[static_cast<std::size_t>(batch.material)])) {
                if (slot.slot->texture < 0) continue;
                const auto index = static_cast<std::size_t>(slot.slot->texture);
                (slot.srgb ? colorTextures_ : dataTextures_)[index].bindTo(slot.unit);
                if (filtering == TextureFiltering::isotropic) isotropicSamplers_[index].bindTo(slot.unit);
            }
        }
        program.set("u_closed", batch.closed);
        glFrontFace(batch.mirrored ? GL_CW : GL_CCW);
        issue(batch);
    }
    glFrontFace(GL_CCW);
    for (int unit = 0; unit < kMaterialUnits; ++unit) Sampler::unbind(unit);
}

void GpuScene::draw(Program& program, const BatchFilter& filter, TextureFiltering filtering) const {
    drawBatches(program, filter, filtering, [](const Batch& batch) {
        glDrawElementsInstancedBaseVertexBaseInstance(
            GL_TRIANGLES, static_cast<GLsizei>(batch.indexCount), GL_UNSIGNED_INT,
            reinterpret_cast<const void*>(std::size_t{batch.firstIndex} * sizeof(std::uint32_t)),
            static_cast<GLsizei>(batch.objectCount), batch.baseVertex, batch.firstObject);
    });
}

std::uint64_t GpuScene::drawInside(Program& program, const Bounds& worldBox, const BatchFilter& filter,
                                   TextureFiltering filtering) const {
    std::vector<DrawCommand> commands;
    std::vector<std::size_t> ends;  // of the commands of each batch
    std::uint64_t indexCount = 0;
    for (const Batch& batch : batches_) {
        const Shape& shape = shapes_[shapeOf_[objects_[batch.firstObject]]];
        const std::vector<Bounds>& clusters = batch.closed ? shape.closedClusters : shape.openClusters;
        const bool taken = !filter || filter(batch);
        for (std::uint32_t k = 0; taken && k < batch.objectCount; ++k) {
            const std::uint32_t object = batch.firstObject + k;
            const glm::dmat4& matrix = pose_.instances[objects_[object]];
            if (!touch(reach(shape.bounds, matrix, origin_), worldBox)) continue;
            bool merge = false;  // with the cluster before, which is drawn as well
            for (std::uint32_t begin = 0; const Bounds& cluster : clusters) {
                const std::uint32_t count = std::min(3 * kClusterTriangles, batch.indexCount - begin);
                const bool inside = touch(reach(cluster, matrix, origin_), worldBox);
                if (inside && merge) {
                    commands.back().indexCount += count;
                } else if (inside) {
                    commands.push_back({count, 1, batch.firstIndex + begin, batch.baseVertex, object});
                }
                if (inside) indexCount += count;
                merge = inside;
                begin += count;
            }
        }
        ends.push_back(commands.size());
    }
    if (commands.empty()) return 0;

    const Buffer indirect = Buffer::of(commands, GL_STREAM_DRAW);
    indirect.bind(GL_DRAW_INDIRECT_BUFFER);
    const auto firstCommand = [&](const Batch& batch) {
        const auto place = static_cast<std::size_t>(&batch - batches_.data());
        return place == 0 ? std::size_t{0} : ends[place - 1];
    };
    const auto commandCount = [&](const Batch& batch) {
        return ends[static_cast<std::size_t>(&batch - batches_.data())] - firstCommand(batch);
    };
    drawBatches(
        program, [&](const Batch& batch) { return commandCount(batch) > 0; }, filtering,
        [&](const Batch& batch) {
            glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT,
                                        reinterpret_cast<const void*>(firstCommand(batch) * sizeof(DrawCommand)),
                                        static_cast<GLsizei>(commandCount(batch)), 0);
        });
    return indexCount / 3;
}

void GpuScene::reverseDrawOrder() {
    if (indices_.empty()) return;
    for (const IndexRange& range : indexRanges_) {
        const auto reverseTriangles = [&](std::uint32_t first, std::uint32_t count) {
            for (std::uint32_t a = first, b = first + count; a + 3 < b; a += 3, b -= 3) {
                std::swap_ranges(indices_.begin() + a, indices_.begin() + a + 3, indices_.begin() + (b - 3));
            }
        };
        reverseTriangles(range.firstClosed, range.closedCount);
        reverseTriangles(range.firstOpen, range.openCount);
    }
    indexBuffer_.upload(indices_.data(), indices_.size() * sizeof(std::uint32_t));
    for (Shape& shape : shapes_) {
        if (shape.instance >= 0) {
            uploadDeformed(shape);
        } else {
            updateShapeBounds(shape, scene_.meshes[static_cast<std::size_t>(shape.mesh)].positions);
        }
    }
    reversed_ = !reversed_;
    std::reverse(batches_.begin(), batches_.end());
}

std::uint64_t GpuScene::bufferBytes() const {
    return vertices_.bytes() + indexBuffer_.bytes() + objectIndices_.bytes() + objectBuffer_.bytes() +
           materialBuffer_.bytes();
}

std::uint64_t GpuScene::textureBytes() const {
    std::uint64_t bytes = 0;
    for (const Texture& texture : colorTextures_) bytes += texture.bytes();
    for (const Texture& texture : dataTextures_) bytes += texture.bytes();
    return bytes;
}

}  // namespace voxcone::gl
