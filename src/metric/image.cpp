#include "metric/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>

#include "core/atomic_file.h"
#include "core/check.h"
#include "core/error.h"

namespace voxcone {

namespace {

// Pictures are small and the program has its own threads: OpenImageIO's pool would only cost time at the start.
void setUpOpenImageIO() {
    static std::once_flag once;
    std::call_once(once, [] {
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1);
    });
}

// OpenImageIO joins several messages by line ends; ours are one line.
std::string firstLine(const std::string& text, const char* otherwise) {
    const std::string line = text.substr(0, text.find('\n'));
    return line.empty() ? otherwise : line;
}

OIIO::ImageSpec specOf(const Image& image, OIIO::TypeDesc type) {
    OIIO::ImageSpec spec(image.width, image.height, image.channels, type);
    constexpr const char* kNames[4][4] = {{"Y"}, {"R", "G"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
    spec.channelnames.assign(kNames[image.channels - 1], kNames[image.channels - 1] + image.channels);
    spec.alpha_channel = image.channels == 4 ? 3 : -1;
    return spec;
}

void write(const std::filesystem::path& file, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* texels) {
    setUpOpenImageIO();
    AtomicFile atomic(file);
    const auto out = OIIO::ImageOutput::create(atomic.temporaryPath().string());
    if (!out) throw InputError(file.string(), "", firstLine(OIIO::geterror(), "unknown picture format"));
    if (!out->open(atomic.temporaryPath().string(), spec) || !out->write_image(type, texels) || !out->close())
        throw InputError(file.string(), "", "cannot write: " + firstLine(out->geterror(), "unknown reason"));
    atomic.commit();
}

// sRGB-encoded; alpha as it is; pixels with a NaN magenta where there are colours.
std::vector<std::uint8_t> srgbBytes(const Image& image) {
    std::vector<std::uint8_t> bytes(image.data.size());
    const auto channels = static_cast<std::size_t>(image.channels);
    for (std::size_t i = 0; i < bytes.size(); i += channels) {
        bool bad = false;
        for (std::size_t c = 0; c < channels; ++c) {
            const float value = image.data[i + c];
            bad = bad || std::isnan(value);
            const bool alpha = (channels == 2 && c == 1) || c == 3;
            const float shown = alpha ? std::clamp(value, 0.0f, 1.0f) : srgbFromLinear(std::clamp(value, 0.0f, 1.0f));
            bytes[i + c] = std::isnan(value) ? std::uint8_t{255} : static_cast<std::uint8_t>(std::lround(255 * shown));
        }
        if (bad && channels >= 3) bytes[i] = 255, bytes[i + 1] = 0, bytes[i + 2] = 255;
    }
    return bytes;
}

}  // namespace

Image readImage(const std::filesystem::path& file) {
    setUpOpenImageIO();
    if (std::filesystem::is_directory(file)) throw InputError(file.string(), "", "is a folder, not a picture");
    if (!std::filesystem::exists(file)) throw InputError(file.string(), "", "no such file");
    // As stored: multiplying colour by alpha is a matter of the user, not of the file.
    OIIO::ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1;
    const auto in = OIIO::ImageInput::open(file.string(), &config);
    if (!in)
        throw InputError(file.string(), "", "cannot read: " + firstLine(OIIO::geterror(), "unknown picture format"));
    const OIIO::ImageSpec& spec = in->spec();
    if (spec.nchannels < 1 || spec.nchannels > 4)
        throw InputError(file.string(), "", fmt::format("has {} channels, 1 to 4 are supported", spec.nchannels));
    if (spec.deep || spec.depth > 1) throw InputError(file.string(), "", "deep and volume pictures are not supported");
    constexpr std::int64_t kMostPixels = std::int64_t{1} << 28;
    if (spec.width < 1 || spec.height < 1 || std::int64_t{spec.width} * spec.height > kMostPixels)
        throw InputError(file.string(), "", fmt::format("size {}x{} is not supported", spec.width, spec.height));

    Image image(spec.width, spec.height, spec.nchannels);
    if (!in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.data.data()))
        throw InputError(file.string(), "", "cannot read: " + firstLine(in->geterror(), "truncated"));
    const bool encoded = spec.format == OIIO::TypeDesc::UINT8 || spec.format == OIIO::TypeDesc::UINT16;
    if (encoded) {
        const int channels = image.channels, alpha = channels == 2 ? 1 : channels == 4 ? 3 : -1;
        for (std::size_t i = 0; i < image.data.size(); ++i) {
            if (static_cast<int>(i % static_cast<std::size_t>(channels)) != alpha)
                image.data[i] = linearFromSrgb(image.data[i]);
        }
    }
    return image;
}

void writeExr(const std::filesystem::path& file, const Image& image) {
    OIIO::ImageSpec spec = specOf(image, OIIO::TypeDesc::FLOAT);
    spec["compression"] = "zip";
    write(file, spec, OIIO::TypeDesc::FLOAT, image.data.data());
}

void writePng(const std::filesystem::path& file, const Image& image) {
    write(file, specOf(image, OIIO::TypeDesc::UINT8), OIIO::TypeDesc::UINT8, srgbBytes(image).data());
}

std::vector<std::uint8_t> encodePng(const Image& image) {
    setUpOpenImageIO();
    std::vector<std::uint8_t> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    const auto out = OIIO::ImageOutput::create("png");
    VOXCONE_CHECK(out != nullptr, "{}", OIIO::geterror());
    VOXCONE_CHECK(out->set_ioproxy(&memory), "{}", out->geterror());
    const bool written = out->open("memory.png", specOf(image, OIIO::TypeDesc::UINT8)) &&
                         out->write_image(OIIO::TypeDesc::UINT8, srgbBytes(image).data()) && out->close();
    VOXCONE_CHECK(written, "{}", out->geterror());
    return bytes;
}

float srgbFromLinear(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float linearFromSrgb(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

}  // namespace voxcone
