// What is being looked at and how: the state behind the panels, and all that they and the keys can do to it.
#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cone/inspect.h"
#include "core/voxel_channel.h"
#include "frame/voxel_slice.h"
#include "metric/metrics.h"
#include "viewer/camera_control.h"
#include "viewer/comparison.h"
#include "viewer/edit_history.h"
#include "viewer/flicker.h"
#include "viewer/overlay.h"
#include "viewer/render_thread.h"
#include "viewer/script_writer.h"
#include "viewer/settings_history.h"
#include "viewer/tracer.h"

namespace voxcone {

/// Where the viewer writes.
struct ViewerFolders {
    std::filesystem::path output = ".";  ///< screenshots, scripts, presets
    std::filesystem::path config;        ///< recent files and the layout; empty: none are kept
};

/// What the last frames cost.
struct CostHistory {
    static constexpr std::size_t kFrames = 120;
    std::map<std::string, std::deque<float>> passes;  ///< milliseconds by pass, latest last
    std::deque<float> frame;                          ///< milliseconds of the device
    /// By level: voxels that were voxelized anew in each of the frames, but for those that began everything anew.
    std::vector<std::deque<float>> voxels;
    std::vector<std::deque<float>> levels;  ///< milliseconds that this took, likewise, of the first frames too
    FrameStats lastUpdate;                  ///< of the last frame that voxelized anything
    void add(const Picture& picture);
};

/// A pixel that was asked about: what it sums, and the cones that gathered it.
struct Inspection {
    glm::ivec2 pixel{0};  ///< of the picture, from the upper left
    View view;
    std::vector<PixelCones> lobes;  ///< Renderer::inspect
    /// Radiance towards the eye by channel, W/(m² sr): beauty without exposure, direct, ….
    std::vector<std::pair<std::string, glm::vec3>> terms;
    std::unique_ptr<BackgroundTracer> tracer;  ///< of the same pixel
    int lobe = 0;                              ///< whose cones are shown
    int selected = 0;                          ///< cone of it
    bool onlySelected = false;                 ///< draw that one alone
    /// The lobe whose cones are shown; null where there is no surface.
    const PixelCones* shown() const { return lobes.empty() ? nullptr : &lobes[static_cast<std::size_t>(lobe)]; }
    /// All of it, the path-traced terms too.
    std::string json() const;
    /// The path-traced value of a term; nothing yet, or none.
    std::optional<glm::vec3> traced(const std::string& term) const;
};

/// A picture that is held to compare the present one with.
struct Held {
    std::shared_ptr<const gl::Texture> texture;
    std::shared_ptr<const Image> image;  ///< linear, as an EXR of its channel holds it
    std::string name;
};

/// Whether both views give the same picture.
bool sameView(const View& a, const View& b);

/// A region that was just voxelized, for as long as it flashes.
struct Flash {
    Bounds box;  ///< world space
    int level = 0;
    std::chrono::steady_clock::time_point start;
};

/// What dragging a gizmo does to an object, or to a light.
enum class GizmoMode : int { move, turn, scale };

struct Session {
    using Clock = std::chrono::steady_clock;

    /// `change`: changes the settings of whatever is opened (--set), if not empty.
    Session(RenderThread& renderThread, ViewerFolders where, std::function<void(Settings&)> change);

    /// Hands work to the window's next turn; see RenderThread. Before all that calls it from threads.
    std::function<void()> wake;

    // ---- What is shown
    RenderThread& thread;
    ViewerFolders folders;
    std::shared_ptr<const SceneFacts> facts;
    std::uint64_t sceneSerial = 0;
    std::shared_ptr<const Picture> picture;  ///< the latest
    SettingsHistory settings;
    std::string presetName, settingsFilter;  ///< as typed in the panel
    CameraControl camera;
    std::string channel = "beauty";
    int level = -1;                        ///< of voxel views; −1: the one that cones read
    int voxelFace = -1, voxelBounce = -1;  ///< of voxel views that have them: VoxelChannel
    std::vector<Light> lights;
    bool followWindow = false;  ///< the picture has the size of the place it is shown in

    // ---- Time
    double time = 0;
    bool playing = false;
    int shot = 0;             ///< of the script, whose camera was taken last
    bool followShot = false;  ///< the camera is that of the shot's path

    // ---- Clipmap
    std::optional<glm::dvec3> frozenEye;
    bool showLevels = false, showSnapGrid = false, showUpdates = true;
    std::vector<char> levelShown;  ///< by level; wire box
    std::deque<Flash> flashes;

    // ---- Moved by hand
    bool showLights = false;  ///< with handles that move them
    int selectedLight = 0;
    std::map<int, Placement> placed;  ///< nodes that stand elsewhere than the file has them
    int selectedNode = -1;            ///< has a gizmo; −1: none
    GizmoMode gizmoMode = GizmoMode::move;
    bool dragging = false;  ///< a button is held: what it changes is one step, and not yet finished

