#include "scene/gltf_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <map>

#include "core/error.h"

namespace voxcone {

namespace {

using nlohmann::json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::int64_t kMaxInt = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kMaxSize = std::int64_t{1} << 53;  // what JSON numbers hold exactly
// Products of two such numbers are still floats.
constexpr double kLargest = 1e18;
// Exporters round: 1.0000001 is taken for 1.
constexpr double kForgiven = 1e-3;

const std::set<std::string> kSupportedExtensions = {"KHR_lights_punctual",
                                                    "KHR_materials_diffuse_transmission",
                                                    "KHR_materials_emissive_strength",
                                                    "KHR_materials_ior",
                                                    "KHR_materials_specular",
                                                    "KHR_materials_transmission",
                                                    "KHR_materials_unlit",
                                                    "KHR_materials_volume",
                                                    "KHR_mesh_quantization",
                                                    "KHR_texture_transform"};

enum ComponentType { kByte = 5120, kUByte = 5121, kShort = 5122, kUShort = 5123, kUInt = 5125, kFloat = 5126 };

int componentSize(int componentType) {
    switch (componentType) {
        case kByte:
        case kUByte:
            return 1;
        case kShort:
        case kUShort:
            return 2;
        default:
            return 4;
    }
}

std::string join(const std::string& path, const std::string& key) {
    return path.empty() ? key : path + "." + key;
}
std::string at(const std::string& path, std::size_t i) {
    return fmt::format("{}[{}]", path, i);
}

/// A JSON object under check. Getters refuse wrong types and ranges; keys that nobody asked for are erased at the end.
class Object {
  public:
    Object(const std::string& file, json& value, std::string path)
        : file_(file), value_(value), path_(std::move(path)) {
        if (!value.is_object()) refuse("", "is not an object");
    }
    ~Object() {
        if (!value_.is_object()) return;
        for (auto it = value_.begin(); it != value_.end();)
            it = asked_.count(it.key()) ? std::next(it) : value_.erase(it);
    }
    Object(Object&&) = delete;

    const std::string& path() const { return path_; }
    std::string path(const std::string& key) const { return key.empty() ? path_ : join(path_, key); }
    [[noreturn]] void refuse(const std::string& key, const std::string& reason) const {
        throw InputError(file_, path(key), reason);
    }
    bool has(const std::string& key) const { return value_.contains(key); }

    json* find(const std::string& key) {
        const auto it = value_.find(key);
        if (it == value_.end()) return nullptr;
        asked_.insert(key);
        return &*it;
    }
    void require(const std::string& key) const {
        if (!has(key)) refuse(key, "is missing");
    }

    /// Lets a string through to the reader, for names; anything else is erased.
    void name() {
        if (value_.contains("name") && value_["name"].is_string()) asked_.insert("name");
    }

    double number(const std::string& key, double fallback, double low = -kLargest, double high = kLargest) {
        json* v = find(key);
        return v ? checkedNumber(*v, path(key), low, high) : fallback;
    }
    std::int64_t integer(const std::string& key, std::int64_t fallback, std::int64_t low, std::int64_t high) {
        json* v = find(key);
        return v ? checkedInteger(*v, path(key), low, high) : fallback;
    }
    /// Index into an array of `count` things called `what`; −1 when absent.
    std::int64_t index(const std::string& key, std::size_t count, const char* what) {
        json* v = find(key);
        return v ? checkedIndex(*v, path(key), count, what) : -1;
    }
    bool boolean(const std::string& key, bool fallback) {
        json* v = find(key);
        if (v && !v->is_boolean()) refuse(key, "is not true or false");
        return v ? v->get<bool>() : fallback;
    }
    std::string string(const std::string& key, const std::string& fallback) {
        json* v = find(key);
        if (v && !v->is_string()) refuse(key, "is not a string");
        return v ? v->get<std::string>() : fallback;
    }
    /// Array of exactly `count` numbers; empty when absent.
    std::vector<double> numbers(const std::string& key, std::size_t count, double low = -kLargest,
                                double high = kLargest) {
        json* v = find(key);
        if (!v) return {};
        if (!v->is_array() || v->size() != count) refuse(key, fmt::format("is not an array of {} numbers", count));
        std::vector<double> result;
        for (std::size_t i = 0; i < count; ++i) result.push_back(checkedNumber((*v)[i], at(path(key), i), low, high));
        return result;
    }
    std::vector<std::int64_t> indices(const std::string& key, std::size_t count, const char* what) {
        std::vector<std::int64_t> result;
        json* v = find(key);
        if (!v) return result;
        if (!v->is_array()) refuse(key, "is not an array");
        for (std::size_t i = 0; i < v->size(); ++i)
            result.push_back(checkedIndex((*v)[i], at(path(key), i), count, what));
        return result;
    }
    /// Calls `visit` with the object under `key` when there is one.
    bool object(const std::string& key, const std::function<void(Object&)>& visit) {
        json* v = find(key);
        if (!v) return false;
        Object child(file_, *v, path(key));
        visit(child);
        return true;
    }
    /// Calls `visit` with each object of the array under `key` and its place.
    void array(const std::string& key, const std::function<void(Object&, std::size_t)>& visit) {
        for (std::size_t i = 0, count = arraySize(key); i < count; ++i) {
            Object child(file_, value_[key][i], at(path(key), i));
            visit(child, i);
        }
    }
    std::size_t arraySize(const std::string& key) {
        json* v = find(key);
        if (!v) return 0;
        if (!v->is_array()) refuse(key, "is not an array");
        return v->size();
    }
    /// Calls `visit` with extension `name` when it is there. What is kept of "extensions" is keepExtensions' to say.
    void extension(const std::string& name, const std::function<void(Object&)>& visit) {
        if (!has("extensions")) return;
        if (!value_["extensions"].is_object()) refuse("extensions", "is not an object");
        if (!value_["extensions"].contains(name)) return;
        Object child(file_, value_["extensions"][name], join(path("extensions"), name));
        visit(child);
    }
    /// Keeps these extensions for the reader and erases all others.
    void keepExtensions(std::initializer_list<const char*> names) {
        if (!has("extensions")) return;
        object("extensions", [&](Object& extensions) {
            for (const char* name : names) extensions.find(name);
        });
    }
    json& raw() { return value_; }

