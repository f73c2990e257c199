// Small glTF files made in a test: JSON with one data-URI buffer, written to a temporary folder.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/atomic_file.h"

namespace voxcone::test {

inline std::string base64(const std::vector<std::uint8_t>& bytes) {
    static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : digits[group >> (18 - 6 * k) & 63];
    }
    return text;
}

/// A folder of this test process, removed at its end.
class TemporaryFolder {
  public:
    explicit TemporaryFolder(const std::string& name)
        : path_(std::filesystem::temp_directory_path() / (name + std::to_string(getpid()))) {
        std::filesystem::create_directories(path_);
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path_); }
    TemporaryFolder(const TemporaryFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

enum Component { kByte = 5120, kUByte = 5121, kShort = 5122, kUShort = 5123, kUInt = 5125, kFloat = 5126 };

class GltfBuilder {
  public:
    nlohmann::json json = {{"asset", {{"version", "2.0"}}}};
    std::vector<std::uint8_t> data;

    /// Appends `values` as a buffer view of its own, four-byte aligned; its index.
    template <class T>
    int view(const std::vector<T>& values) {
        data.resize((data.size() + 3) / 4 * 4);
        const std::size_t offset = data.size(), bytes = values.size() * sizeof(T);
        data.resize(offset + bytes);
        std::memcpy(data.data() + offset, values.data(), bytes);
        return append("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}});
    }
    /// Accessor over a new view of `values`; `extra` is merged in.
    template <class T>
    int accessor(const std::vector<T>& values, const char* type, Component component, std::size_t count,
                 const nlohmann::json& extra = nlohmann::json::object()) {
        nlohmann::json a = {
            {"bufferView", view(values)}, {"componentType", component}, {"count", count}, {"type", type}};
        a.update(extra);
        return append("accessors", a);
    }
    int append(const char* array, const nlohmann::json& value) {
        json[array].push_back(value);
        return static_cast<int>(json[array].size()) - 1;
    }
    /// A mesh of one primitive and a root node that shows it; index of the node.
    int show(const nlohmann::json& primitive, nlohmann::json node = nlohmann::json::object()) {
        node["mesh"] = append("meshes", {{"primitives", nlohmann::json::array({primitive})}});
        return append("nodes", node);
    }
    int positions(const std::vector<float>& xyz) { return accessor(xyz, "VEC3", kFloat, xyz.size() / 3); }
    int indices(const std::vector<std::uint16_t>& list) { return accessor(list, "SCALAR", kUShort, list.size()); }
    /// A 1×1 PNG of colour (255, 0, 0) as image and texture; index of the texture.
    int redTexture() {
        const char* png =
            "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/"
            "pLvAAAAAElFTkSuQmCC";
        return append("textures", {{"source", append("images", {{"uri", png}})}});
    }

    std::string text() const {
        nlohmann::json document = json;
        if (!data.empty() && !document.contains("buffers"))
            document["buffers"] = nlohmann::json::array(
                {{{"byteLength", data.size()}, {"uri", "data:application/octet-stream;base64," + base64(data)}}});
        return document.dump();
    }
    std::filesystem::path write(const TemporaryFolder& folder, const std::string& name = "test.gltf") const {
        const std::filesystem::path path = folder.path() / name;
        writeTextFile(path, text());
        return path;
    }
};

}  // namespace voxcone::test
