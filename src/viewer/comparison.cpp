#include "viewer/comparison.h"

#include <algorithm>
#include <utility>

#include "capture/output.h"
#include "core/error.h"
#include "metric/flip.h"
#include "viewer/session.h"

namespace voxcone {
namespace {

/// What a display shows of a channel, as reports have it.
Image displayed(const std::string& channel, const Image& image, const Settings& settings) {
    return channel == "beauty" ? displayOf(image, settings.output.toneMap) : pictureOf(channel, image, settings);
}

bool samePair(const MeasuredPair& a, const MeasuredPair& b) {
    return a.reference == b.reference && a.test == b.test && a.map == b.map &&
           sameSettings(a.referenceSettings, b.referenceSettings) && sameSettings(a.testSettings, b.testSettings);
}

}  // namespace

std::shared_ptr<const Image> ImageOf::operator()(const std::shared_ptr<const Picture>& picture) {
    if (picture != picture_) {
        picture_ = picture;
        image_ = picture && !picture->image.data.empty() ? std::make_shared<const Image>(picture->image) : nullptr;
    }
    return image_;
}

Errors measure(const MeasuredPair& pair) {
    Errors out;
    out.kind = pair.map;
    const Image &reference = *pair.reference, &test = *pair.test;
    try {
        requireComparable(reference, "left", test, "right");
    } catch (const InputError& error) {
        out.whyNot = error.what();
        return out;
    }
    out.linear = linearError(reference, test);
    const Image a = displayed(pair.channel, reference, pair.referenceSettings),
                b = displayed(pair.channel, test, pair.testSettings);
    out.display = displayError(a, b);
    const auto keep = [&](Image map) { out.map = std::make_shared<const Image>(std::move(map)); };
    if (pair.map == ErrorMap::flip) keep(flip(a, b));
    if (pair.map == ErrorMap::hdr_flip) keep(hdrFlip(reference, test).error);
    if (pair.map == ErrorMap::relative) keep(relativeErrorMap(reference, test));
    return out;
}

void Measurement::follow(Worker& worker, const MeasuredPair& pair) {
    if (underWay_ || samePair(asked_, pair)) return;
    asked_ = pair;
    underWay_ = true;
    worker.post([this, pair, serial = ++serial_]() -> Worker::Result {
        return [this, errors = measure(pair), test = pair.test, serial] {
            underWay_ = false;
            if (serial != serial_) return;
            errors_ = errors;
            measured_ = test;
        };
    });
}

void Measurement::forget() {
    ++serial_;
    errors_.reset();
    measured_.reset();
    asked_ = {};
}

const Errors* Measurement::errorsOf(const std::shared_ptr<const Image>& test) const {
    return test && measured_ == test ? errors() : nullptr;
}

OtherSettings::OtherSettings(std::unique_ptr<RenderThread> thread, const std::filesystem::path& file,
                             const std::filesystem::path& environment, const Settings& given)
    : settings(given), thread_(std::move(thread)) {
    thread_->open(file, [given](Settings& s) { s = given; });
    if (!environment.empty()) thread_->environment(environment);
}

void OtherSettings::show(const View& a, const Settings& given) {
    const auto facts = thread_->scene();
    if (!facts) return;
    View view = a;
    view.scene = thread_->sceneSerial();
    view.settings = given;
    view.watched = Watched::none;
    view.lights = facts->outline.lights;
    for (std::size_t i = 0; i < std::min(view.lights.size(), a.lights.size()); ++i)
        if (!view.lights[i].extracted && !a.lights[i].extracted) view.lights[i] = a.lights[i];
    if (shown_ && sameView(*shown_, view)) return;
    shown_ = view;
    shownSerial_ = thread_->show(view);
}

bool OtherSettings::update(std::vector<Message>& messages) {
    thread_->takeResults();
    messages = thread_->takeMessages();
    return std::exchange(picture_, thread_->picture()) != picture_;
}

bool OtherSettings::settled() const {
    return shown_ && thread_->idle() && picture_ && picture_->finished && picture_->serial == shownSerial_;
}

std::future<void> OtherSettings::end() && {
    return std::async(std::launch::async, [thread = std::move(thread_)]() mutable { thread.reset(); });
}

}  // namespace voxcone
