#include "scene/gltf.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <map>
#include <tuple>

#include "core/check.h"
#include "core/error.h"
#include "core/log.h"
#include "scene/gltf_check.h"
#include "scene/gltf_file.h"
#include "scene/image_decode.h"
#include "scene/tangents.h"
#include "scene/topology.h"

namespace voxcone {

namespace {

using nlohmann::json;
using Size = std::size_t;

template <class Integer>
Size sizeOf(Integer i) {
    return static_cast<Size>(i);
}

float normalized(double value, double highest) {
    return static_cast<float>(std::max(value / highest, -1.0));
}

template <class T>
T load(const std::uint8_t* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

/// One component as float, normalised if asked (glTF 2.0 §3.11).
float component(const std::uint8_t* p, int type, bool norm) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE: {
            const auto v = load<std::int8_t>(p);
            return norm ? normalized(v, 127) : static_cast<float>(v);
        }
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return norm ? normalized(*p, 255) : static_cast<float>(*p);
        case TINYGLTF_COMPONENT_TYPE_SHORT: {
            const auto v = load<std::int16_t>(p);
            return norm ? normalized(v, 32767) : static_cast<float>(v);
        }
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
            const auto v = load<std::uint16_t>(p);
            return norm ? normalized(v, 65535) : static_cast<float>(v);
        }
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return static_cast<float>(load<std::uint32_t>(p));
        default:
            return load<float>(p);
    }
}

std::uint32_t unsignedInteger(const std::uint8_t* p, int type) {
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return *p;
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return load<std::uint16_t>(p);
    return load<std::uint32_t>(p);
}

bool finite(const glm::vec4& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) && std::isfinite(v.w);
}

glm::vec3 faceNormal(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    return glm::vec3(glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a)));
}

/// `v` to unit length; +y for what has no direction (a face without area is never seen).
glm::vec3 unitOrUp(const glm::vec3& v) {
    const double length = glm::length(glm::dvec3(v));
    return length > 0 && std::isfinite(length) ? glm::vec3(glm::dvec3(v) / length) : glm::vec3(0, 1, 0);
}

double numberIn(const tinygltf::Value& object, const char* key, double fallback) {
    return object.Has(key) ? object.Get(key).GetNumberAsDouble() : fallback;
}

glm::dvec2 vec2In(const tinygltf::Value& object, const char* key, const glm::dvec2& fallback) {
    if (!object.Has(key)) return fallback;
    const tinygltf::Value& array = object.Get(key);
    return {array.Get(0).GetNumberAsDouble(), array.Get(1).GetNumberAsDouble()};
}

/// White when absent.
glm::vec3 colorIn(const tinygltf::Value& object, const char* key) {
    glm::vec3 color(1);
    if (object.Has(key))
        for (int c = 0; c < 3; ++c) color[c] = static_cast<float>(object.Get(key).Get(c).GetNumberAsDouble());
    return color;
}

/// Elements of one accessor, sparse values applied. The accessor was checked to lie within its buffers.
class Accessor {
  public:
    Accessor(const tinygltf::Model& model, const std::vector<Bytes>& buffers, int index, const std::string& file)
        : accessor_(model.accessors[sizeOf(index)]),
          components_(sizeOf(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor_.type)))) {
        componentBytes_ =
            sizeOf(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor_.componentType)));
        const Size elementBytes = components_ * componentBytes_;
        auto bytesOf = [&](int view, Size offset) {
            const tinygltf::BufferView& v = model.bufferViews[sizeOf(view)];
            return buffers[sizeOf(v.buffer)].data() + v.byteOffset + offset;
        };
        if (accessor_.bufferView >= 0) {
            base_ = bytesOf(accessor_.bufferView, accessor_.byteOffset);
            const Size stride = model.bufferViews[sizeOf(accessor_.bufferView)].byteStride;
            stride_ = stride ? stride : elementBytes;
        }
        if (!accessor_.sparse.isSparse) return;
        sparseValues_ = bytesOf(accessor_.sparse.values.bufferView, sizeOf(accessor_.sparse.values.byteOffset));
        const int type = accessor_.sparse.indices.componentType;
        const std::uint8_t* indices =
            bytesOf(accessor_.sparse.indices.bufferView, sizeOf(accessor_.sparse.indices.byteOffset));
        const Size step = sizeOf(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type)));
        for (Size i = 0; i < sizeOf(accessor_.sparse.count); ++i) {
            const std::uint32_t element = unsignedInteger(indices + i * step, type);
            if (element >= accessor_.count || (!sparse_.empty() && element <= sparse_.back()))
                throw InputError(
                    file, fmt::format("accessors[{}].sparse.indices", index),
                    fmt::format("entry {} is {}: not increasing, or not below count {}", i, element, accessor_.count));
            sparse_.push_back(element);
        }
    }

    Size count() const { return accessor_.count; }
    Size components() const { return components_; }

    /// Element `i`; components that the accessor lacks are 0.
    glm::vec4 at(Size i) const {
        glm::vec4 value(0);
        if (const std::uint8_t* p = element(i))
            for (Size c = 0; c < std::min<Size>(components_, 4); ++c)
                value[static_cast<int>(c)] =
                    component(p + c * componentBytes_, accessor_.componentType, accessor_.normalized);
        return value;
    }
    /// Component `c` of element `i`, for matrices of floats.
    float floatAt(Size i, Size c) const {
        const std::uint8_t* p = element(i);
        return p ? load<float>(p + c * sizeof(float)) : 0;
    }
    std::uint32_t index(Size i) const {
        const std::uint8_t* p = element(i);
        return p ? unsignedInteger(p, accessor_.componentType) : 0;
    }

  private:
    const std::uint8_t* element(Size i) const {
        if (!sparse_.empty()) {
            const auto it = std::lower_bound(sparse_.begin(), sparse_.end(), i);
            if (it != sparse_.end() && *it == i)
                return sparseValues_ + sizeOf(it - sparse_.begin()) * components_ * componentBytes_;
        }
        return base_ ? base_ + i * stride_ : nullptr;
    }

    const tinygltf::Accessor& accessor_;
    Size components_ = 0, componentBytes_ = 0, stride_ = 0;
    const std::uint8_t* base_ = nullptr;
    const std::uint8_t* sparseValues_ = nullptr;
    std::vector<std::uint32_t> sparse_;
};

