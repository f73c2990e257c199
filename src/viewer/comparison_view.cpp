#include "viewer/comparison_view.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "capture/output.h"
#include "metric/heatmap.h"

namespace voxcone {
namespace {

ImVec2 vec(const glm::dvec2& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y)};
}

ImU32 packed(const float* linear) {
    ImU32 color = 0xff000000;
    for (int c = 0; c < 3; ++c) {
        const double encoded = 255 * static_cast<double>(srgbFromLinear(std::clamp(linear[c], 0.0f, 1.0f)));
        color |= static_cast<ImU32>(std::lround(encoded)) << (8 * c);
    }
    return color;
}

Image colorsOf(const Image& values, double scale, bool isSigned) {
    return isSigned ? signedHeatmap(values, scale) : heatmap(values, scale);
}

}  // namespace

std::shared_ptr<const gl::Texture> windowTexture(const Image& image) {
    std::vector<ImU32> texels;
    texels.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    for (int y = image.height - 1; y >= 0; --y) {
        for (int x = 0; x < image.width; ++x) {
            const float* p = image.pixel(x, y);
            const float grey[3] = {p[0], p[0], p[0]};
            texels.push_back(packed(image.channels >= 3 ? p : grey));
        }
    }
    auto texture = std::make_shared<gl::Texture>(gl::Texture::create2D(GL_RGBA8, image.width, image.height));
    texture->upload(0, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
    return texture;
}

const gl::Texture& ComparisonView::colors(int place, const Layer& layer) {
    Drawn& drawn = drawn_[place];
    const bool same = drawn.texture && drawn.layer.values == layer.values && drawn.layer.scale == layer.scale &&
                      drawn.layer.isSigned == layer.isSigned;
    if (!same) drawn = {layer, windowTexture(colorsOf(*layer.values, layer.scale, layer.isSigned))};
    return *drawn.texture;
}

void ComparisonView::draw(Session& session, const PictureRect& rect, const glm::dvec2& cursor, float uiScale) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto image = [&](const gl::Texture& texture, double from, double to, double opacity) {
        const auto id = reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(texture.id()));
        list.AddImage(id, vec(rect.low + glm::dvec2(from * rect.size.x, 0)),
                      vec(rect.low + glm::dvec2(to * rect.size.x, rect.size.y)), ImVec2(static_cast<float>(from), 1),
                      ImVec2(static_cast<float>(to), 0),
                      IM_COL32(255, 255, 255, static_cast<int>(std::lround(255 * opacity))));
    };
    const bool over = rect.contains(cursor);
    const glm::dvec2 place = (cursor - rect.low) / glm::max(rect.size, glm::dvec2(1));
    const auto valueOf = [&](const Image& values) -> std::optional<float> {
        if (!over) return std::nullopt;
        const glm::ivec2 pixel(place * glm::dvec2(values.width, values.height));
        return *values.pixel(std::min(pixel.x, values.width - 1), std::min(pixel.y, values.height - 1));
    };

    if (const auto flicker = session.flicker.shown()) {
        const Layer layer{flicker, 1 / session.flicker.exaggeration, true};
        image(colors(0, layer), 0, 1, 1);
        const char* what = session.flicker.watched == Watched::seam       ? "seam"
                           : session.flicker.watched == Watched::indirect ? "change of indirect light"
                                                                          : "change of beauty";
        return drawLegend(layer, fmt::format("{}{}", what, session.flicker.hold ? ", held" : ""), valueOf(*flicker),
                          rect, uiScale);
    }

    const Picture& picture = *session.picture;
    const Picture* second = session.other ? session.other->picture().get() : nullptr;
    if (!session.held && !second) return image(*picture.texture, 0, 1, 1);
    // Where whole pixels of both end.
    const double split = std::round(session.split * rect.size.x) / rect.size.x;
    // B is the right one, the present picture beside it or beside a held one.
    if (second) {
        image(*picture.texture, 0, split, 1);
        image(*second->texture, split, 1, 1);
    } else {
        if (!session.held->texture)
            session.held->texture = windowTexture(
                session.held->image->channels == 3 ? displayOf(*session.held->image, session.settingsA().output.toneMap)
                                                   : *session.held->image);
        image(*session.held->texture, 0, split, 1);
        image(*picture.texture, split, 1, 1);
    }

    // Each picture's errors over it: to the held one, or of B to A.
    std::optional<Layer> legend;
    std::optional<float> value;
    const auto map = [&](int side, const Measurement& measurement, const std::shared_ptr<const Image>& of) {
        const Errors* errors = measurement.errorsOf(of);
        if (!errors || !errors->map) return;
        const Layer layer{errors->map, session.errorScale, errors->kind == ErrorMap::relative};
        image(colors(side, layer), side == 0 ? 0 : split, side == 0 ? split : 1, session.errorOpacity);
        legend = layer;
        if ((place.x >= split) == (side == 1)) value = valueOf(*errors->map);
    };
    if (second) {
        if (session.held) map(0, session.presentToHeld, session.presentImage(session.picture));
        map(1, session.held ? session.otherToHeld : session.otherToPresent,
            session.otherImage(session.other->picture()));
    } else {
        map(1, session.presentToHeld, session.presentImage(session.picture));
    }
    const auto x = static_cast<float>(rect.low.x + split * rect.size.x);
    list.AddLine(ImVec2(x, vec(rect.low).y), ImVec2(x, vec(rect.low + rect.size).y), 0xffffffff, uiScale);
    if (second) {
        list.AddText(ImVec2(x - 14 * uiScale, vec(rect.low).y + 4 * uiScale), 0xffffffff, "A");
        list.AddText(ImVec2(x + 7 * uiScale, vec(rect.low).y + 4 * uiScale), 0xffffffff, "B");
    }
    if (legend) drawLegend(*legend, kErrorMapNames[static_cast<std::size_t>(session.errorMap)], value, rect, uiScale);
}