  private:
    double checkedNumber(json& v, const std::string& where, double low, double high) {
        if (!v.is_number()) throw InputError(file_, where, "is not a number");
        double x = v.get<double>();
        if (!std::isfinite(x) || x < low - kForgiven || x > high + kForgiven)
            throw InputError(file_, where, fmt::format("is {:g}, outside [{:g}, {:g}]", x, low, high));
        if (x < low || x > high) v = x = std::clamp(x, low, high);
        return x;
    }
    std::int64_t checkedInteger(json& v, const std::string& where, std::int64_t low, std::int64_t high) {
        if (!v.is_number()) throw InputError(file_, where, "is not a number");
        const double x = v.get<double>();
        if (x != std::floor(x) || std::abs(x) > static_cast<double>(kMaxSize))
            throw InputError(file_, where, fmt::format("is {:g}, not an integer", x));
        const auto i = static_cast<std::int64_t>(x);
        if (i < low || i > high) throw InputError(file_, where, fmt::format("is {}, outside [{}, {}]", i, low, high));
        v = i;
        return i;
    }
    std::int64_t checkedIndex(json& v, const std::string& where, std::size_t count, const char* what) {
        const std::int64_t i = checkedInteger(v, where, -kMaxSize, kMaxSize);
        if (i < 0 || static_cast<std::uint64_t>(i) >= count)
            throw InputError(file_, where, fmt::format("is {}, but there are {} {}", i, count, what));
        return i;
    }

    const std::string& file_;
    json& value_;
    std::string path_;
    std::set<std::string> asked_;
};

struct View {
    std::uint64_t byteOffset = 0, byteLength = 0, byteStride = 0;
    std::size_t buffer = 0;
};

struct AccessorFacts {
    std::string type;
    int componentType = 0;
    std::uint64_t count = 0;
    bool normalized = false;
    std::vector<std::int64_t> views;  ///< that its elements are in, sparse ones included
};

class Checker {
  public:
    Checker(GltfFile& file, Ignored& ignored)
        : file_(file), name_(file.path.string()), ignored_(ignored), root_(name_, file.document, "") {}

    void run() {
        checkAsset();
        checkExtensions();
        for (const char* key : {"buffers", "bufferViews", "accessors", "images", "samplers", "textures", "materials",
                                "meshes", "cameras", "nodes", "scenes", "skins", "animations"})
            counts_[key] = root_.arraySize(key);
        checkBuffers();
        checkViews();
        checkAccessors();
        checkTextures();
        checkMaterials();
        checkMeshes();
        checkCameras();
        checkLights();
        checkNodes();
        checkScenes();
        checkSkins();
        checkAnimations();
        root_.keepExtensions({"KHR_lights_punctual"});
    }

  private:
    std::size_t count(const char* what) const { return counts_.at(what); }
    std::int64_t indexOf(Object& object, const std::string& key, const char* what) {
        return object.index(key, count(what), what);
    }

    void checkAsset() {
        root_.require("asset");
        root_.object("asset", [&](Object& asset) {
            asset.require("version");
            const std::string version = asset.string("version", "");
            // "2.x": later minor versions are meant to be readable by older loaders.
            auto parse = [&](const char* key, const std::string& text) {
                int major = 0, minor = 0, used = 0;
                if (std::sscanf(text.c_str(), "%4d.%4d%n", &major, &minor, &used) != 2 ||
                    static_cast<std::size_t>(used) != text.size() || major < 0 || minor < 0)
                    asset.refuse(key, fmt::format("'{}' is not a version", printable(text)));
                return std::pair(major, minor);
            };
            if (parse("version", version).first != 2)
                asset.refuse("version", fmt::format("glTF {} is not supported, only 2.0", printable(version)));
            if (asset.has("minVersion")) {
                const std::string least = asset.string("minVersion", "");
                if (parse("minVersion", least) > std::pair(2, 0))
                    asset.refuse("minVersion", fmt::format("needs glTF {}, only 2.0 is supported", printable(least)));
            }
        });
    }