class Loader {
  public:
    explicit Loader(const std::filesystem::path& path) : file_(readGltfFile(path)), name_(path.string()) {}

    Scene run() {
        checkGltf(file_, ignored_);
        readBuffers();
        readModel();
        scene_.file = file_.path;
        for (Size i = 0; i < model_.materials.size(); ++i) addMaterial(i);
        decodeImages();
        for (Size i = 0; i < model_.meshes.size(); ++i) addMesh(i);
        addNodes();
        addSkins();
        for (Size i = 0; i < model_.animations.size(); ++i) addAnimation(i);
        if (scene_.materials.empty()) defaultMaterial();
        // Finite numbers multiply to infinite ones along a hierarchy; the renderer's floats must hold what comes out.
        constexpr double kFarthest = 1e18;
        const Bounds bounds = scene_.bounds();
        const glm::dvec3 far = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
        if (!bounds.empty() && !(std::max({far.x, far.y, far.z}) <= kFarthest))
            fail("nodes", fmt::format("vertices are farther than {:g} from the origin", kFarthest));
        for (const std::string& what : ignored_) log::warn("{}: ignored: {}", name_, what);
        return std::move(scene_);
    }

  private:
    [[noreturn]] void fail(const std::string& jsonPath, const std::string& reason) const {
        throw InputError(name_, jsonPath, reason);
    }

    void readBuffers() {
        const json buffers = file_.document.value("buffers", json::array());
        for (Size i = 0; i < buffers.size(); ++i) {
            const auto length = buffers[i]["byteLength"].get<std::uint64_t>();
            const std::string path = fmt::format("buffers[{}].uri", i);
            if (buffers[i].contains("uri")) {
                buffers_.push_back(readUri(file_, buffers[i]["uri"].get<std::string>(), path, length));
            } else if (i == 0 && file_.binary) {
                buffers_.push_back(std::move(*file_.binary));
            } else {
                buffers_.emplace_back();
                continue;
            }
            // The file may have shrunk since it was checked.
            if (buffers_.back().size() < length) fail(path, "has fewer bytes than byteLength");
            bufferBytes_ += length;
        }
    }

    /// tinygltf turns the checked JSON into structs. Buffers and images are read by this file, which places their
    /// errors.
    void readModel() {
        images_ = file_.document.value("images", json::array());
        file_.document.erase("images");
        file_.document.erase("buffers");
        // tinygltf refuses the legal case of indices without a bufferView, so it does not see them at all.
        if (file_.document.contains("meshes")) {
            for (json& mesh : file_.document["meshes"]) {
                indicesOf_.emplace_back();
                for (json& primitive : mesh["primitives"]) {
                    indicesOf_.back().push_back(primitive.value("indices", -1));
                    primitive.erase("indices");
                }
            }
        }
        const std::string text = file_.document.dump(-1, ' ', false, json::error_handler_t::replace);
        if (text.size() > UINT32_MAX) fail("", "JSON is larger than 4 GiB");
        tinygltf::TinyGLTF reader;
        std::string error, warning;
        if (!reader.LoadASCIIFromString(&model_, &error, &warning, text.data(), static_cast<unsigned>(text.size()), "",
                                        tinygltf::REQUIRE_VERSION))
            fail("", "is not valid glTF: " + printable(error));
    }

    // ---- materials and textures

    int addTexture(int textureIndex) {
        const tinygltf::Texture& texture = model_.textures[sizeOf(textureIndex)];
        if (texture.source < 0) return -1;
        auto wrap = [](int mode) {
            return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Wrap::clamp_to_edge
                   : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::mirrored_repeat
                                                                   : Wrap::repeat;
        };
        Texture result;
        if (texture.sampler >= 0) {
            const tinygltf::Sampler& sampler = model_.samplers[sizeOf(texture.sampler)];
            result.wrapS = wrap(sampler.wrapS);
            result.wrapT = wrap(sampler.wrapT);
            result.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
        }
        const auto [place, added] = textureIndex_.try_emplace(
            {texture.source, result.wrapS, result.wrapT, result.nearest}, static_cast<int>(scene_.textures.size()));
        if (added) {
            const json& image = images_[sizeOf(texture.source)];
            const std::string uri = image.value("uri", "");
            result.name =
                uri.empty() || uri.starts_with("data:") ? fmt::format("images[{}]", texture.source) : printable(uri);
            scene_.textures.push_back(std::move(result));
            imageOfTexture_.push_back(sizeOf(texture.source));
        }
        return place->second;
    }

