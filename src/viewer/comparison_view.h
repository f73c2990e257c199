// The picture in the window: beside a held one or that of other settings, below maps of the error or of flicker.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "viewer/overlay.h"
#include "viewer/session.h"

namespace voxcone {

/// Textures and legend of what the session compares; used on the window's thread.
class ComparisonView {
  public:
    /// Draws into Dear ImGui's background. `cursor`: screen coordinates.
    void draw(Session& session, const PictureRect& rect, const glm::dvec2& cursor, float uiScale);

  private:
    /// A one-channel map, and how it becomes colours.
    struct Layer {
        std::shared_ptr<const Image> values;
        double scale = 1;
        bool isSigned = false;
    };
    const gl::Texture& colors(int place, const Layer& layer);
    void drawLegend(const Layer& layer, const std::string& title, const std::optional<float>& value,
                    const PictureRect& rect, float uiScale);

    /// By place of the picture: 0 left of the split, 1 right of it.
    struct Drawn {
        Layer layer;
        std::shared_ptr<const gl::Texture> texture;
    };
    std::map<int, Drawn> drawn_;
};

/// Linear display-referred values, of one channel or three, as the window shows them. On the window's thread.
std::shared_ptr<const gl::Texture> windowTexture(const Image& image);

}  // namespace voxcone