    void checkExtensions() {
        for (const char* key : {"extensionsUsed", "extensionsRequired"}) {
            json* names = root_.find(key);
            if (!names) continue;
            if (!names->is_array()) root_.refuse(key, "is not an array");
            for (std::size_t i = 0; i < names->size(); ++i) {
                if (!(*names)[i].is_string()) throw InputError(name_, at(key, i), "is not a string");
                const auto extension = (*names)[i].get<std::string>();
                quantized_ |= extension == "KHR_mesh_quantization";
                if (std::string(key) == "extensionsRequired" && !kSupportedExtensions.count(extension))
                    throw InputError(name_, at(key, i),
                                     fmt::format("extension {} is not supported", printable(extension)));
                if (!kSupportedExtensions.count(extension))
                    ignored_.insert(fmt::format("extension {}", printable(extension)));
            }
        }
    }

    void checkBuffers() {
        root_.array("buffers", [&](Object& buffer, std::size_t i) {
            buffer.require("byteLength");
            const auto length = static_cast<std::uint64_t>(buffer.integer("byteLength", 0, 1, kMaxSize));
            bufferSizes_.push_back(length);
            bufferHasData_.push_back(true);
            std::uint64_t present = 0;
            if (buffer.has("uri")) {
                present = uriSize(file_, buffer.string("uri", ""), buffer.path("uri"));
            } else if (i == 0 && file_.binary) {
                present = file_.binary->size();
            } else {
                bufferHasData_.back() = false;
                return;  // legal so long as nobody reads from it
            }
            if (present < length)
                buffer.refuse("byteLength", fmt::format("is {}, but its data has {} bytes", length, present));
        });
    }

    void checkViews() {
        root_.array("bufferViews", [&](Object& object, std::size_t) {
            object.require("buffer");
            object.require("byteLength");
            const auto buffer = static_cast<std::size_t>(indexOf(object, "buffer", "buffers"));
            View view;
            view.byteOffset = static_cast<std::uint64_t>(object.integer("byteOffset", 0, 0, kMaxSize));
            view.byteLength = static_cast<std::uint64_t>(object.integer("byteLength", 0, 1, kMaxSize));
            view.byteStride = static_cast<std::uint64_t>(object.integer("byteStride", 0, 4, 252));
            if (view.byteStride % 4 != 0) object.refuse("byteStride", "is not a multiple of 4");
            view.buffer = buffer;
            if (view.byteOffset + view.byteLength > bufferSizes_[buffer])
                object.refuse("byteLength",
                              fmt::format("bytes {} to {} reach past buffers[{}] of {} bytes", view.byteOffset,
                                          view.byteOffset + view.byteLength, buffer, bufferSizes_[buffer]));
            views_.push_back(view);
        });
    }

    /// `elements` of `size` bytes, `stride` apart, from `offset` on must lie in `view`.
    void checkRange(Object& object, const View& view, std::uint64_t offset, std::uint64_t elements, std::uint64_t size,
                    std::uint64_t stride, std::uint64_t alignment) {
        // No overflow: offset, elements ≤ 2^53 and stride ≤ 252.
        const std::uint64_t end = offset + stride * (elements - 1) + size;
        if (end > view.byteLength)
            object.refuse("", fmt::format("{} elements end at byte {} of a buffer view of {} bytes", elements, end,
                                          view.byteLength));
        if (offset % alignment != 0 || (view.byteOffset + offset) % alignment != 0 || stride % alignment != 0)
            object.refuse("byteOffset", fmt::format("elements are not aligned to {} bytes", alignment));
    }

    void checkAccessors() {
        root_.array("accessors", [&](Object& object, std::size_t) {
            for (const char* key : {"componentType", "count", "type"}) object.require(key);
            object.name();
            AccessorFacts facts;
            facts.componentType = static_cast<int>(object.integer("componentType", 0, 0, kMaxInt));
            if (facts.componentType < kByte || facts.componentType > kFloat || facts.componentType == 5124)
                object.refuse("componentType", fmt::format("{} is no component type", facts.componentType));
            facts.type = object.string("type", "");
            const std::uint64_t size = elementSize(facts.type, facts.componentType);
            if (size == 0) object.refuse("type", fmt::format("'{}' is no accessor type", printable(facts.type)));
            facts.count = static_cast<std::uint64_t>(object.integer("count", 0, 1, kMaxInt));
            facts.normalized = object.boolean("normalized", false);
            if (facts.normalized && (facts.componentType == kFloat || facts.componentType == kUInt))
                object.refuse("normalized", "is not allowed for float and unsigned int components");
            const auto offset = static_cast<std::uint64_t>(object.integer("byteOffset", 0, 0, kMaxSize));
            const std::int64_t view = indexOf(object, "bufferView", "bufferViews");
            const auto alignment = static_cast<std::uint64_t>(componentSize(facts.componentType));
            if (view >= 0) {
                facts.views.push_back(view);
                const View& v = views_[static_cast<std::size_t>(view)];
                if (v.byteStride != 0 && v.byteStride < size)
                    object.refuse("bufferView",
                                  fmt::format("stride {} is less than the element's {} bytes", v.byteStride, size));
                checkRange(object, v, offset, facts.count, size, v.byteStride ? v.byteStride : size, alignment);
            } else if (facts.count * size > kMaxImplicitBytes) {
                object.refuse("count", fmt::format("{} elements without data", facts.count));
            }
            object.object("sparse", [&](Object& sparse) { checkSparse(sparse, facts, size, alignment); });
            accessors_.push_back(facts);
        });
    }

