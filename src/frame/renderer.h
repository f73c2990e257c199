// The frame: the order of passes in one readable function, and the channels it gives.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cascade/update.h"
#include "core/settings.h"
#include "metric/image.h"
#include "metric/temporal.h"
#include "scene/scene.h"

namespace voxcone {

namespace gl {
class Context;
class Texture;
}  // namespace gl
struct PixelCones;        // cone/inspect.h
struct VoxelSlice;        // frame/voxel_slice.h
struct VoxelViewOptions;  // frame/voxel_view.h

/// What one frame cost. Times are of the device (`timer` says how they were taken).
struct FrameStats {
    struct Pass {
        std::string name;
        double milliseconds = 0;
    };
    struct Memory {
        std::string name;
        std::uint64_t bytes = 0;
    };
    std::vector<Pass> passes;  ///< in the order they ran; passes that did not run are absent
    double frameMilliseconds = 0;
    std::string timer;  ///< "query" or "finish"
    std::vector<Memory> memory;
    std::map<std::string, std::uint64_t>
        counts;  ///< triangles, occupied voxels, fragments saturated, values clamped, …
    /// Milliseconds of voxelization by level, of those levels that were voxelized by themselves in this frame.
    std::map<int, double> levelMilliseconds;
};

/// How far the voxels and their light have come (Renderer::render with `pause`).
struct LightProgress {
    bool whole = true;        ///< all is as the scene and the camera ask for
    int levelsLeft = 0;       ///< that are yet to be voxelized
    bool direct = true;       ///< direct light of the voxels is whole; until then cones see that of before
    int bounces = 0, of = 0;  ///< made, and to be made at most
    double share = 0;         ///< of direct light, or of the next bounce, 0 to 1
};

/// The step in indirect diffuse light between the levels `level` and `level` + 1 of the clipmap, over the pixels where
/// they blend. Each such pixel is gathered twice, with either level alone.
struct SeamStep {
    int level = 0;
    std::uint64_t pixels = 0;
    double mean = 0;  ///< signed, coarser minus finer, over the finer one's mean
    double rms = 0;   ///< over the finer one's mean
};

/// Something that is not modelled, and why, for `voxcone info`.
struct LeftOut {
    std::string what, why;
};

/// Where the clipmap is, and what the last frame voxelized of it.
struct ClipmapState {
    ClipmapLayout layout;
    glm::dvec3 origin{0};  ///< world position of voxel index 0
    glm::dvec3 center{0};  ///< world position around which levels blend
    double radius = 0;     ///< half-edge of the cube around the centre in which level 0 may be read, metres
    ClipmapUpdate update;  ///< windows of levels and mips, and the regions that were voxelized
};

/// Renders one scene. Not thread-safe: lives on the thread of its context.
class Renderer {
  public:
    /// Uploads `scene` as it is at `time` seconds and allocates only what scene and settings need. Throws DeviceError
    /// when a limit is too small. `scene` must outlive the renderer; its lights may change between frames, though not
    /// in number or type. `shaderFolder`: as gl::ShaderLibrary; throws gl::ShaderError when one does not compile.
    Renderer(gl::Context& context, const Scene& scene, const Settings& settings, double time = 0,
             const std::filesystem::path& shaderFolder = {});
    Renderer(gl::Context&, Scene&&, const Settings&, double = 0, const std::filesystem::path& = {}) = delete;
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    /// Moves animated nodes to `time`; voxels and shadow maps follow with the next frame.
    void setTime(double time);

    /// To be called when nodes of the scene that nothing animates were put elsewhere: voxels are renewed where objects
    /// were and are, shadow maps as a whole, with the next frame. That equals the frame of a new renderer as long as
    /// Scene::motionBounds() is what it was when this one was made.
    void placeNodes();

    /// Other sizes, supersamples, exposure and tone curve from the next frame on; voxels and their light stay.
    void setOutput(const Settings::Output& output);