void ComparisonView::drawLegend(const Layer& layer, const std::string& title, const std::optional<float>& value,
                                const PictureRect& rect, float uiScale) {
    constexpr int kSteps = 48;
    Image ramp(kSteps, 1, 1);
    for (int i = 0; i < kSteps; ++i) {
        const double at = (i + 0.5) / kSteps;
        ramp.data[static_cast<std::size_t>(i)] = static_cast<float>(layer.scale * (layer.isSigned ? 2 * at - 1 : at));
    }
    const Image colors = colorsOf(ramp, layer.scale, layer.isSigned);
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    std::string head = title;
    if (value) head += std::isnan(*value) ? ": not seen before" : fmt::format(": {:.4g}", *value);
    const float line = ImGui::GetTextLineHeight(), margin = 6 * uiScale;
    const float width = std::max(160 * uiScale, ImGui::CalcTextSize((title + ": -0.000123456").c_str()).x);
    const ImVec2 corner(vec(rect.low).x + margin, vec(rect.low + rect.size).y - 3 * line - 2 * margin);
    list.AddRectFilled(corner, ImVec2(corner.x + width + 2 * margin, corner.y + 3 * line + margin), 0xc0000000);
    const ImVec2 low(corner.x + margin, corner.y + 0.5f * margin);
    list.AddText(low, 0xffffffff, head.c_str());
    for (int i = 0; i < kSteps; ++i) {
        const float from = low.x + width * static_cast<float>(i) / kSteps,
                    to = low.x + width * static_cast<float>(i + 1) / kSteps;
        list.AddRectFilled(ImVec2(from, low.y + line + 2), ImVec2(to, low.y + 2 * line - 2),
                           packed(colors.pixel(i, 0)));
    }
    const std::string end = fmt::format("{:.3g}", layer.scale), start = layer.isSigned ? "-" + end : "0";
    list.AddText(ImVec2(low.x, low.y + 2 * line), 0xffffffff, start.c_str());
    list.AddText(ImVec2(low.x + width - ImGui::CalcTextSize(end.c_str()).x, low.y + 2 * line), 0xffffffff, end.c_str());
    if (layer.isSigned) list.AddText(ImVec2(low.x + 0.5f * width - 3 * uiScale, low.y + 2 * line), 0xffffffff, "0");
}

}  // namespace voxcone