    void checkSparse(Object& sparse, AccessorFacts& facts, std::uint64_t size, std::uint64_t alignment) {
        for (const char* key : {"count", "indices", "values"}) sparse.require(key);
        const auto elements =
            static_cast<std::uint64_t>(sparse.integer("count", 1, 1, static_cast<std::int64_t>(facts.count)));
        sparse.object("indices", [&](Object& indices) {
            indices.require("bufferView");
            indices.require("componentType");
            const auto type = indices.integer("componentType", 0, 0, kMaxInt);
            if (type != kUByte && type != kUShort && type != kUInt)
                indices.refuse("componentType", fmt::format("{} is no index type", type));
            const auto bytes = static_cast<std::uint64_t>(componentSize(static_cast<int>(type)));
            checkRange(indices, viewOf(indices, facts), offsetOf(indices), elements, bytes, bytes, bytes);
        });
        sparse.object("values", [&](Object& values) {
            values.require("bufferView");
            checkRange(values, viewOf(values, facts), offsetOf(values), elements, size, size, alignment);
        });
    }
    const View& viewOf(Object& object, AccessorFacts& facts) {
        facts.views.push_back(indexOf(object, "bufferView", "bufferViews"));
        return views_[static_cast<std::size_t>(facts.views.back())];
    }
    /// The accessor under `key`, whose data somebody is going to read.
    const AccessorFacts& used(const Object& object, const std::string& key, std::int64_t index) const {
        const AccessorFacts& accessor = accessors_[static_cast<std::size_t>(index)];
        for (const std::int64_t view : accessor.views) {
            const std::size_t buffer = views_[static_cast<std::size_t>(view)].buffer;
            if (!bufferHasData_[buffer])
                object.refuse(key, fmt::format("accessors[{}] is in buffers[{}], which has no data", index, buffer));
        }
        return accessor;
    }
    std::uint64_t offsetOf(Object& object) {
        return static_cast<std::uint64_t>(object.integer("byteOffset", 0, 0, kMaxInt));
    }

    void checkTextures() {
        root_.array("images", [&](Object& image, std::size_t) {
            image.name();
            if (image.has("uri") == image.has("bufferView"))
                image.refuse("", "needs exactly one of uri and bufferView");
            if (image.has("uri")) {
                image.string("uri", "");
            } else {
                indexOf(image, "bufferView", "bufferViews");
            }
        });
        root_.array("samplers", [&](Object& sampler, std::size_t) {
            auto oneOf = [&](const char* key, std::initializer_list<std::int64_t> allowed) {
                const std::int64_t value = sampler.integer(key, *allowed.begin(), 0, kMaxInt);
                if (std::find(allowed.begin(), allowed.end(), value) == allowed.end())
                    sampler.refuse(key, fmt::format("{} is not one of {}", value, fmt::join(allowed, ", ")));
            };
            oneOf("magFilter", {9728, 9729});
            oneOf("minFilter", {9728, 9729, 9984, 9985, 9986, 9987});
            oneOf("wrapS", {10497, 33071, 33648});
            oneOf("wrapT", {10497, 33071, 33648});
        });
        root_.array("textures", [&](Object& texture, std::size_t) {
            texture.name();
            indexOf(texture, "sampler", "samplers");
            if (indexOf(texture, "source", "images") < 0)
                ignored_.insert("textures whose image is in an extension's format");
        });
    }

    bool checkTextureInfo(Object& owner, const char* key, const std::function<void(Object&)>& more = {}) {
        return owner.object(key, [&](Object& info) {
            info.require("index");
            indexOf(info, "index", "textures");
            info.integer("texCoord", 0, 0, kMaxInt);
            if (more) more(info);
            info.extension("KHR_texture_transform", [&](Object& transform) {
                transform.numbers("offset", 2);
                transform.number("rotation", 0);
                transform.numbers("scale", 2);
                transform.integer("texCoord", 0, 0, kMaxInt);
            });
            info.keepExtensions({"KHR_texture_transform"});
        });
    }