    /// Centres the clipmap at `eye` (world space) instead of at the camera, or at the camera again.
    void setClipmapEye(const std::optional<glm::dvec3>& eye);

    /// How voxel views are drawn from now on.
    void setVoxelView(const VoxelViewOptions& options);

    /// Draws one frame into the device's channels. Voxels, shadow maps and bounces are renewed where the camera's or
    /// the scene's motion asks for it. `stop` is asked once the G-buffer is whole, then between passes and within long
    /// ones: true abandons the frame. False when that happened; albedo, normal, depth, position, emission, cascade and
    /// the voxel views are channels of it all the same.
    ///
    /// `pause` is asked between pieces of what is renewed of the voxels and their light, of which at least one is done:
    /// true leaves the rest to the next call, and the frame shows the light there is so far (light()). Shadow maps are
    /// always whole. Once light is whole, the frame is the same as without pauses, bit for bit. With an update budget
    /// that holds if nothing has changed meanwhile; a change begins the frame's bounce anew.
    bool render(const Camera& worldCamera, const std::function<bool()>& stop = {},
                const std::function<bool()>& pause = {});

    /// How far the last render() has brought voxels and light; may be called from `pause`. With an update budget light
    /// is whole when it has settled.
    LightProgress light() const;

    /// The same, and how the indirect diffuse light of what this frame shows has changed since the last frame: the same
    /// surface points are gathered with the voxels of both. Without a frame before, nothing has.
    TemporalChange renderAndCompare(const Camera& worldCamera);

    /// Draws the G-buffer alone, without voxels and light: its channels (albedo, normal, depth, position, emission) are
    /// those that render() gives.
    void drawSurfaces(const Camera& worldCamera);

    /// Reads a channel of the last frame back, linear float at output resolution; names as in capture/script.h.
    /// `cascade` is the colour of each surface's level, `seam` the step between two levels (frame/cascade_view.h).
    /// `beauty` is linear radiance scaled by the exposure, before the tone curve.
    Image channel(const std::string& name);

    /// Beauty through the tone curve, linear display-referred in [0,1].
    Image display();
    /// The same on the device: RGBA32F, row 0 at the bottom, ready to be fetched.
    gl::Texture displayTexture();

    /// The cones of a pixel of the last frame, at the G-buffer's resolution (output times supersample), from the upper
    /// left, by lobe: diffuse ones first, others where the surface has them. No surface, nothing.
    std::vector<PixelCones> inspect(int x, int y);

    /// A slice of the voxels of the last frame, also if it was abandoned (VoxelSlicer); empty for a scene without
    /// triangles. `bounce`: as VoxelChannel has it.
    VoxelSlice voxelSlice(int level, int axis, int depth, int bounce = -1);

    /// The steps between levels in the last frame, which are gathered anew.
    std::vector<SeamStep> seam();

    /// Places that the cones of the last frame looked at for its pixels: voxels of their near fields and steps beyond
    /// them, of all cones but those of soft shadows and bounces. Gathered anew by programs that count, which are
    /// compiled at the first call.
    std::uint64_t coneSamples();

    /// The levels of the clipmap, for `voxcone info`.
    struct Level {
        int level = 0;
        bool mip = false, moves = false;
        int resolution = 0;
        double voxelSize = 0, size = 0;  ///< metres
        std::uint64_t volumeBytes = 0;
        std::string leftOut;  ///< why it is not allocated; empty when it is
    };
    std::vector<Level> levels() const;

    /// Of the last frame, also if it was abandoned; a layout without levels for a scene without triangles.
    ClipmapState clipmap() const;

    /// Forgets the voxels, so that the next frame builds them again: for timing and for determinism tests.
    void invalidate();

    /// Draws batches and triangles in reverse from now on: for tests that the order does not matter.
    void reverseDrawOrder();

    const FrameStats& stats() const;
    std::vector<LeftOut> leftOut() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace voxcone