    // ---- Voxels
    VoxelViewOptions voxels;
    double triangles = 0;  ///< View::triangles
    int cutAxis = -1;      ///< −1: nothing is cut
    bool cutFlipped = false;
    double cutPlace = 0.5;  ///< over the scene's bounds along the axis
    bool sliceShown = false;
    int sliceAxis = 1, sliceDepth = 0;
    std::shared_ptr<const VoxelSlice> slice;  ///< the latest
    std::optional<Occupancy> occupancy;       ///< of all of the level `occupancyLevel`, when it was asked for
    int occupancyLevel = 0;

    // ---- Questions
    std::unique_ptr<Inspection> inspection;
    bool inspecting = false;  ///< clicks ask about pixels
    std::optional<Held> held;
    std::string heldName;  ///< as typed in the panel
    double split = 0.5;    ///< left of it the held picture is shown, or that of A beside B's
    std::unique_ptr<BackgroundTracer> referenceTracer;  ///< renders the held picture

    // ---- Comparison
    /// Settings B; null when there are none.
    std::unique_ptr<OtherSettings> other;
    std::string otherPreset;  ///< as typed in the panel
    /// The controls change B: `settings` holds it, and `other->settings` A.
    bool controlsOther = false;
    ErrorMap errorMap = ErrorMap::none;
    double errorScale = 1, errorOpacity = 1;  ///< error at the map's brightest colour; 0 to 1 over the picture
    ImageOf presentImage, otherImage;
    Measurement presentToHeld, otherToHeld, otherToPresent;
    Flicker flicker;
    /// Makes the thread of settings B; see RenderThread.
    std::function<std::unique_ptr<RenderThread>()> otherThread;

    // ---- Views and recording
    std::vector<SavedView> views;
    bool recording = false;
    std::filesystem::path environmentFile;  ///< replaced the scene's environment

    // ---- Figures and messages
    CostHistory history;
    bool countSamples = false;              ///< of every finished picture
    std::optional<double> samplesPerPixel;  ///< that cones looked at for the picture `samplesSerial`
    std::uint64_t samplesSerial = 0;
    std::deque<Message> messages;  ///< latest last
    Clock::time_point messageTime;
    std::vector<std::filesystem::path> recent;

    // ---- Actions
    /// Opens whatever the file is: scene, capture script, or panorama.
    void open(const std::filesystem::path& file);
    void takeShot(int index);
    void takeCamera(const Camera& worldCamera);
    /// Any change by hand ends the following of a path.
    void moved() { followShot = false; }
    /// Frame all of the scene.
    void frameScene();
    /// Makes the surface under a place of the picture (0 to 1, from the upper left) the camera's target.
    bool focus(const glm::dvec2& place);
    /// World position seen there, as far as it is known.
    std::optional<glm::dvec3> surfaceAt(const glm::dvec2& place) const;

    /// Asks about the pixel at a place of the picture (0 to 1).
    void inspect(const glm::dvec2& place);
    /// Holds the present picture, a file, or the path-traced picture of the present view.
    void hold();
    void holdFile(const std::filesystem::path& file);
    void holdReference();
    void releaseHeld();
    void forgetInspection();

    /// Begins to compare the present settings with others: a copy of them, to which the preset is applied if not empty
    /// (name or file).
    void compareWith(const std::string& preset);
    /// Ends it; A becomes what B was, if `keep`.
    void endOther(bool keep = false);
    /// The controls change the other settings from now on.
    void exchangeControls();
    const Settings& settingsA() const { return controlsOther ? other->settings.now() : settings.now(); }
    const Settings& settingsB() const { return controlsOther ? settings.now() : other->settings.now(); }
    /// The thread that renders what is seen at a place of the picture (0 to 1).
    RenderThread& threadAt(const glm::dvec2& place) { return other && place.x >= split ? other->thread() : thread; }
    /// Compiles all shaders anew, of both settings.
    void reloadShaders();
    /// Watches for changes from picture to picture, or ends it.
    void watch(Watched what);
    /// Forgets the changes so far; the next picture is compared with the present one.
    void clearChanges();

    /// Asks for the slice that the controls say.
    void askSlice();
    bool slicePending() const { return sliceAnswered_ != sliceSerial_; }
    /// The slice shows voxels as they were for an earlier view, before their light was whole, or other light.
    bool sliceStale() const {
        return (picture && picture->finished && (slicePicture_ != picture->serial || !sliceSettled_)) ||
               sliceBounce_ != voxelChannel().bounce;
    }

    /// Asks for the occupancy of a whole level or mip.
    void askOccupancy(int ofLevel);