    void checkMaterials() {
        root_.array("materials", [&](Object& material, std::size_t) {
            material.name();
            material.object("pbrMetallicRoughness", [&](Object& pbr) {
                pbr.numbers("baseColorFactor", 4, 0, 1);
                pbr.number("metallicFactor", 1, 0, 1);
                pbr.number("roughnessFactor", 1, 0, 1);
                checkTextureInfo(pbr, "baseColorTexture");
                checkTextureInfo(pbr, "metallicRoughnessTexture");
            });
            checkTextureInfo(material, "normalTexture", [](Object& info) { info.number("scale", 1); });
            checkTextureInfo(material, "occlusionTexture", [](Object& info) { info.number("strength", 1, 0, 1); });
            checkTextureInfo(material, "emissiveTexture");
            // Above 1 is common from before KHR_materials_emissive_strength, and its meaning is plain.
            material.numbers("emissiveFactor", 3, 0);
            const std::string mode = material.string("alphaMode", "OPAQUE");
            if (mode != "OPAQUE" && mode != "MASK" && mode != "BLEND")
                material.refuse("alphaMode", fmt::format("'{}' is not OPAQUE, MASK or BLEND", printable(mode)));
            material.number("alphaCutoff", 0.5, 0);
            material.boolean("doubleSided", false);
            // Other programs' extras are their own, and need not be objects.
            if (material.has("extras") && material.raw()["extras"].is_object())
                material.object("extras", [](Object& extras) {
                    if (!extras.has("voxcone_matter")) return;
                    const std::string matter = extras.string("voxcone_matter", "");
                    if (matter != "solid" && matter != "leaves")
                        extras.refuse("voxcone_matter", fmt::format("'{}' is not solid or leaves", printable(matter)));
                });
            material.extension("KHR_materials_unlit", [](Object&) {});
            material.extension("KHR_materials_emissive_strength",
                               [](Object& e) { e.number("emissiveStrength", 1, 0); });
            material.extension("KHR_materials_transmission", [&](Object& e) {
                e.number("transmissionFactor", 0, 0, 1);
                checkTextureInfo(e, "transmissionTexture");
            });
            material.extension("KHR_materials_volume", [&](Object& e) {
                e.number("thicknessFactor", 0, 0);
                checkTextureInfo(e, "thicknessTexture");
                if (e.has("attenuationDistance") && !(e.number("attenuationDistance", 1, 0) > 0))
                    e.refuse("attenuationDistance", "is not above 0");
                e.numbers("attenuationColor", 3, 0, 1);
            });
            material.extension("KHR_materials_diffuse_transmission", [&](Object& e) {
                e.number("diffuseTransmissionFactor", 0, 0, 1);
                checkTextureInfo(e, "diffuseTransmissionTexture");
                e.numbers("diffuseTransmissionColorFactor", 3, 0, 1);
                checkTextureInfo(e, "diffuseTransmissionColorTexture");
            });
            material.extension("KHR_materials_ior", [](Object& e) {
                const double ior = e.number("ior", 1.5, 0);
                if (ior != 0 && ior < 1) e.refuse("ior", fmt::format("is {:g}, neither 0 nor at least 1", ior));
            });
            material.extension("KHR_materials_specular", [&](Object& e) {
                e.number("specularFactor", 1, 0, 1);
                e.numbers("specularColorFactor", 3, 0);
                if (e.has("specularTexture") || e.has("specularColorTexture"))
                    ignored_.insert("textures of KHR_materials_specular");
            });
            material.keepExtensions({"KHR_materials_unlit", "KHR_materials_emissive_strength",
                                     "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior",
                                     "KHR_materials_diffuse_transmission", "KHR_materials_specular"});
        });
    }

    /// `delta`: in a morph target, where tangents have no handedness.
    void checkAttribute(Object& attributes, const std::string& semantic, std::uint64_t& vertexCount,
                        bool delta = false) {
        const std::int64_t index = indexOf(attributes, semantic, "accessors");
        if (index < 0) return;
        const AccessorFacts& accessor = used(attributes, semantic, index);
        const int c = accessor.componentType;
        const bool isFloat = c == kFloat;
        const bool unsignedNorm = accessor.normalized && (c == kUByte || c == kUShort);
        const bool small = c == kByte || c == kUByte || c == kShort || c == kUShort;
        bool right = false;
        if (semantic == "POSITION") {
            right = accessor.type == "VEC3" && (isFloat || (quantized_ && small));
        } else if (semantic == "NORMAL") {
            right = accessor.type == "VEC3" &&
                    (isFloat || (quantized_ && accessor.normalized && (c == kByte || c == kShort)));
        } else if (semantic == "TANGENT") {
            right = accessor.type == (delta ? "VEC3" : "VEC4") &&
                    (isFloat || (quantized_ && accessor.normalized && (c == kByte || c == kShort)));
        } else if (semantic == "JOINTS_0") {
            right = accessor.type == "VEC4" && !accessor.normalized && (c == kUByte || c == kUShort);
        } else if (semantic == "WEIGHTS_0") {
            right = accessor.type == "VEC4" && (isFloat || unsignedNorm);
        } else if (semantic.starts_with("TEXCOORD_")) {
            right = accessor.type == "VEC2" && (isFloat || unsignedNorm || (quantized_ && small));
        } else {
            right = (accessor.type == "VEC3" || accessor.type == "VEC4") && (isFloat || unsignedNorm);
        }
        if (!right)
            attributes.refuse(semantic, fmt::format("accessors[{}] is {}{} of component type {}, not allowed here",
                                                    index, accessor.normalized ? "normalized " : "", accessor.type, c));
        if (vertexCount != 0 && accessor.count != vertexCount)
            attributes.refuse(semantic,
                              fmt::format("has {} elements, but POSITION has {}", accessor.count, vertexCount));
        vertexCount = accessor.count;
    }