    /// `sets` maps the material's slots 0 and 1 to sets of the file and grows by this slot's.
    TextureSlot slot(int textureIndex, int texCoord, const tinygltf::ExtensionMap& extensions,
                     std::array<int, 2>& sets) {
        TextureSlot result;
        if (textureIndex < 0) return result;
        if (const auto it = extensions.find("KHR_texture_transform"); it != extensions.end()) {
            const tinygltf::Value& e = it->second;
            texCoord = e.Has("texCoord") ? e.Get("texCoord").GetNumberAsInt() : texCoord;
            const glm::dvec2 offset = vec2In(e, "offset", {0, 0}), scale = vec2In(e, "scale", {1, 1});
            const double angle = numberIn(e, "rotation", 0), c = std::cos(angle), s = std::sin(angle);
            // uv' = translation · rotation · scale · uv; counter-clockwise with v downwards.
            result.uvTransform = glm::mat3x2(c * scale.x, -s * scale.x, s * scale.y, c * scale.y, offset.x, offset.y);
        }
        int place = 0;
        while (place < 2 && sets[sizeOf(place)] >= 0 && sets[sizeOf(place)] != texCoord) ++place;
        if (place == 2) {
            ignored_.insert("textures on a third UV set of one material");
            return result;
        }
        result.texture = addTexture(textureIndex);
        if (result.texture < 0) return result;
        sets[sizeOf(place)] = texCoord;
        result.texCoord = place;
        return result;
    }

    void addMaterial(Size index) {
        const tinygltf::Material& in = model_.materials[index];
        const tinygltf::PbrMetallicRoughness& pbr = in.pbrMetallicRoughness;
        auto vec3 = [](const std::vector<double>& v) { return glm::vec3(v[0], v[1], v[2]); };
        Material out;
        out.name = in.name;
        const std::vector<double>& base = pbr.baseColorFactor;
        out.baseColor = glm::vec4(base[0], base[1], base[2], base[3]);
        out.metallic = static_cast<float>(pbr.metallicFactor);
        out.roughness = static_cast<float>(pbr.roughnessFactor);
        if (in.emissiveFactor.size() == 3) out.emission = vec3(in.emissiveFactor);
        out.alphaMode = in.alphaMode == "MASK"    ? AlphaMode::mask
                        : in.alphaMode == "BLEND" ? AlphaMode::blend
                                                  : AlphaMode::opaque;
        out.alphaCutoff = static_cast<float>(in.alphaCutoff);
        out.doubleSided = in.doubleSided;
        if (in.extras.IsObject() && in.extras.Has("voxcone_matter"))
            out.matter =
                in.extras.Get("voxcone_matter").Get<std::string>() == "leaves" ? Matter::leaves : Matter::solid;
        out.normalScale = static_cast<float>(in.normalTexture.scale);
        out.occlusionStrength = static_cast<float>(in.occlusionTexture.strength);

        // In the order of what would be missed most, should there be more than two UV sets.
        std::array<int, 2> sets{-1, -1};
        auto slotOf = [&](const auto& info) { return slot(info.index, info.texCoord, info.extensions, sets); };
        out.baseColorTexture = slotOf(pbr.baseColorTexture);
        out.normalTexture = slotOf(in.normalTexture);
        out.emissionTexture = slotOf(in.emissiveTexture);
        out.metallicRoughnessTexture = slotOf(pbr.metallicRoughnessTexture);
        const auto slotIn = [&](const char* extension, const char* key) {
            const auto it = in.extensions.find(extension);
            if (it == in.extensions.end() || !it->second.Has(key)) return TextureSlot{};
            const tinygltf::Value& info = it->second.Get(key);
            tinygltf::ExtensionMap extensions;
            if (info.Has("extensions"))
                for (const std::string& name : info.Get("extensions").Keys())
                    extensions[name] = info.Get("extensions").Get(name);
            return slot(info.Get("index").GetNumberAsInt(), static_cast<int>(numberIn(info, "texCoord", 0)), extensions,
                        sets);
        };
        out.transmissionTexture = slotIn("KHR_materials_transmission", "transmissionTexture");
        out.diffuseTransmissionTexture = slotIn("KHR_materials_diffuse_transmission", "diffuseTransmissionTexture");
        out.diffuseTransmissionColorTexture =
            slotIn("KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture");
        out.thicknessTexture = slotIn("KHR_materials_volume", "thicknessTexture");
        out.occlusionTexture = slotOf(in.occlusionTexture);
        uvSets_.push_back(sets);

        for (const auto& [name, e] : in.extensions) {
            if (name == "KHR_materials_unlit") out.unlit = true;
            if (name == "KHR_materials_emissive_strength")
                out.emission *= static_cast<float>(numberIn(e, "emissiveStrength", 1));
            if (name == "KHR_materials_transmission")
                out.transmission = static_cast<float>(numberIn(e, "transmissionFactor", 0));
            if (name == "KHR_materials_volume") {
                out.thickness = static_cast<float>(numberIn(e, "thicknessFactor", 0));
                out.attenuationDistance = static_cast<float>(numberIn(e, "attenuationDistance", 0));
                out.attenuationColor = colorIn(e, "attenuationColor");
            }
            if (name == "KHR_materials_diffuse_transmission") {
                out.diffuseTransmission = static_cast<float>(numberIn(e, "diffuseTransmissionFactor", 0));
                out.diffuseTransmissionColor = colorIn(e, "diffuseTransmissionColorFactor");
            }
            if (name == "KHR_materials_ior") out.ior = static_cast<float>(numberIn(e, "ior", 1.5));
            if (name == "KHR_materials_specular") {
                out.specularFactor = static_cast<float>(numberIn(e, "specularFactor", 1));
                out.specularColor = colorIn(e, "specularColorFactor");
            }
        }
        scene_.materials.push_back(out);
    }

