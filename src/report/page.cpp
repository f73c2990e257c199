#include "report/page.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string_view>
#include <vector>

#include "core/check.h"
#include "core/error.h"
#include "metric/image.h"
#include "report/embedded_page.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kMostWidth = 320;
constexpr double kMostPixels = 12e6;  // of all thumbnails together: about 20 MB of page

/// The mean of the linear values that each pixel of a picture `width` pixels wide covers.
Image shrunk(const Image& image, int width) {
    if (width >= image.width) return image;
    const double step = 1.0 * image.width / width;
    Image out(width, std::max(1, static_cast<int>(std::lround(image.height / step))), image.channels);
    const double stepY = 1.0 * image.height / out.height;
    std::vector<double> sum(static_cast<std::size_t>(image.channels));
    for (int y = 0; y < out.height; ++y) {
        for (int x = 0; x < out.width; ++x) {
            const double left = x * step, right = left + step, top = y * stepY, bottom = top + stepY;
            std::fill(sum.begin(), sum.end(), 0.0);
            double area = 0;
            for (int v = static_cast<int>(top); v < std::min(image.height, static_cast<int>(std::ceil(bottom))); ++v) {
                const double rows = std::min(bottom, v + 1.0) - std::max(top, 1.0 * v);
                for (int u = static_cast<int>(left); u < std::min(image.width, static_cast<int>(std::ceil(right)));
                     ++u) {
                    const double weight = rows * (std::min(right, u + 1.0) - std::max(left, 1.0 * u));
                    area += weight;
                    for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += weight * image.pixel(u, v)[c];
                }
            }
            for (std::size_t c = 0; c < sum.size(); ++c) out.pixel(x, y)[c] = static_cast<float>(sum[c] / area);
        }
    }
    return out;
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

/// Adds what `images` of a view's reference or of a row names to `uris`, without a picture yet.
void addPaths(const json& images, std::map<std::string, std::string>& uris) {
    for (const auto& [channel, path] : images.items()) {
        if (path.is_string()) uris[path.get<std::string>()];
    }
}

/// Fills in the data URIs of pictures that can be read, each at most `width` wide; the pixels of all.
double makeThumbnails(std::map<std::string, std::string>& uris, const fs::path& folder, int width) {
    double pixels = 0;
    for (auto& [path, uri] : uris) {
        Image image;
        try {
            image = readImage(folder / path);
        } catch (const InputError&) {
            continue;
        }
        image = shrunk(image, width);
        pixels += 1.0 * image.width * image.height;
        uri = "data:image/png;base64," + base64(encodePng(image));
    }
    return pixels;
}

json thumbnails(const json& report, const fs::path& folder) {
    std::map<std::string, std::string> uris;
    for (const json& view : report.value("views", json::array()))
        addPaths(view.value("/reference/images"_json_pointer, json::object()), uris);
    for (const json& row : report.value("rows", json::array())) addPaths(row.value("images", json::object()), uris);
    const double pixels = makeThumbnails(uris, folder, kMostWidth);
    if (pixels > kMostPixels)
        makeThumbnails(uris, folder, std::max(48, static_cast<int>(kMostWidth * std::sqrt(kMostPixels / pixels))));
    std::erase_if(uris, [](const auto& picture) { return picture.second.empty(); });
    return uris;
}

/// JSON that may stand in a script element: no text in it can end the element, for it has no "<".
std::string scriptJson(const json& value) {
    std::string out;
    for (const char c : value.dump(-1, ' ', false, json::error_handler_t::replace))
        c == '<' ? out += "\\u003c" : out += c;
    return out;
}

}  // namespace

std::string makePage(const json& report, const fs::path& folder) {
    VOXCONE_CHECK(report.is_object(), "a report is an object, not {}", report.type_name());
    const std::pair<std::string_view, std::string> parts[] = {{"@STYLE@", std::string(embeddedPageCss())},
                                                              {"@REPORT@", scriptJson(report)},
                                                              {"@PICTURES@", scriptJson(thumbnails(report, folder))},
                                                              {"@SCRIPT@", std::string(embeddedPageJs())}};
    // Markers are looked for in the template only, in its order: a name in the report may look like one.
    std::string page;
    std::string_view rest = embeddedPageHtml();
    for (const auto& [marker, content] : parts) {
        const std::size_t at = rest.find(marker);
        VOXCONE_CHECK(at != std::string_view::npos, "{} is not in page.html", marker);
        page.append(rest.substr(0, at)).append(content);
        rest.remove_prefix(at + marker.size());
    }
    return page.append(rest);
}

}  // namespace voxcone
