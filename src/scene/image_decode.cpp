#include "scene/image_decode.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "core/error.h"
#include "scene/gltf_file.h"

namespace voxcone {

namespace {

constexpr int kMaxSide = 16384;
constexpr std::int64_t kMaxTexels = std::int64_t{1} << 26;

/// A file name whose extension picks OpenImageIO's reader; empty when the bytes are neither PNG nor JPEG.
const char* readerName(const std::vector<std::uint8_t>& bytes) {
    const std::string_view head(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 8));
    if (head.starts_with("\x89PNG\r\n\x1a\n")) return "image.png";
    if (head.starts_with("\xff\xd8\xff")) return "image.jpg";
    return "";
}

std::uint32_t bigEndian(const std::uint8_t* p) {
    return std::uint32_t{p[0]} << 24 | std::uint32_t{p[1]} << 16 | std::uint32_t{p[2]} << 8 | p[3];
}

/// CRC-32 of ISO 3309, as PNG's annex D gives it.
std::uint32_t crc32(const std::uint8_t* bytes, std::size_t count) {
    static const std::array<std::uint32_t, 256> kTable = [] {
        std::array<std::uint32_t, 256> table{};
        for (std::uint32_t n = 0; n < 256; ++n) {
            table[n] = n;
            for (int bit = 0; bit < 8; ++bit) table[n] = table[n] & 1 ? 0xEDB88320u ^ table[n] >> 1 : table[n] >> 1;
        }
        return table;
    }();
    std::uint32_t crc = ~0u;
    for (std::size_t i = 0; i < count; ++i) crc = kTable[(crc ^ bytes[i]) & 255] ^ crc >> 8;
    return ~crc;
}

/// Refuses PNGs with cut or corrupt critical chunks. libpng would too, but it prints lines of its own while it does.
void checkPng(const std::vector<std::uint8_t>& bytes, const std::string& file, const std::string& jsonPath) {
    constexpr std::size_t kFrame = 12;  // length, type and checksum around a chunk's data
    for (std::size_t offset = 8;;) {
        if (bytes.size() - offset < kFrame) throw InputError(file, jsonPath, "image is damaged: PNG is cut short");
        const std::uint8_t* chunk = bytes.data() + offset;
        const std::size_t length = bigEndian(chunk);
        if (length > bytes.size() - offset - kFrame)
            throw InputError(file, jsonPath,
                             fmt::format("image is damaged: PNG is cut short in the chunk at byte {}", offset));
        const std::string_view type(reinterpret_cast<const char*>(chunk + 4), 4);
        const bool critical = (chunk[4] & 0x20) == 0;
        if (critical && crc32(chunk + 4, length + 4) != bigEndian(chunk + 8 + length))
            throw InputError(file, jsonPath,
                             fmt::format("image is damaged: wrong checksum of the PNG chunk at byte {}", offset));
        if (type == "IEND") return;
        offset += length + kFrame;
    }
}

}  // namespace

DecodedImage decodeImage(const std::vector<std::uint8_t>& bytes, const std::string& file, const std::string& jsonPath) {
    const std::string name = readerName(bytes);
    if (name.empty()) throw InputError(file, jsonPath, "is neither PNG nor JPEG");
    if (name == "image.png") checkPng(bytes, file, jsonPath);

    OIIO::Filesystem::IOMemReader memory(bytes.data(), bytes.size());
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    // OpenImageIO 2.4 forgets the proxy handed to open() when there is a configuration, unless it is named there too.
    OIIO::Filesystem::IOProxy* proxy = &memory;
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(name, &config, proxy);
    if (!input) throw InputError(file, jsonPath, "image is damaged: " + printable(OIIO::geterror()));
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.width < 1 || spec.height < 1 || spec.width > kMaxSide || spec.height > kMaxSide ||
        std::int64_t{spec.width} * spec.height > kMaxTexels)
        throw InputError(file, jsonPath,
                         fmt::format("image is {}x{}; at most {} a side and {} texels are read", spec.width,
                                     spec.height, kMaxSide, kMaxTexels));
    const int channels = spec.nchannels;
    if (channels < 1 || channels > 4) throw InputError(file, jsonPath, fmt::format("image has {} channels", channels));

    DecodedImage image;
    image.width = spec.width;
    image.height = spec.height;
    const std::size_t texels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
    image.rgba8.resize(4 * texels);
    // Straight into the four-component texels; what the file lacks is filled in below.
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeUInt8, image.rgba8.data(), 4))
        throw InputError(file, jsonPath, "image is damaged: " + printable(input->geterror()));
    for (std::size_t i = 0; i < texels && channels < 4; ++i) {
        std::uint8_t* p = image.rgba8.data() + 4 * i;
        const std::uint8_t alpha = channels == 2 ? p[1] : 255;
        if (channels < 3) p[1] = p[2] = p[0];
        p[3] = alpha;
    }
    return image;
}

}  // namespace voxcone
