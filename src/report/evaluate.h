// One configuration on one view: what its frames cost and how far its picture is from the truth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/script.h"
#include "frame/renderer.h"
#include "metric/image.h"

namespace voxcone {

/// Path-traced pictures of one view, linear, as `voxcone reference` writes them but for the exposure of beauty.
struct Reference {
    std::string key;  ///< 64 hexadecimal digits, of all that the pictures depend on
    /// beauty, direct, indirect_diffuse, indirect_specular, transmission, ao; those that are black everywhere are
    /// absent.
    std::map<std::string, Image> channels;
    /// Of beauty and indirect_diffuse: RMS over pixels of the standard error, relative to the mean value.
    std::map<std::string, double> standardErrors;
    std::map<std::string, double> noise;  ///< ReferenceImages::noise, of `channels` but ao
    int samples = 0;                      ///< per pixel
    int maxDepth = 0;
    double seconds = 0;  ///< of the run that rendered it
};

/// Order statistics of repeats, interpolated linearly between ranks.
struct Times {
    double median = 0, p10 = 0, p90 = 0;  ///< milliseconds
    std::vector<double> repeats;          ///< in the order measured
};
Times timesOf(std::vector<double> repeats);

/// One frame's time and those of its passes.
struct FrameTimes {
    double milliseconds = 0;
    std::vector<FrameStats::Pass> passes;
};

/// A frame that builds everything, voxels, light and picture, and one in which nothing has moved since.
struct Repeat {
    FrameTimes first, steady;
};

/// Errors and pictures of one channel.
struct ChannelResult {
    std::map<std::string, double> errors;  ///< by the names of `voxcone compare`; psnr may be infinite
    Image shown;                           ///< as `voxcone capture` writes it to a PNG
    Image heatmap;                         ///< HDR-ꟻLIP of every pixel in the colours of magma
};

/// What does not change from one repeat to the next.
struct PictureResult {
    std::uint64_t memoryBytes = 0;  ///< of all that the renderer keeps on the device
    std::uint64_t voxels = 0;       ///< occupied
    double samplesPerPixel = 0;     ///< Renderer::coneSamples over the pixels of the picture
    std::map<std::string, ChannelResult> channels;
};

struct Measurement {
    Times first, steady;  ///< of whole frames
    struct Pass {
        std::string name;
        std::optional<Times> first, steady;  ///< absent where the pass does not run
    };
    std::vector<Pass> passes;  ///< in the order they run
    PictureResult picture;
};

/// Statistics over repeats, at least one.
Measurement summarize(const std::vector<Repeat>& repeats);

/// A renderer with the settings to be measured, on one frame of a shot. Lives on the thread of its context.
class Trial {
  public:
    /// Builds it and renders `warmUp` frames (at least 1), so that shaders are compiled and buffers have grown. `scene`
    /// is that of Evaluator::sceneFor. Throws DeviceError for limits, GlError in debug contexts.
    Trial(gl::Context& context, std::shared_ptr<const Scene> scene, const Shot& shot, int frame,
          const Settings& settings, int warmUp = 1);

    /// Renders a frame with everything built anew, then one more. A budget for updates of levels is waited for in
    /// between, so that the steady frame shows the same.
    Repeat repeat();

    /// Renders one more frame like the last, in which nothing has moved.
    FrameTimes again();

    /// The last warm-up; if it was the only one, with the compilation of shaders.
    const Repeat& warmedUp() const { return warmedUp_; }

    std::uint64_t memoryBytes() const;

    /// Errors of the last frame in every channel of `channels` that `reference` has. `multiplyAo`: indirect diffuse
    /// light is multiplied by the openness that its own cones saw, in its channel and in beauty (the thesis' voxel
    /// ambient occlusion). Throws InputError for NaN and infinity in a picture.
    PictureResult picture(const Reference& reference, const std::vector<std::string>& channels,
                          bool multiplyAo = false);

  private:
    gl::Context& context_;
    std::shared_ptr<const Scene> scene_;
    Settings settings_;
    Camera camera_;
    std::unique_ptr<Renderer> renderer_;
    Repeat warmedUp_;
};

/// What a PNG of a reference's channel shows: as `voxcone reference` writes it.
Image shownReference(const std::string& channel, const Image& linear, const Settings& settings);

/// Channels that are compared unless something else is asked for: beauty, and what is not direct light.
const std::vector<std::string>& comparedChannels();

/// Measures settings on the shots of a script, and keeps their references in a cache on disk.
class Evaluator {
  public:
    /// `script` comes from loadCaptureScript, without lights extracted from it (ScriptOptions::load extracts; each
    /// configuration does so here as its own settings say). It must outlive this object. References lie in
    /// cache/<key>/, made by `reference`, which goes before the same settings of every configuration.
    Evaluator(gl::Context& context, const CaptureScript& script, std::filesystem::path cache,
              const Settings::Reference& reference);

    /// The script's scene with the lights that `settings` extract. Scenes of the same lights are shared.
    std::shared_ptr<const Scene> sceneFor(const Settings& settings);

    /// From the cache, or path traced and put there. It depends on the scene's files, what of it stands where at the
    /// time of the frame, its lights, the camera, and on the settings `reference`, `output.width`, `.height`,
    /// `.supersample` and `ao`. `progress` gets 0…1. Throws InputError for files that cannot be written.
    Reference reference(const Shot& shot, int frame, const Settings& settings,
                        const std::function<void(double)>& progress = {});

    /// Key of that reference, which is not rendered.
    std::string referenceKey(const Shot& shot, int frame, const Settings& settings);

    /// Measures one configuration alone: builds it, warms it up, `repeats` (at least 1) first and steady frames, and
    /// the errors of comparedChannels(). Of several configurations whose times shall be compared, interleave Trials.
    Measurement measure(const Shot& shot, int frame, const Settings& settings, int repeats, int warmUp = 1);
    Measurement measure(const Shot& shot, const Settings& settings, int repeats) {
        return measure(shot, shot.firstFrame, settings, repeats);
    }

    /// References that were path traced by this object, not found.
    int referencesRendered() const { return referencesRendered_; }

  private:
    gl::Context& context_;
    const CaptureScript& script_;
    std::filesystem::path cache_;
    Settings::Reference referenceSettings_;
    std::string filesHash_;                                               ///< of the glTF and the files that it names
    std::map<std::pair<int, int>, std::shared_ptr<const Scene>> scenes_;  ///< by light.extract_*
    int referencesRendered_ = 0;
};

}  // namespace voxcone