    /// Where a light stands; nothing for a directional one.
    std::optional<glm::dvec3> lightPosition(std::size_t light) const;
    /// Whether it may be moved: neither animated nor standing for something else.
    bool movable(std::size_t light) const;
    /// Moves a light to a world position.
    void moveLight(std::size_t light, const glm::dvec3& to);
    /// The way a light shines, in the world, unit; nothing for those that shine all around.
    std::optional<glm::dvec3> lightDirection(std::size_t light) const;
    bool turnable(std::size_t light) const;
    /// Lets a directional or spot light shine along a world direction of any length.
    void pointLight(std::size_t light, const glm::dvec3& direction);
    /// Turns what a light was before by a world rotation.
    void turnLight(std::size_t light, const Light& before, const glm::dquat& rotation);

    // Objects (session_objects.cpp).
    /// SceneFacts::outline with its nodes where they were put.
    const Scene& scene() const { return scene_; }
    /// Why a node cannot be put elsewhere; empty when it can.
    std::string fixedBecause(int node) const;
    /// Puts a node elsewhere; what `placement` leaves out stays as it was put. Numbers that a script could not have are
    /// brought into its ranges.
    void placeNode(int node, const Placement& placement);
    /// Puts it back where the file has it.
    void putBack(int node);
    /// Box of what hangs on a node, in the node's own space; empty for a node without meshes.
    Bounds nodeBox(int node) const;
    /// Middle of that box, or the node's origin, in the world.
    glm::dvec3 nodeCenter(int node) const;
    /// Selects the object at a place of the picture (0 to 1), or nothing.
    void pick(const glm::dvec2& place);

    void freeze(bool on);
    bool frozen() const { return frozenEye.has_value(); }
    /// Moves a frozen clipmap by at most one snap of the finest level along each axis, towards the camera.
    void stepClipmap();

    void saveView();
    void recallView(const SavedView& view);
    void startRecording();
    void stopRecording();
    void screenshot();
    void writeScript();
    /// Settings as a preset file in the output folder.
    void savePreset(const std::string& name);
    void applyPresetByName(const std::string& nameOrFile);
    void undo();
    void redo();
    void say(const std::string& text, bool error = false);

    /// The voxel view that `channel` is, with all that was chosen of it.
    VoxelChannel voxelChannel() const;
    /// The channel's name as a script has it.
    std::string shownChannel() const;
    /// What is to be seen now.
    View view() const;

    /// One turn: takes what the thread has, moves time on by `seconds`, and shows the view if it has changed. `place`:
    /// pixels that the picture may take. True when something on the screen has changed.
    bool update(double seconds, const glm::ivec2& place);
    /// The finished picture of the present view is there, and nothing is left to be done.
    bool settled() const;
    /// Something moves by itself, so that the window must be drawn again.
    bool animated() const { return playing || recording || !flashes.empty(); }

  private:
    void takeScene();
    /// Lights as in `from`, but for extracted ones.
    void takeLights(const std::vector<Light>& from);
    void poseScene();
    /// Makes what was moved by hand a step, unless it is still being dragged.
    void rememberEdits();
    void takeEdits();
    void takePicture(const std::shared_ptr<const Picture>& next);
    void remember(const std::filesystem::path& file);
    std::filesystem::path freshFile(const std::string& stem, const std::vector<std::string>& extensions) const;
    SavedView viewNow(const std::string& name) const;

    std::function<void(Settings&)> prepare_;
    Scene scene_;
    EditHistory edits_;
    void takeTraced();
    void retire(std::unique_ptr<BackgroundTracer> tracer);
    void compare();
    void updateOther(const View& shown);
    void watchPicture();

    std::vector<std::unique_ptr<BackgroundTracer>> retired_;  ///< told to stop; nobody waits for their last pass
    std::optional<View> shown_;
    std::shared_ptr<const TracedPicture> traced_;
    std::future<void> otherEnds_;
    std::shared_ptr<const Picture> watched_;  ///< the last that the flicker view has taken
    View referenceView_;
    void askSamples();
    std::uint64_t samplesAsked_ = 0;  ///< serial of the view whose samples are counted
    std::uint64_t sliceAnswered_ = 0;
    std::uint64_t sliceSerial_ = 0;   ///< of the last slice that was asked for
    std::uint64_t slicePicture_ = 0;  ///< serial of the view that it shows
    int sliceBounce_ = -1;            ///< whose light it shows
    bool sliceSettled_ = false;       ///< with whole light
    std::uint64_t shownSerial_ = 0;
    Clock::time_point placeChanged_;
    glm::ivec2 place_{0}, lastPlace_{0};
    double recordClock_ = 0;  ///< seconds since the recording began
    SavedView recorded_;
    Worker measuring_;  ///< last: it ends before what its results go to
};

}  // namespace voxcone
