#include "scene/environment.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace voxcone {

namespace {

constexpr int kMaxSide = 1 << 15;
constexpr std::int64_t kMaxTexels = std::int64_t{1} << 27;

std::string oneLine(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
    return text.substr(0, text.find_last_not_of(' ') + 1);
}

glm::vec3 bilinear(const Environment& environment, const std::vector<glm::vec3>& texels, const glm::vec3& d) {
    const glm::vec2 uv = environmentUv(environment, d);
    const float x = uv.x * static_cast<float>(environment.width) - 0.5f;
    const float y = uv.y * static_cast<float>(environment.height) - 0.5f;
    const float fx = x - std::floor(x), fy = y - std::floor(y);
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    auto texel = [&](int column, int row) {
        const int wrapped = (column + environment.width) % environment.width;
        const int clamped = std::clamp(row, 0, environment.height - 1);
        return texels[static_cast<std::size_t>(clamped) * static_cast<std::size_t>(environment.width) +
                      static_cast<std::size_t>(wrapped)];
    };
    const glm::vec3 top = glm::mix(texel(x0, y0), texel(x0 + 1, y0), fx);
    const glm::vec3 bottom = glm::mix(texel(x0, y0 + 1), texel(x0 + 1, y0 + 1), fx);
    return environment.color * glm::mix(top, bottom, fy);
}

}  // namespace

Environment loadEnvironment(const std::filesystem::path& file) {
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(file.string());
    if (!input) throw InputError(file.string(), "", "cannot be read as an image: " + oneLine(OIIO::geterror()));
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.width > kMaxSide || spec.height > kMaxSide ||
        std::int64_t{spec.width} * spec.height > kMaxTexels || spec.deep)
        throw InputError(
            file.string(), "",
            fmt::format("is {}x{}; an environment has up to {} texels", spec.width, spec.height, kMaxTexels));
    if (spec.nchannels != 1 && spec.nchannels < 3)
        throw InputError(file.string(), "", fmt::format("has {} channels; needs 1, 3 or more", spec.nchannels));

    Environment environment;
    environment.color = glm::vec3(1);
    environment.width = spec.width;
    environment.height = spec.height;
    const int channels = std::min(spec.nchannels, 3);
    const std::size_t texels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
    std::vector<float> values(texels * static_cast<std::size_t>(channels));
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeFloat, values.data()))
        throw InputError(file.string(), "", "cannot be decoded: " + oneLine(input->geterror()));

    environment.radiance.resize(texels);
    std::size_t bad = 0;
    for (std::size_t i = 0; i < texels; ++i) {
        const float* v = values.data() + i * static_cast<std::size_t>(channels);
        environment.radiance[i] = channels == 1 ? glm::vec3(v[0]) : glm::vec3(v[0], v[1], v[2]);
        for (int c = 0; c < channels; ++c)
            if (!std::isfinite(v[c]) || v[c] < 0) {
                ++bad;
                break;
            }
    }
    if (bad > 0)
        throw InputError(file.string(), "", fmt::format("{} of {} texels are NaN, infinite or negative", bad, texels));
    return environment;
}

glm::vec2 environmentUv(const Environment& environment, const glm::vec3& d) {
    const float rotation = static_cast<float>(environment.rotationDeg * std::numbers::pi / 180);
    // The panorama turned counter-clockwise seen from above by `rotation` shows at longitude φ what it had at φ +
    // rotation.
    const float longitude = std::atan2(d.x, -d.z) + rotation;
    const float u = 0.5f + longitude / (2 * std::numbers::pi_v<float>);
    const float v = std::acos(std::clamp(d.y, -1.0f, 1.0f)) / std::numbers::pi_v<float>;
    const float wrapped = u - std::floor(u);
    // floor of a tiny negative number leaves exactly 1, which is column 0 again.
    return {wrapped < 1 ? wrapped : 0.0f, std::min(v, 0x1.fffffep-1f)};
}

glm::vec3 environmentRadiance(const Environment& environment, const glm::vec3& d) {
    return environment.radiance.empty() ? environment.color : bilinear(environment, environment.radiance, d);
}

glm::vec3 environmentResidual(const Environment& environment, const glm::vec3& d) {
    return environment.residual.empty() ? environmentRadiance(environment, d)
                                        : bilinear(environment, environment.residual, d);
}

}  // namespace voxcone
