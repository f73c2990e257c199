// Linear float images and their files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace voxcone {

/// `width`×`height` pixels of `channels` (1, 2, 3 or 4) interleaved 32-bit floats, row 0 on top.
struct Image {
    int width = 0, height = 0, channels = 3;
    std::vector<float> data;

    Image() = default;
    Image(int w, int h, int c)
        : width(w),
          height(h),
          channels(c),
          data(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * static_cast<std::size_t>(c)) {}
    float* pixel(int x, int y) { return data.data() + index(x, y); }
    const float* pixel(int x, int y) const { return data.data() + index(x, y); }

  private:
    std::size_t index(int x, int y) const {
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels);
    }
};

/// Reads EXR, PNG, HDR, … through OpenImageIO. EXR and HDR give their linear values; 8- and 16-bit formats are decoded
/// from sRGB to linear. Throws InputError (file, reason).
Image readImage(const std::filesystem::path& file);

/// 32-bit float EXR (zip), written atomically.
void writeExr(const std::filesystem::path& file, const Image& image);

/// 8-bit PNG, written atomically. `image` is linear display-referred in [0,1] and is encoded to sRGB; values outside
/// are clipped, NaN is written as magenta so that it is seen.
void writePng(const std::filesystem::path& file, const Image& image);

/// The bytes of the file that writePng writes.
std::vector<std::uint8_t> encodePng(const Image& image);

/// sRGB transfer functions (IEC 61966-2-1).
float srgbFromLinear(float linear);
float linearFromSrgb(float encoded);

}  // namespace voxcone
