// The renderer on a thread and context of its own, so that the window answers however long a frame takes: what is to be
// seen goes in, finished pictures come out.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "capture/script.h"
#include "frame/renderer.h"
#include "frame/voxel_view.h"
#include "gl/context.h"
#include "gl/texture.h"
#include "scene/placement.h"
#include "viewer/flicker_frame.h"
#include "viewer/settings_history.h"

namespace voxcone {

/// All that a picture depends on, beside the scene's file.
struct View {
    std::uint64_t scene = 0;  ///< RenderThread::sceneSerial() that it was made for; views of other scenes are ignored
    Camera camera;
    double time = 0;
    std::string channel = "beauty";   ///< as in capture/script.h
    Watched watched = Watched::none;  ///< asks for Picture::watched
    Settings settings;                ///< output.width and height are those of the finished picture
    std::optional<glm::dvec3> clipmapEye;
    std::vector<Light> lights;        ///< in the place of the scene's, when they are as many
    std::map<int, Placement> placed;  ///< nodes of the scene that stand elsewhere than the file has them
    bool placing = false;             ///< and they are being dragged: the picture is not yet that of a capture
    VoxelViewOptions voxels;          ///< of voxel views
    double triangles = 0;             ///< share of `beauty` that is mixed into a voxel view, 0 to 1
};

/// Whether the channel needs voxels and G-buffer alone, without light on the visible surfaces.
bool withoutCones(const View& view);

/// "light 2/4 bounces, 37 %", "direct light 12 %", "3 levels to voxelize"; empty when it is whole.
std::string lightText(const LightProgress& light);

/// What the window knows of a scene. `outline` has neither triangles nor images.
struct SceneFacts {
    std::filesystem::path file;  ///< what was opened: scene or capture script
    Scene outline;               ///< nodes, animations, materials, lights (extracted ones too), cameras, skins
    std::vector<Bounds> boxes;   ///< by index in outline.instances: of the mesh, in its own space
    Settings settings;           ///< of the script
    std::vector<Shot> shots;
    Bounds bounds;
    std::size_t triangles = 0;
    double duration = 0;      ///< seconds until nothing moves any more; 0 for a scene that stands still
    std::string description;  ///< JSON: facts of the scene and of the device
};

/// A finished picture.
struct Picture {
    std::shared_ptr<const gl::Texture> texture;  ///< RGBA8, sRGB encoded, row 0 at the bottom
    View view;
    std::uint64_t serial = 0;                    ///< of the view: RenderThread::show
    int divisor = 1;                             ///< the finished picture's size over that of this one
    bool finished = false;                       ///< exactly what a capture of the view gives
    LightProgress light;                         ///< that the picture shows
    bool surfaces = false;                       ///< albedo alone, until there is light
    FrameStats stats;                            ///< of the last frame; levelMilliseconds since the picture before
    ClipmapState clipmap;                        ///< with what was voxelized since the picture before
    std::vector<FrameStats::Pass> updatePasses;  ///< of the last update of voxels and light, all frames that it took
    std::vector<Renderer::Level> levels;
    std::vector<LeftOut> leftOut;
    double milliseconds = 0;  ///< from taking up the view's stage to the finished texture
    Image position;           ///< channel `position` in this picture's size; empty while the view moves
    Image image;              ///< of a finished picture at rest: the channel as an EXR holds it
    std::shared_ptr<const WatchedFrame> watched;  ///< of every picture, when the view asks for it
};

/// A line for the user.
struct Message {
    std::string text;
    bool error = false;
};

class RenderThread {
  public:
    /// `makeContext` is called on the new thread. `wake` is called from it whenever there is something new; `shaders`:
    /// folder whose shaders go before the embedded ones, or empty.
    RenderThread(std::function<std::unique_ptr<gl::Context>()> makeContext, std::function<void()> wake,
                 std::filesystem::path shaders);
    ~RenderThread();
    RenderThread(const RenderThread&) = delete;
    RenderThread& operator=(const RenderThread&) = delete;

    /// Opens a scene or script in the place of what is there, once it is known to be good. `prepare` changes its
    /// settings (--set).
    void open(const std::filesystem::path& file, std::function<void(Settings&)> prepare = {});
    /// Lights the scene by another panorama.
    void environment(const std::filesystem::path& file);

    /// What is to be seen from now on; replaces what was asked before. Answers the view's serial.
    std::uint64_t show(const View& view);