    int defaultMaterial() {
        if (defaultMaterial_ < 0) {
            defaultMaterial_ = static_cast<int>(scene_.materials.size());
            Material material;
            material.name = "default";
            scene_.materials.push_back(material);
            uvSets_.push_back({-1, -1});
        }
        return defaultMaterial_;
    }

    DecodedImage decode(Size index) const {
        const json& image = images_[index];
        const std::string path = fmt::format("images[{}]", index);
        if (image.contains("uri")) {
            const auto uri = image["uri"].get<std::string>();
            if (uriSize(file_, uri, path + ".uri") == 0) fail(path + ".uri", "image is empty");
            return decodeImage(readUri(file_, uri, path + ".uri", UINT64_MAX), name_, path);
        }
        const tinygltf::BufferView& view = model_.bufferViews[image["bufferView"].get<Size>()];
        const Bytes& buffer = buffers_[sizeOf(view.buffer)];
        if (buffer.size() < view.byteOffset + view.byteLength) fail(path, "is in a buffer that has no data");
        const auto begin = buffer.begin() + static_cast<std::ptrdiff_t>(view.byteOffset);
        return decodeImage(Bytes(begin, begin + static_cast<std::ptrdiff_t>(view.byteLength)), name_, path);
    }

    /// Decodes the images that some material uses, on all cores.
    void decodeImages() {
        std::vector<Size> used(imageOfTexture_);
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
        std::vector<DecodedImage> decoded(used.size());
        std::vector<std::exception_ptr> errors(used.size());
        tbb::parallel_for(Size{0}, used.size(), [&](Size i) {
            try {
                decoded[i] = decode(used[i]);
            } catch (...) {
                errors[i] = std::current_exception();
            }
        });
        // The first in the file's order, so that the message does not depend on timing.
        for (const std::exception_ptr& error : errors)
            if (error) std::rethrow_exception(error);
        for (Size t = 0; t < scene_.textures.size(); ++t) {
            const auto place = sizeOf(std::lower_bound(used.begin(), used.end(), imageOfTexture_[t]) - used.begin());
            scene_.textures[t].width = decoded[place].width;
            scene_.textures[t].height = decoded[place].height;
            scene_.textures[t].rgba8 = decoded[place].rgba8;
        }
    }

    // ---- meshes

    /// Corners of the primitive's triangles as vertex indices, all in range.
    std::vector<std::uint32_t> corners(int mode, int indexAccessor, Size vertexCount, const std::string& path) {
        std::vector<std::uint32_t> list;
        if (indexAccessor >= 0) {
            const Accessor indices(model_, buffers_, indexAccessor, name_);
            spendCorners(indices.count(), path);
            list.resize(indices.count());
            for (Size i = 0; i < list.size(); ++i) {
                list[i] = indices.index(i);
                if (list[i] >= vertexCount)
                    fail(path + ".indices",
                         fmt::format("element {} is {}, but there are {} vertices", i, list[i], vertexCount));
            }
        } else {
            spendCorners(vertexCount, path);
            list.resize(vertexCount);
            for (Size i = 0; i < vertexCount; ++i) list[i] = static_cast<std::uint32_t>(i);
        }

        if (mode == TINYGLTF_MODE_TRIANGLES) {
            if (list.size() % 3 != 0) {
                log::warn("{}: {}: {} indices, the last {} make no triangle", name_, path, list.size(),
                          list.size() % 3);
                list.resize(list.size() / 3 * 3);
            }
            return list;
        }
        std::vector<std::uint32_t> triangles;
        if (list.size() < 3) return triangles;
        triangles.reserve(3 * (list.size() - 2));
        for (Size i = 0; i + 2 < list.size(); ++i) {
            // glTF 2.0 §3.7.2.1: the strip's odd triangles are turned round, the fan's begin with their own vertices.
            if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
                triangles.insert(triangles.end(), {list[i], list[i + 1 + i % 2], list[i + 2 - i % 2]});
            else
                triangles.insert(triangles.end(), {list[i + 1], list[i + 2], list[0]});
        }
        return triangles;
    }

    /// A small file may name one large accessor many times; what it makes stays in proportion to its bytes.
    void spendCorners(Size count, const std::string& path) {
        corners_ += count;
        const Size allowed = (Size{16} << 20) + 64 * bufferBytes_;
        if (corners_ > allowed)
            fail(path, fmt::format("the file's meshes have over {} indices, too many for {} bytes of buffers", allowed,
                                   bufferBytes_));
    }

