#include "scene/gltf_file.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <fstream>

#include "core/error.h"

namespace voxcone {

namespace {

using nlohmann::json;

// The deepest path glTF itself defines has about ten levels; more than this is an attack on recursive readers.
constexpr int kMaxDepth = 128;
constexpr std::uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;

Bytes readFile(const std::filesystem::path& path, std::uint64_t maxBytes, const std::string& file,
               const std::string& jsonPath) {
    std::ifstream stream(path, std::ios::binary);
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    if (!stream || error) throw InputError(file, jsonPath, "cannot be opened");
    Bytes bytes(static_cast<std::size_t>(std::min(size, maxBytes)));
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (stream.gcount() != static_cast<std::streamsize>(bytes.size()))
        throw InputError(file, jsonPath, "cannot be read whole");
    return bytes;
}

std::uint32_t littleEndian(const Bytes& bytes, std::size_t offset) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{bytes[offset + i]} << (8 * i);
    return value;
}

json parseJson(const std::string& file, const char* begin, const char* end) {
    try {
        json document = json::parse(begin, end, [&](int depth, json::parse_event_t, json&) {
            if (depth > kMaxDepth)
                throw InputError(file, "", fmt::format("JSON is nested deeper than {} levels", kMaxDepth));
            return true;
        });
        if (!document.is_object()) throw InputError(file, "line 1", "the JSON root is not an object");
        return document;
    } catch (const json::parse_error& e) {
        const char* place = begin + std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(e.byte), end - begin);
        const auto line = 1 + std::count(begin, place, '\n');
        // "[json.exception…] parse error at line 1, column 2: syntax error …": the place is said by us.
        std::string reason = e.what();
        if (const auto cut = reason.find(": "); cut != std::string::npos) reason = reason.substr(cut + 2);
        throw InputError(file, fmt::format("line {} (byte {})", line, e.byte), "JSON " + printable(reason));
    } catch (const json::exception& e) {
        // "[json.exception.out_of_range.406] number overflow parsing '1e309'"
        const std::string reason = e.what();
        throw InputError(file, "", "JSON has a " + printable(reason.substr(reason.find("] ") + 2)));
    }
}

GltfFile splitGlb(GltfFile file, const Bytes& bytes) {
    const std::string name = file.path.string();
    auto fail = [&](std::size_t offset, const std::string& reason) {
        throw InputError(name, fmt::format("byte {}", offset), reason);
    };
    if (bytes.size() < 12) fail(0, "GLB header is cut short");
    if (const std::uint32_t version = littleEndian(bytes, 4); version != 2)
        fail(4, fmt::format("GLB version {} is not supported, only 2", version));
    if (const std::uint32_t length = littleEndian(bytes, 8); length != bytes.size())
        fail(8, fmt::format("GLB header says {} bytes, the file has {}", length, bytes.size()));

    std::size_t offset = 12;
    for (int chunk = 0; offset < bytes.size(); ++chunk) {
        if (bytes.size() - offset < 8) fail(offset, "GLB chunk header is cut short");
        const std::size_t length = littleEndian(bytes, offset);
        const std::uint32_t type = littleEndian(bytes, offset + 4);
        const std::size_t data = offset + 8;
        if (length > bytes.size() - data)
            fail(offset, fmt::format("GLB chunk of {} bytes reaches past the end of the file", length));
        if (chunk == 0) {
            if (type != kJsonChunk) fail(offset, "the first GLB chunk is not JSON");
            if (length == 0) fail(offset, "the JSON chunk is empty");
            const char* text = reinterpret_cast<const char*>(bytes.data() + data);
            file.document = parseJson(name, text, text + length);
        } else if (type == kJsonChunk || (type == kBinChunk && file.binary)) {
            fail(offset, "GLB chunk type appears twice");
        } else if (type == kBinChunk) {
            file.binary.emplace(bytes.begin() + static_cast<std::ptrdiff_t>(data),
                                bytes.begin() + static_cast<std::ptrdiff_t>(data + length));
        }
        offset = data + length;
    }
    if (file.document.is_null()) fail(12, "GLB has no JSON chunk");
    return file;
}

bool isDataUri(const std::string& uri) {
    return uri.rfind("data:", 0) == 0;
}

