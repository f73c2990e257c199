// Pictures against each other: figures and maps of the error, and a second tree of settings for the same view.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "metric/metrics.h"
#include "viewer/render_thread.h"
#include "viewer/settings_history.h"
#include "viewer/worker.h"

namespace voxcone {

/// Which error of every pixel is shown.
enum class ErrorMap : int {
    none,
    flip,      ///< ꟻLIP of what a display shows, [0,1]
    hdr_flip,  ///< HDR-ꟻLIP of linear values, [0,1]: that of reports
    relative,  ///< relativeErrorMap(), signed
};
inline constexpr std::array kErrorMapNames = {"none", "FLIP", "HDR-FLIP", "relative error"};

/// A finished picture's image without its texture, which only the window's thread may let go of.
class ImageOf {
  public:
    /// Null while the picture has none. The same pointer for the same picture.
    std::shared_ptr<const Image> operator()(const std::shared_ptr<const Picture>& picture);

  private:
    std::shared_ptr<const Picture> picture_;
    std::shared_ptr<const Image> image_;
};

/// A picture and what it is measured against.
struct MeasuredPair {
    std::shared_ptr<const Image> reference, test;  ///< linear, as an EXR of `channel` holds them
    std::string channel;
    Settings referenceSettings, testSettings;  ///< exposure and tone curve that they are displayed with
    ErrorMap map = ErrorMap::none;
};

struct Errors {
    LinearError linear;
    DisplayError display;
    ErrorMap kind = ErrorMap::none;
    std::shared_ptr<const Image> map;  ///< one channel; null without one
    std::string whyNot;                ///< the pictures cannot be compared: nothing of the above holds
};

/// What the pair differs by; runs for a while.
Errors measure(const MeasuredPair& pair);

/// One comparison that follows its pictures.
class Measurement {
  public:
    /// Has `worker` measure the pair, unless it has been measured or something still is: to be called again and again
    /// with what is present.
    void follow(Worker& worker, const MeasuredPair& pair);
    void forget();

    /// Of the pair that was measured last; null when there is none.
    const Errors* errors() const { return errors_ ? &*errors_ : nullptr; }
    /// The same, if `test` was what was measured.
    const Errors* errorsOf(const std::shared_ptr<const Image>& test) const;

  private:
    std::optional<Errors> errors_;
    MeasuredPair asked_;
    std::shared_ptr<const Image> measured_;  ///< test picture of errors_
    std::uint64_t serial_ = 0;               ///< of what was asked for or forgotten last
    bool underWay_ = false;
};

/// Settings B beside the window's own, A: rendered for the same view, by a thread and renderer of their own.
class OtherSettings {
  public:
    /// Opens `file` once more, lit by `environment` if not empty.
    OtherSettings(std::unique_ptr<RenderThread> thread, const std::filesystem::path& file,
                  const std::filesystem::path& environment, const Settings& settings);

    /// Shows what A shows with B's settings. Of `a`, scene and settings are not used; moved lights are, but for those
    /// that extraction made.
    void show(const View& a, const Settings& settings);
    /// Takes pictures and messages. True when there is a new picture.
    bool update(std::vector<Message>& messages);
    /// The finished picture of what was shown last is there.
    bool settled() const;

    RenderThread& thread() { return *thread_; }
    const std::shared_ptr<const Picture>& picture() const { return picture_; }
    /// Ends the thread beside the window, which need not wait for a pass that cannot be given up.
    std::future<void> end() &&;

    SettingsHistory settings;  ///< the tree that the controls do not change: Session::controlsOther

  private:
    std::unique_ptr<RenderThread> thread_;
    std::shared_ptr<const Picture> picture_;
    std::optional<View> shown_;
    std::uint64_t shownSerial_ = 0;
};

}  // namespace voxcone