    void checkMeshes() {
        root_.array("meshes", [&](Object& mesh, std::size_t) {
            mesh.name();
            mesh.require("primitives");
            std::size_t targetCount = 0;
            mesh.array("primitives", [&](Object& primitive, std::size_t place) {
                primitive.require("attributes");
                primitive.integer("mode", 4, 0, 6);
                indexOf(primitive, "material", "materials");
                std::uint64_t vertexCount = 0;
                primitive.object("attributes", [&](Object& attributes) {
                    checkAttribute(attributes, "POSITION", vertexCount);
                    std::vector<std::string> semantics;
                    for (const auto& item : attributes.raw().items()) semantics.push_back(item.key());
                    for (const std::string& semantic : semantics)
                        if (semantic == "NORMAL" || semantic == "TANGENT" || semantic == "COLOR_0" ||
                            semantic == "JOINTS_0" || semantic == "WEIGHTS_0" || semantic.starts_with("TEXCOORD_"))
                            checkAttribute(attributes, semantic, vertexCount);
                    for (const auto& [one, other] : {std::pair("JOINTS_0", "WEIGHTS_0"), {"WEIGHTS_0", "JOINTS_0"}})
                        if (attributes.has(one) && !attributes.has(other))
                            attributes.refuse(one, fmt::format("stands without {}", other));
                    if (attributes.has("JOINTS_1")) ignored_.insert("more than four joints a vertex");
                });
                const std::size_t targets = primitive.arraySize("targets");
                if (place > 0 && targets != targetCount)
                    primitive.refuse(
                        "targets", fmt::format("are {} morph targets, but primitives[0] has {}", targets, targetCount));
                targetCount = targets;
                primitive.array("targets", [&](Object& target, std::size_t) {
                    for (const auto& item : target.raw().items())
                        if (item.key().starts_with("TEXCOORD_") || item.key().starts_with("COLOR_"))
                            ignored_.insert("morph targets of texture coordinates and colours");
                    for (const char* semantic : {"POSITION", "NORMAL", "TANGENT"})
                        checkAttribute(target, semantic, vertexCount, true);
                });
                const std::int64_t indices = indexOf(primitive, "indices", "accessors");
                if (indices < 0) return;
                const AccessorFacts& accessor = used(primitive, "indices", indices);
                const int c = accessor.componentType;
                if (accessor.type != "SCALAR" || accessor.normalized || (c != kUByte && c != kUShort && c != kUInt))
                    primitive.refuse("indices",
                                     fmt::format("accessors[{}] is {}{} of component type {}, not unsigned "
                                                 "scalars",
                                                 indices, accessor.normalized ? "normalized " : "", accessor.type, c));
            });
            checkMorphWeights(mesh, targetCount);
            morphTargets_.push_back(targetCount);
        });
    }

    void checkMorphWeights(Object& object, std::size_t targets) {
        const std::size_t weights = object.arraySize("weights");
        object.numbers("weights", weights);
        if (weights > 0 && weights != targets)
            object.refuse("weights", fmt::format("are {} numbers for {} morph targets", weights, targets));
    }

    void checkSkins() {
        root_.array("skins", [&](Object& skin, std::size_t) {
            skin.name();
            skin.require("joints");
            const auto joints = skin.indices("joints", count("nodes"), "nodes");
            if (joints.empty()) skin.refuse("joints", "is empty");
            std::set<std::int64_t> seen;
            for (std::size_t k = 0; k < joints.size(); ++k)
                if (!seen.insert(joints[k]).second)
                    skin.refuse(at("joints", k), fmt::format("nodes[{}] stands twice", joints[k]));
            indexOf(skin, "skeleton", "nodes");
            const std::int64_t index = indexOf(skin, "inverseBindMatrices", "accessors");
            if (index < 0) return;
            const AccessorFacts& matrices = used(skin, "inverseBindMatrices", index);
            if (matrices.type != "MAT4" || matrices.componentType != kFloat)
                skin.refuse("inverseBindMatrices", fmt::format("accessors[{}] is {} of component type {}, not float "
                                                               "MAT4",
                                                               index, matrices.type, matrices.componentType));
            if (matrices.count < joints.size())
                skin.refuse("inverseBindMatrices", fmt::format("accessors[{}] has {} matrices for {} joints", index,
                                                               matrices.count, joints.size()));
        });
    }

    void checkCameras() {
        root_.array("cameras", [&](Object& camera, std::size_t) {
            camera.name();
            camera.require("type");
            const std::string type = camera.string("type", "");
            if (type == "orthographic") {
                ignored_.insert("orthographic cameras");
                camera.object("orthographic", [](Object& o) {
                    for (const char* key : {"xmag", "ymag", "znear", "zfar"}) {
                        o.require(key);
                        o.number(key, 0);
                    }
                });
                return;
            }
            if (type != "perspective") camera.refuse("type", fmt::format("'{}' is no camera type", printable(type)));
            camera.require("perspective");
            camera.object("perspective", [](Object& p) {
                p.require("yfov");
                p.require("znear");
                const double fov = p.number("yfov", 0), zNear = p.number("znear", 0),
                             zFar = p.number("zfar", kInfinity);
                if (!(fov > 0 && fov < 3.141592)) p.refuse("yfov", fmt::format("is {:g}, outside (0, π)", fov));
                if (!(zNear > 0)) p.refuse("znear", fmt::format("is {:g}, not above 0", zNear));
                if (!(zFar > zNear)) p.refuse("zfar", fmt::format("is {:g}, not above znear {:g}", zFar, zNear));
            });
        });
    }