/// The path behind a relative URI, escapes decoded.
std::filesystem::path relativePath(const GltfFile& file, const std::string& uri, const std::string& jsonPath) {
    auto refuse = [&](const char* reason) {
        throw InputError(file.path.string(), jsonPath, fmt::format("'{}' {}", printable(uri), reason));
    };
    std::string decoded;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] != '%') {
            decoded += uri[i];
            continue;
        }
        auto digit = [&](std::size_t at) {
            const char c = at < uri.size() ? uri[at] : '\0';
            if (c >= '0' && c <= '9') return c - '0';
            if (c >= 'a' && c <= 'f') return c - 'a' + 10;
            if (c >= 'A' && c <= 'F') return c - 'A' + 10;
            refuse("has a broken %-escape");
            return 0;
        };
        decoded += static_cast<char>(16 * digit(i + 1) + digit(i + 2));
        i += 2;
    }
    if (decoded.empty()) refuse("is empty");
    if (std::any_of(decoded.begin(), decoded.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
        refuse("has control characters");
    if (decoded.front() == '/' || decoded.front() == '\\') refuse("is an absolute path, only relative ones are read");
    // RFC 3986: a colon before the first slash ends a scheme; drive letters look the same.
    if (decoded.substr(0, decoded.find('/')).find(':') != std::string::npos)
        refuse("has a scheme, only relative paths and data: are read");
    const std::filesystem::path path = file.path.parent_path() / decoded;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) refuse("is no file beside it");
    return path;
}

std::size_t base64Begin(const GltfFile& file, const std::string& uri, const std::string& jsonPath) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string::npos || !std::string_view(uri).substr(0, comma).ends_with(";base64"))
        throw InputError(file.path.string(), jsonPath, "data URI is not base64");
    return comma + 1;
}

}  // namespace

GltfFile readGltfFile(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) throw InputError(path.string(), "", "no such file");
    if (!std::filesystem::is_regular_file(path, error)) throw InputError(path.string(), "", "is not a file");
    const Bytes bytes = readFile(path, UINT64_MAX, path.string(), "");
    GltfFile file;
    file.path = path;
    if (bytes.size() >= 4 && littleEndian(bytes, 0) == kGlbMagic) return splitGlb(std::move(file), bytes);
    if (path.extension() == ".glb") throw InputError(path.string(), "byte 0", "GLB magic is missing");
    const char* text = reinterpret_cast<const char*>(bytes.data());
    file.document = parseJson(path.string(), text, text + bytes.size());
    return file;
}

std::uint64_t uriSize(const GltfFile& file, const std::string& uri, const std::string& jsonPath) {
    if (isDataUri(uri)) {
        const std::size_t begin = base64Begin(file, uri, jsonPath);
        std::size_t digits = uri.size() - begin;
        while (digits > 0 && uri[begin + digits - 1] == '=') --digits;
        return digits / 4 * 3 + (digits % 4 == 0 ? 0 : digits % 4 - 1);
    }
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(relativePath(file, uri, jsonPath), error);
    if (error) throw InputError(file.path.string(), jsonPath, fmt::format("'{}' cannot be opened", printable(uri)));
    return size;
}

Bytes readUri(const GltfFile& file, const std::string& uri, const std::string& jsonPath, std::uint64_t maxBytes) {
    if (!isDataUri(uri)) return readFile(relativePath(file, uri, jsonPath), maxBytes, file.path.string(), jsonPath);
    const std::size_t begin = base64Begin(file, uri, jsonPath);
    // Any media type is taken as bytes: the magic of an image says more than its label.
    Bytes bytes;
    std::string mediaType;
    if (!tinygltf::DecodeDataURI(&bytes, mediaType, "data:application/octet-stream;base64," + uri.substr(begin), 0,
                                 false))
        throw InputError(file.path.string(), jsonPath, "data URI is empty or not base64");
    if (bytes.size() != uriSize(file, uri, jsonPath))
        throw InputError(file.path.string(), jsonPath, "data URI has characters that are not base64");
    if (bytes.size() > maxBytes) bytes.resize(static_cast<std::size_t>(maxBytes));
    return bytes;
}

std::string printable(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
    constexpr std::size_t kLongest = 200;
    if (text.size() > kLongest) text = text.substr(0, kLongest) + "…";
    return text;
}

}  // namespace voxcone