    /// What jobs work on.
    struct Desk {
        Renderer& renderer;
        const Scene& scene;
        const View& view;
        gl::Context& context;
    };
    /// Does `job` once the finished picture of the last view that was shown is on the device. Errors become messages.
    void afterPicture(std::function<void(Desk&)> job);
    /// Does `job` as soon as possible: voxels have the light there is so far, the frame's channels are not whole. It
    /// must not render.
    void now(std::function<void(Desk&)> job);
    /// Hands `result` to the window's thread: takeResults() runs it.
    void deliver(std::function<void()> result);
    /// Runs what was delivered; to be called on the window's thread.
    void takeResults();

    /// Compiles all shaders anew; when one fails, the message is told and the old ones stay.
    void reloadShaders();

    // What is there now; each is a snapshot.
    std::shared_ptr<const Picture> picture() const;
    std::shared_ptr<const SceneFacts> scene() const;
    std::uint64_t sceneSerial() const;  ///< how often a scene was opened
    std::string activity() const;       ///< "loading …", "voxels and light", "picture 1/4"; empty when idle
    double activitySeconds() const;     ///< how long that has been going on
    LightProgress light() const;        ///< how far the light of the voxels has come
    bool idle() const;                  ///< nothing is left to be done
    std::vector<Message> takeMessages();

    /// Longest time, in milliseconds, that the first picture after a change of the view should take.
    void motionBudget(double milliseconds);

  private:
    using Clock = std::chrono::steady_clock;
    struct Loaded;
    void run(const std::function<std::unique_ptr<gl::Context>()>& makeContext);
    void loop(gl::Context& context);
    void order(std::function<void(gl::Context&)> order);
    void load(gl::Context& context, const std::filesystem::path& file, const std::function<void(Settings&)>& prepare);
    void loadEnvironmentImage(const std::filesystem::path& file);
    void prepareRenderer(gl::Context& context, const View& view);
    void placeNodes(gl::Context& context, const View& view);
    void stage(gl::Context& context, const View& view, std::uint64_t serial);
    void publish(const View& view, std::uint64_t serial, bool finished, Clock::time_point start);
    void publishSurfaces(const View& view, std::uint64_t serial);
    void publishFacts(gl::Context& context, bool opened);
    int divisorFor(const Settings::Output& output, const gl::Context& context, double milliseconds) const;
    void tellLight();
    void addUpdate(bool begins);
    void setActivity(const std::string& text);
    void tell(const std::string& text, bool error);

    std::function<void()> wake_;
    std::filesystem::path shaders_;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    bool quit_ = false, wanted_ = false;
    View view_;                                             ///< the latest that was shown
    std::uint64_t serial_ = 0;                              ///< its
    std::deque<std::function<void(gl::Context&)>> orders_;  ///< before the next picture
    std::deque<std::function<void(Desk&)>> afterPicture_;
    std::vector<std::function<void()>> results_;
    std::vector<Message> messages_;
    std::shared_ptr<const Picture> picture_;
    std::shared_ptr<const SceneFacts> facts_;
    std::uint64_t sceneSerial_ = 0;
    std::string activity_;
    std::exception_ptr failure_;  ///< a bug that ended the thread
    Clock::time_point activityStart_;
    LightProgress light_;
    bool idle_ = true;
    std::atomic<std::uint64_t> latest_{0};  ///< serial_, to be asked within a frame
    std::atomic<bool> quitting_{false};     ///< quit_, to be asked within a frame
    std::atomic<bool> ordered_{false};      ///< orders_ is not empty, to be asked within a frame
    std::atomic<double> motionBudget_{100};

    // Only on the thread.
    std::unique_ptr<Loaded> loaded_;
    std::unique_ptr<Renderer> renderer_;
    Settings built_;  ///< of the renderer, or those that gave none
    /// Scene::motionBounds() that the renderer was made for; absent as long as nothing was placed since.
    std::optional<Bounds> builtBounds_;
    bool stale_ = false;       ///< nodes were placed, and what depends on all of the scene has not followed yet
    std::uint64_t shown_ = 0;  ///< view that is being refined
    int divisor_ = 0;          ///< of its last stage; 0 before the first
    bool finished_ = false;
    bool fresh_ = true;      ///< the renderer has no voxels yet
    ClipmapUpdate updated_;  ///< since the last picture
    std::map<int, double> levelMilliseconds_;
    std::vector<FrameStats::Pass> updatePasses_;
    double pixelCost_ = 0;  ///< milliseconds a pixel, of the passes that each pixel has
    std::unique_ptr<class Presenter> presenter_;

    std::thread thread_;
};

}  // namespace voxcone