    void checkLights() {
        lightCount_ = 0;
        root_.extension("KHR_lights_punctual", [&](Object& extension) {
            lightCount_ = extension.arraySize("lights");
            extension.array("lights", [&](Object& light, std::size_t) {
                light.name();
                light.require("type");
                const std::string type = light.string("type", "");
                light.numbers("color", 3, 0);
                light.number("intensity", 1, 0);
                if (light.has("range") && !(light.number("range", 0) > 0)) light.refuse("range", "is not above 0");
                if (type == "spot") {
                    light.require("spot");
                    light.object("spot", [](Object& spot) {
                        const double inner = spot.number("innerConeAngle", 0, 0, M_PI_2);
                        const double outer = spot.number("outerConeAngle", M_PI_4, 0, M_PI_2);
                        if (!(outer > inner))
                            spot.refuse("outerConeAngle",
                                        fmt::format("is {:g}, not above innerConeAngle {:g}", outer, inner));
                    });
                } else if (type != "point" && type != "directional") {
                    ignored_.insert(fmt::format("lights of type '{}'", printable(type)));
                }
            });
        });
    }

    void checkNodes() {
        parents_.assign(count("nodes"), -1);
        root_.array("nodes", [&](Object& node, std::size_t i) {
            node.name();
            const std::int64_t mesh = indexOf(node, "mesh", "meshes");
            morphTargetsOfNode_.push_back(mesh < 0 ? 0 : morphTargets_[static_cast<std::size_t>(mesh)]);
            if (mesh >= 0) checkMorphWeights(node, morphTargetsOfNode_.back());
            indexOf(node, "skin", "skins");
            indexOf(node, "camera", "cameras");
            const bool matrix = !node.numbers("matrix", 16).empty();
            node.numbers("translation", 3);
            const std::vector<double> rotation = node.numbers("rotation", 4);
            node.numbers("scale", 3);
            if (matrix && (node.has("translation") || node.has("rotation") || node.has("scale")))
                node.refuse("matrix", "stands beside translation, rotation or scale");
            if (matrix) matrixNodes_.insert(i);
            if (!rotation.empty() && std::all_of(rotation.begin(), rotation.end(), [](double x) { return x == 0; }))
                node.refuse("rotation", "is a quaternion of length 0");
            const auto children = node.indices("children", count("nodes"), "nodes");
            for (std::size_t k = 0; k < children.size(); ++k) {
                std::int64_t& parent = parents_[static_cast<std::size_t>(children[k])];
                if (parent >= 0)
                    node.refuse(at("children", k),
                                fmt::format("nodes[{}] is already a child of nodes[{}]", children[k], parent));
                parent = static_cast<std::int64_t>(i);
            }
            node.extension("KHR_lights_punctual", [&](Object& e) {
                e.require("light");
                e.index("light", lightCount_, "lights");
            });
            node.keepExtensions({"KHR_lights_punctual"});
        });
        // Every node has at most one parent, so a walk upwards that is longer than all nodes runs in a circle.
        std::vector<char> safe(parents_.size(), 0);
        for (std::size_t i = 0; i < parents_.size(); ++i) {
            std::vector<std::size_t> walk;
            std::size_t node = i;
            while (!safe[node]) {
                walk.push_back(node);
                if (walk.size() > parents_.size())
                    throw InputError(name_, at("nodes", i) + ".children", "nodes form a loop");
                if (parents_[node] < 0) break;
                node = static_cast<std::size_t>(parents_[node]);
            }
            for (const std::size_t passed : walk) safe[passed] = 1;
        }
    }

    void checkScenes() {
        indexOf(root_, "scene", "scenes");
        root_.array("scenes", [&](Object& scene, std::size_t) {
            scene.name();
            const auto nodes = scene.indices("nodes", count("nodes"), "nodes");
            std::set<std::int64_t> seen;
            for (std::size_t k = 0; k < nodes.size(); ++k) {
                if (parents_[static_cast<std::size_t>(nodes[k])] >= 0)
                    scene.refuse(at("nodes", k), fmt::format("nodes[{}] is a child of another node", nodes[k]));
                if (!seen.insert(nodes[k]).second)
                    scene.refuse(at("nodes", k), fmt::format("nodes[{}] stands twice", nodes[k]));
            }
        });
    }