    void addMesh(Size meshIndex) {
        const tinygltf::Mesh& in = model_.meshes[meshIndex];
        meshesOf_.emplace_back();
        for (Size k = 0; k < in.primitives.size(); ++k) {
            const tinygltf::Primitive& primitive = in.primitives[k];
            const std::string path = fmt::format("meshes[{}].primitives[{}]", meshIndex, k);
            if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
                ignored_.insert("points and lines");
                continue;
            }
            const auto position = primitive.attributes.find("POSITION");
            if (position == primitive.attributes.end()) {
                ignored_.insert("primitives without POSITION");
                continue;
            }
            Mesh mesh;
            mesh.name = in.name.empty() ? path : fmt::format("{} ({})", path, printable(in.name));
            mesh.material = primitive.material >= 0 ? primitive.material : defaultMaterial();
            if (!in.weights.empty()) {
                for (const double weight : in.weights) mesh.morphWeights.push_back(static_cast<float>(weight));
            } else {
                mesh.morphWeights.assign(primitive.targets.size(), 0);
            }
            if (!fillMesh(mesh, primitive, indicesOf_[meshIndex][k], position->second, path)) {
                log::warn("{}: {}: has no triangles", name_, path);
                continue;
            }
            meshesOf_.back().push_back(static_cast<int>(scene_.meshes.size()));
            scene_.meshes.push_back(std::move(mesh));
        }
    }

    bool fillMesh(Mesh& mesh, const tinygltf::Primitive& primitive, int indexAccessor, int positionAccessor,
                  const std::string& path) {
        const Accessor positions(model_, buffers_, positionAccessor, name_);
        mesh.indices = corners(primitive.mode, indexAccessor, positions.count(), path);
        if (mesh.indices.empty()) return false;

        auto attribute = [&](const std::string& semantic) {
            const auto it = primitive.attributes.find(semantic);
            return it == primitive.attributes.end() ? -1 : it->second;
        };
        const int normalAccessor = attribute("NORMAL");
        // Which vertex of the file each of ours is: those in use, or one a corner where faces need normals of their
        // own.
        const std::vector<std::uint32_t> source =
            normalAccessor >= 0 ? compact(mesh.indices, positions.count()) : separate(mesh.indices);

        mesh.positions.reserve(source.size());
        for (const std::uint32_t i : source) {
            const glm::vec4 p = positions.at(i);
            if (!finite(p)) fail(path + ".attributes.POSITION", fmt::format("element {} is NaN or infinite", i));
            mesh.positions.emplace_back(p);
        }
        if (normalAccessor >= 0) {
            fillNormals(mesh, Accessor(model_, buffers_, normalAccessor, name_), source, path);
        } else {
            mesh.flatNormals = true;
            for (Size i = 0; i < source.size(); i += 3)
                mesh.normals.insert(
                    mesh.normals.end(), 3,
                    unitOrUp(faceNormal(mesh.positions[i], mesh.positions[i + 1], mesh.positions[i + 2])));
        }
        for (Size set = 0; set < 2; ++set) fillTexCoords(mesh, primitive, set, source, path);
        if (const int color = attribute("COLOR_0"); color >= 0)
            fillColors(mesh, Accessor(model_, buffers_, color, name_), source, path);
        if (const int joints = attribute("JOINTS_0"); joints >= 0)
            fillJoints(mesh, Accessor(model_, buffers_, joints, name_),
                       Accessor(model_, buffers_, attribute("WEIGHTS_0"), name_), source, path);
        fillMorphTargets(mesh, primitive, source, path);
        if (scene_.materials[sizeOf(mesh.material)].normalTexture.texture >= 0)
            fillTangents(mesh, normalAccessor >= 0 ? attribute("TANGENT") : -1, source, path);
        mesh.closed = closedTriangles(mesh.positions, mesh.indices);
        return true;
    }

    static std::vector<std::uint32_t> compact(std::vector<std::uint32_t>& indices, Size vertexCount) {
        std::vector<std::uint32_t> source(indices);
        std::sort(source.begin(), source.end());
        source.erase(std::unique(source.begin(), source.end()), source.end());
        if (source.size() == vertexCount) return source;
        for (std::uint32_t& index : indices)
            index = static_cast<std::uint32_t>(std::lower_bound(source.begin(), source.end(), index) - source.begin());
        return source;
    }

    static std::vector<std::uint32_t> separate(std::vector<std::uint32_t>& indices) {
        std::vector<std::uint32_t> source(indices);
        for (Size i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint32_t>(i);
        return source;
    }

    void fillNormals(Mesh& mesh, const Accessor& normals, const std::vector<std::uint32_t>& source,
                     const std::string& path) const {
        Size repaired = 0;
        std::vector<glm::vec3> faces;  // sums at vertices, made when one is needed
        for (Size v = 0; v < source.size(); ++v) {
            const glm::vec4 n = normals.at(source[v]);
            const float length = glm::length(glm::vec3(n));
            if (std::isfinite(length) && length > 0) {
                mesh.normals.push_back(glm::vec3(n) / length);
                continue;
            }
            if (faces.empty()) {
                faces.assign(source.size(), glm::vec3(0));
                for (Size i = 0; i < mesh.indices.size(); i += 3) {
                    const std::uint32_t* t = mesh.indices.data() + i;
                    const glm::vec3 face = faceNormal(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
                    for (int k = 0; k < 3; ++k) faces[t[k]] += face;
                }
            }
            mesh.normals.push_back(unitOrUp(faces[v]));
            ++repaired;
        }
        if (repaired > 0)
            log::warn("{}: {}.attributes.NORMAL: {} normals without direction are taken from the faces", name_, path,
                      repaired);
    }

    void fillTexCoords(Mesh& mesh, const tinygltf::Primitive& primitive, Size slotIndex,
                       const std::vector<std::uint32_t>& source, const std::string& path) const {
        const int set = uvSets_[sizeOf(mesh.material)][slotIndex];
        if (set < 0) return;
        const std::string semantic = fmt::format("TEXCOORD_{}", set);
        std::vector<glm::vec2>& out = mesh.texCoords[slotIndex];
        const auto it = primitive.attributes.find(semantic);
        if (it == primitive.attributes.end()) {
            log::warn("{}: {}.attributes: {} is missing, which the material uses; taken as 0", name_, path, semantic);
            out.assign(source.size(), glm::vec2(0));
            return;
        }
        const Accessor accessor(model_, buffers_, it->second, name_);
        Size repaired = 0;
        for (const std::uint32_t i : source) {
            const glm::vec4 uv = accessor.at(i);
            repaired += finite(uv) ? 0 : 1;
            out.push_back(finite(uv) ? glm::vec2(uv) : glm::vec2(0));
        }
        if (repaired > 0)
            log::warn("{}: {}.attributes.{}: {} coordinates are not finite; taken as 0", name_, path, semantic,
                      repaired);
    }

    void fillColors(Mesh& mesh, const Accessor& colors, const std::vector<std::uint32_t>& source,
                    const std::string& path) const {
        Size repaired = 0;
        for (const std::uint32_t i : source) {
            glm::vec4 color = colors.at(i);
            if (colors.components() == 3) color.w = 1;
            repaired += finite(color) ? 0 : 1;
            // The specification clamps vertex colours, glTF 2.0 §3.9.2.
            mesh.colors.push_back(finite(color) ? glm::clamp(color, 0.0f, 1.0f) : glm::vec4(1));
        }
        if (repaired > 0)
            log::warn("{}: {}.attributes.COLOR_0: {} colours are not finite; taken as white", name_, path, repaired);
    }

    void fillJoints(Mesh& mesh, const Accessor& joints, const Accessor& weights,
                    const std::vector<std::uint32_t>& source, const std::string& path) {
        Size weightless = 0;
        LargestJoint largest{0, 0, path};
        for (const std::uint32_t i : source) {
            const glm::vec4 joint = joints.at(i);
            glm::vec4 weight = weights.at(i);
            if (!finite(weight) || glm::any(glm::lessThan(weight, glm::vec4(0))))
                fail(path + ".attributes.WEIGHTS_0", fmt::format("element {} is negative, NaN or infinite", i));
            // In double: four large floats may have no sum in float.
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += static_cast<double>(weight[k]);
            if (sum == 0) {
                weight = glm::vec4(1, 0, 0, 0);
                ++weightless;
            } else {
                weight = glm::vec4(glm::dvec4(weight) / sum);
            }
            mesh.joints.emplace_back();
            for (int k = 0; k < 4; ++k) {
                // What has no weight may name any joint.
                if (weight[k] == 0) continue;
                const auto index = static_cast<std::uint16_t>(joint[k]);
                mesh.joints.back()[sizeOf(k)] = index;
                if (index > largest.joint) {
                    largest.joint = index;
                    largest.vertex = i;
                }
            }
            mesh.jointWeights.push_back(weight);
        }
        largestJoint_[static_cast<int>(scene_.meshes.size())] = largest;
        if (weightless > 0)
            log::warn("{}: {}.attributes.WEIGHTS_0: {} vertices without weights follow their first joint", name_, path,
                      weightless);
    }

    void fillMorphTargets(Mesh& mesh, const tinygltf::Primitive& primitive, const std::vector<std::uint32_t>& source,
                          const std::string& path) {
        for (Size k = 0; k < primitive.targets.size(); ++k) {
            MorphTarget target;
            for (const auto& [semantic, accessorIndex] : primitive.targets[k]) {
                const std::string place = fmt::format("{}.targets[{}].{}", path, k, semantic);
                std::vector<glm::vec3>& deltas = semantic == "POSITION" ? target.positions
                                                 : semantic == "NORMAL" ? target.normals
                                                                        : target.tangents;
                spendCorners(source.size(), place);
                const Accessor accessor(model_, buffers_, accessorIndex, name_);
                deltas.reserve(source.size());
                for (const std::uint32_t i : source) {
                    const glm::vec4 delta = accessor.at(i);
                    if (!finite(delta)) fail(place, fmt::format("element {} is NaN or infinite", i));
                    deltas.emplace_back(delta);
                }
            }
            mesh.morphTargets.push_back(std::move(target));
        }
    }

    void fillTangents(Mesh& mesh, int accessorIndex, const std::vector<std::uint32_t>& source,
                      const std::string& path) const {
        if (accessorIndex >= 0) {
            const Accessor tangents(model_, buffers_, accessorIndex, name_);
            for (const std::uint32_t i : source) {
                const glm::vec4 t = tangents.at(i);
                const float length = glm::length(glm::vec3(t));
                if (!finite(t) || !(length > 0)) break;
                mesh.tangents.emplace_back(glm::vec3(t) / length, t.w < 0 ? -1.0f : 1.0f);
            }
            if (mesh.tangents.size() == source.size()) return;
            log::warn("{}: {}.attributes.TANGENT: tangents without direction; all are made anew", name_, path);
        }
        const TextureSlot& slot = scene_.materials[sizeOf(mesh.material)].normalTexture;
        std::vector<glm::vec2> uv;
        for (const glm::vec2& raw : mesh.texCoords[sizeOf(slot.texCoord)])
            uv.push_back(slot.uvTransform * glm::vec3(raw, 1));
        makeTangents(mesh, uv);
    }

    // ---- nodes and what they carry

    void addNodes() {
        std::vector<int> roots;
        if (!model_.scenes.empty()) {
            roots = model_.scenes[sizeOf(std::max(model_.defaultScene, 0))].nodes;
        } else {
            std::vector<char> isChild(model_.nodes.size(), 0);
            for (const tinygltf::Node& node : model_.nodes)
                for (const int child : node.children) isChild[sizeOf(child)] = 1;
            for (Size i = 0; i < model_.nodes.size(); ++i)
                if (!isChild[i]) roots.push_back(static_cast<int>(i));
        }
        nodeIndex_.assign(model_.nodes.size(), -1);
        // A stack of our own: the hierarchy may be deeper than the program's.
        std::vector<std::pair<int, int>> pending;
        for (auto it = roots.rbegin(); it != roots.rend(); ++it) pending.emplace_back(*it, -1);
        while (!pending.empty()) {
            const auto [index, parent] = pending.back();
            pending.pop_back();
            const int place = addNode(index, parent);
            const std::vector<int>& children = model_.nodes[sizeOf(index)].children;
            for (auto it = children.rbegin(); it != children.rend(); ++it) pending.emplace_back(*it, place);
        }
        if (roots.size() < model_.nodes.size() && scene_.nodes.size() < model_.nodes.size())
            ignored_.insert("nodes outside the scene that is shown");
    }

    int addNode(int index, int parent) {
        const tinygltf::Node& in = model_.nodes[sizeOf(index)];
        const int place = static_cast<int>(scene_.nodes.size());
        nodeIndex_[sizeOf(index)] = place;
        Node node;
        node.name = in.name;
        node.fileIndex = index;
        node.parent = parent;
        if (in.matrix.size() == 16) {
            node.hasMatrix = true;
            for (int column = 0; column < 4; ++column)
                for (int row = 0; row < 4; ++row) node.localMatrix[column][row] = in.matrix[sizeOf(4 * column + row)];
        }
        const auto &t = in.translation, &r = in.rotation, &s = in.scale;
        if (t.size() == 3) node.translation = {t[0], t[1], t[2]};
        if (r.size() == 4) node.rotation = glm::normalize(glm::dquat(r[3], r[0], r[1], r[2]));
        if (s.size() == 3) node.scale = {s[0], s[1], s[2]};
        for (const double weight : in.weights) node.morphWeights.push_back(static_cast<float>(weight));
        scene_.nodes.push_back(node);

        if (in.mesh >= 0)
            for (const int mesh : meshesOf_[sizeOf(in.mesh)]) addInstance(mesh, place, in.skin, index);
        if (in.camera >= 0) addCamera(model_.cameras[sizeOf(in.camera)], place);
        if (const auto it = in.extensions.find("KHR_lights_punctual"); it != in.extensions.end())
            addLight(model_.lights[sizeOf(it->second.Get("light").GetNumberAsInt())], place);
        return place;
    }

    void addInstance(int meshIndex, int node, int skin, int fileNode) {
        Instance instance{meshIndex, node, -1};
        const Mesh& mesh = scene_.meshes[sizeOf(meshIndex)];
        if (skin >= 0 && mesh.joints.empty()) {
            ignored_.insert("skins of meshes without JOINTS_0");
        } else if (skin >= 0) {
            const LargestJoint& largest = largestJoint_.at(meshIndex);
            const Size joints = model_.skins[sizeOf(skin)].joints.size();
            if (largest.joint >= joints)
                fail(largest.path + ".attributes.JOINTS_0",
                     fmt::format("element {} names joint {}, but skins[{}] has {}", largest.vertex, largest.joint, skin,
                                 joints));
            const auto place = skinIndex_.try_emplace(skin, static_cast<int>(skinIndex_.size())).first;
            instance.skin = place->second;
        }
        // Every deformed instance has vertices of its own.
        if (instance.skin >= 0 || !mesh.morphTargets.empty())
            spendCorners(mesh.positions.size(), fmt::format("nodes[{}].mesh", fileNode));
        scene_.instances.push_back(instance);
    }

    /// The skins that instances use, once all nodes have their places.
    void addSkins() {
        scene_.skins.resize(skinIndex_.size());
        for (const auto& [index, place] : skinIndex_) {
            const tinygltf::Skin& in = model_.skins[sizeOf(index)];
            Skin& skin = scene_.skins[sizeOf(place)];
            skin.name = in.name;
            for (Size k = 0; k < in.joints.size(); ++k) {
                const int joint = nodeIndex_[sizeOf(in.joints[k])];
                if (joint < 0)
                    fail(fmt::format("skins[{}].joints[{}]", index, k),
                         fmt::format("nodes[{}] is not in the scene that is shown", in.joints[k]));
                skin.joints.push_back(joint);
            }
            skin.inverseBindMatrices.assign(skin.joints.size(), glm::dmat4(1));
            if (in.inverseBindMatrices < 0) continue;
            const Accessor matrices(model_, buffers_, in.inverseBindMatrices, name_);
            for (Size k = 0; k < skin.joints.size(); ++k) {
                for (int c = 0; c < 16; ++c) {
                    const float value = matrices.floatAt(k, sizeOf(c));
                    if (!std::isfinite(value))
                        fail(fmt::format("skins[{}].inverseBindMatrices", index),
                             fmt::format("matrix {} is not finite", k));
                    skin.inverseBindMatrices[k][c / 4][c % 4] = static_cast<double>(value);
                }
            }
        }
    }

    void addCamera(const tinygltf::Camera& in, int node) {
        if (in.type != "perspective") return;
        Camera camera;
        camera.name = in.name;
        camera.node = node;
        camera.verticalFovDeg = glm::degrees(in.perspective.yfov);
        camera.near = in.perspective.znear;
        camera.far = in.perspective.zfar;
        scene_.cameras.push_back(camera);
    }

    void addLight(const tinygltf::Light& in, int node) {
        Light light;
        if (in.type == "directional") {
            light.type = LightType::directional;
        } else if (in.type == "spot") {
            light.type = LightType::spot;
        } else if (in.type != "point") {
            return;
        }
        light.name = in.name;
        light.node = node;
        light.direction = {0, 0, -1};
        light.up = {0, 1, 0};
        light.intensity = glm::vec3(static_cast<float>(in.intensity));
        for (Size c = 0; c < in.color.size() && c < 3; ++c)
            light.intensity[static_cast<int>(c)] *= static_cast<float>(in.color[c]);
        light.range = light.type == LightType::directional ? 0 : in.range;
        if (light.type == LightType::spot) {
            light.innerConeAngle = in.spot.innerConeAngle;
            light.outerConeAngle = in.spot.outerConeAngle;
        }
        scene_.lights.push_back(light);
    }

    void addAnimation(Size index) {
        const tinygltf::Animation& in = model_.animations[index];
        Animation animation;
        animation.name = in.name;
        for (const tinygltf::AnimationChannel& source : in.channels) {
            AnimationChannel channel;
            if (source.target_node < 0) continue;
            channel.node = nodeIndex_[sizeOf(source.target_node)];
            if (channel.node < 0) continue;
            if (source.target_path == "rotation") {
                channel.property = AnimatedProperty::rotation;
            } else if (source.target_path == "scale") {
                channel.property = AnimatedProperty::scale;
            } else if (source.target_path == "weights") {
                channel.property = AnimatedProperty::morph_weights;
            } else if (source.target_path != "translation") {
                continue;
            }
            const tinygltf::AnimationSampler& sampler = in.samplers[sizeOf(source.sampler)];
            channel.interpolation = sampler.interpolation == "STEP"          ? Interpolation::step
                                    : sampler.interpolation == "CUBICSPLINE" ? Interpolation::cubic_spline
                                                                             : Interpolation::linear;
            readKeys(channel, sampler, fmt::format("animations[{}].samplers[{}]", index, source.sampler));
            animation.channels.push_back(std::move(channel));
        }
        if (!animation.channels.empty()) scene_.animations.push_back(std::move(animation));
    }

    void readKeys(AnimationChannel& channel, const tinygltf::AnimationSampler& sampler, const std::string& path) const {
        const Accessor times(model_, buffers_, sampler.input, name_), values(model_, buffers_, sampler.output, name_);
        for (Size i = 0; i < times.count(); ++i) {
            const float time = times.at(i).x;
            if (!std::isfinite(time) || time < 0 || (i > 0 && time <= channel.times.back()))
                fail(path + ".input",
                     fmt::format("key {} at {:g} s: times are not finite, from 0 on and increasing", i, time));
            channel.times.push_back(time);
        }
        const bool spline = channel.interpolation == Interpolation::cubic_spline;
        for (Size i = 0; i < values.count(); ++i) {
            const glm::vec4 value = values.at(i);
            if (!finite(value)) fail(path + ".output", fmt::format("value {} is NaN or infinite", i));
            const bool key = !spline || i % 3 == 1;
            if (key && channel.property == AnimatedProperty::rotation && value == glm::vec4(0))
                fail(path + ".output", fmt::format("value {} is a quaternion of length 0", i));
            if (channel.property == AnimatedProperty::morph_weights) {
                channel.weights.push_back(value.x);
            } else {
                channel.values.push_back(value);
            }
        }
    }

    GltfFile file_;
    const std::string name_;
    Ignored ignored_;
    Scene scene_;
    tinygltf::Model model_;
    std::vector<Bytes> buffers_;
    std::uint64_t bufferBytes_ = 0, corners_ = 0;
    json images_;
    std::vector<std::vector<int>> indicesOf_;  ///< by mesh and primitive: accessor of the indices, −1 for none

    std::map<std::tuple<int, Wrap, Wrap, bool>, int> textureIndex_;
    std::vector<Size> imageOfTexture_;
    std::vector<std::array<int, 2>> uvSets_;  ///< by material: the file's set behind slots 0 and 1
    int defaultMaterial_ = -1;
    std::vector<std::vector<int>> meshesOf_;  ///< by mesh of the file
    /// Of a mesh with joints: the largest joint that carries a vertex, and which vertex of which primitive.
    struct LargestJoint {
        Size joint = 0;
        std::uint32_t vertex = 0;
        std::string path;
    };
    std::map<int, LargestJoint> largestJoint_;  ///< by index in Scene::meshes
    std::map<int, int> skinIndex_;              ///< from the file's skins to Scene::skins, for those in use
    std::vector<int> nodeIndex_;                ///< by node of the file, −1 outside the scene
};

}  // namespace

Scene loadGltf(const std::filesystem::path& file) {
    return Loader(file).run();
}

}  // namespace voxcone