    void checkAnimations() {
        root_.array("animations", [&](Object& animation, std::size_t) {
            animation.name();
            animation.require("channels");
            animation.require("samplers");
            struct Sampler {
                std::int64_t input, output;
                std::string interpolation;
            };
            std::vector<Sampler> samplers;
            animation.array("samplers", [&](Object& sampler, std::size_t) {
                sampler.require("input");
                sampler.require("output");
                samplers.push_back({indexOf(sampler, "input", "accessors"), indexOf(sampler, "output", "accessors"),
                                    sampler.string("interpolation", "LINEAR")});
                const std::string& interpolation = samplers.back().interpolation;
                if (interpolation != "LINEAR" && interpolation != "STEP" && interpolation != "CUBICSPLINE")
                    sampler.refuse("interpolation",
                                   fmt::format("'{}' is not LINEAR, STEP or CUBICSPLINE", printable(interpolation)));
                const AccessorFacts& input = used(sampler, "input", samplers.back().input);
                used(sampler, "output", samplers.back().output);
                if (input.type != "SCALAR" || input.componentType != kFloat)
                    sampler.refuse("input", "times are not float scalars");
                if (interpolation == "CUBICSPLINE" && input.count < 2)
                    sampler.refuse("input", "a cubic spline needs two keys or more");
            });
            std::set<std::pair<std::int64_t, std::string>> targets;
            animation.array("channels", [&](Object& channel, std::size_t) {
                channel.require("sampler");
                channel.require("target");
                const std::int64_t index = channel.index("sampler", samplers.size(), "samplers");
                std::string path;
                std::int64_t node = -1;
                channel.object("target", [&](Object& target) {
                    target.require("path");
                    path = target.string("path", "");
                    node = indexOf(target, "node", "nodes");
                    if (path != "translation" && path != "rotation" && path != "scale" && path != "weights") {
                        ignored_.insert(fmt::format("animation of '{}'", printable(path)));
                        return;
                    }
                    if (node < 0) return;
                    if (path != "weights" && matrixNodes_.count(static_cast<std::size_t>(node)))
                        target.refuse("node", fmt::format("nodes[{}] has a matrix and cannot be animated", node));
                    if (!targets.insert({node, path}).second)
                        target.refuse("path", fmt::format("{} of nodes[{}] is animated twice", path, node));
                });
                if (node < 0 || (path != "translation" && path != "rotation" && path != "scale" && path != "weights"))
                    return;
                const Sampler& sampler = samplers[static_cast<std::size_t>(index)];
                const AccessorFacts& input = accessors_[static_cast<std::size_t>(sampler.input)];
                const AccessorFacts& output = accessors_[static_cast<std::size_t>(sampler.output)];
                const bool rotation = path == "rotation", weights = path == "weights";
                const std::uint64_t numbers = weights ? morphTargetsOfNode_[static_cast<std::size_t>(node)] : 1;
                if (numbers == 0) channel.refuse("target.node", fmt::format("nodes[{}] has no morph targets", node));
                if (output.type != (rotation  ? "VEC4"
                                    : weights ? "SCALAR"
                                              : "VEC3") ||
                    !(output.componentType == kFloat || ((rotation || weights) && output.normalized)))
                    channel.refuse("sampler",
                                   fmt::format("values in accessors[{}] do not fit {}", sampler.output, path));
                // No overflow: counts of accessors are below 2^31, and there are not that many targets in a file.
                const std::uint64_t expected = numbers * input.count * (sampler.interpolation == "CUBICSPLINE" ? 3 : 1);
                if (output.count != expected)
                    channel.refuse("sampler", fmt::format("accessors[{}] has {} values, {} keys need {}",
                                                          sampler.output, output.count, input.count, expected));
            });
        });
    }

    /// Largest accessor that is all zeros but for sparse values: it costs memory without costing the file bytes.
    static constexpr std::uint64_t kMaxImplicitBytes = std::uint64_t{1} << 26;

    GltfFile& file_;
    const std::string name_;
    Ignored& ignored_;
    Object root_;
    bool quantized_ = false;
    std::map<std::string, std::size_t> counts_;
    std::vector<std::uint64_t> bufferSizes_;
    std::vector<bool> bufferHasData_;
    std::vector<View> views_;
    std::vector<AccessorFacts> accessors_;
    std::size_t lightCount_ = 0;
    std::vector<std::int64_t> parents_;
    std::set<std::size_t> matrixNodes_;
    std::vector<std::size_t> morphTargets_;        ///< by mesh
    std::vector<std::size_t> morphTargetsOfNode_;  ///< of its mesh
};

}  // namespace

std::uint64_t elementSize(const std::string& type, int componentType) {
    const auto bytes = static_cast<std::uint64_t>(componentSize(componentType));
    static const std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> kColumnsRows = {
        {"SCALAR", {1, 1}}, {"VEC2", {1, 2}}, {"VEC3", {1, 3}}, {"VEC4", {1, 4}},
        {"MAT2", {2, 2}},   {"MAT3", {3, 3}}, {"MAT4", {4, 4}}};
    const auto it = kColumnsRows.find(type);
    if (it == kColumnsRows.end()) return 0;
    const auto [columns, rows] = it->second;
    const std::uint64_t column = columns == 1 ? rows * bytes : (rows * bytes + 3) / 4 * 4;
    return columns * column;
}

void checkGltf(GltfFile& file, Ignored& ignored) {
    Checker(file, ignored).run();
}

}  // namespace voxcone
