#include "gl/pass_timers.h"

#include <algorithm>

#include "core/check.h"

namespace voxcone::gl {
namespace {

double millisecondsBetween(std::chrono::steady_clock::time_point a, std::chrono::steady_clock::time_point b) {
    return std::chrono::duration<double, std::milli>(b - a).count();
}

double millisecondsBetween(GLuint beginQuery, GLuint endQuery) {
    GLuint64 a = 0, b = 0;
    glGetQueryObjectui64v(beginQuery, GL_QUERY_RESULT, &a);
    glGetQueryObjectui64v(endQuery, GL_QUERY_RESULT, &b);
    return b > a ? static_cast<double>(b - a) * 1e-6 : 0.0;
}

}  // namespace

TimerMode suitableTimerMode(const DeviceInfo& info) {
    return info.softwareRasterizer ? TimerMode::finish : TimerMode::query;
}

PassTimers::Query PassTimers::stamp() {
    GLuint id = 0;
    glGenQueries(1, &id);
    glQueryCounter(id, GL_TIMESTAMP);
    return Query(id);
}

void PassTimers::beginFrame() {
    VOXCONE_CHECK(!inFrame_, "beginFrame inside a frame");
    inFrame_ = true;
    label_ = -1;
    current_ = {};
    if (mode_ == TimerMode::query) {
        current_.total.begin = stamp();
    } else {
        glFinish();
        frameStart_ = Clock::now();
    }
}

void PassTimers::endFrame() {
    VOXCONE_CHECK(inFrame_ && !inPass_, "endFrame outside a frame or inside a pass");
    inFrame_ = false;
    if (mode_ == TimerMode::query) {
        current_.total.end = stamp();
    } else {
        glFinish();
        current_.total.milliseconds = millisecondsBetween(frameStart_, Clock::now());
    }
    pending_.push_back(std::move(current_));
    current_ = {};
    collect(false);
}

PassTimers::Scope::Scope(PassTimers& timers, const std::string& name) : timers_(timers) {
    VOXCONE_CHECK(!timers.inPass_, "pass {} inside a pass", name);
    timers.inPass_ = true;
    glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, static_cast<GLsizei>(name.size()), name.data());
    if (!timers.inFrame_) return;
    timers.current_.passes.push_back({name, {}, {}, 0, timers.label_});
    if (timers.mode_ == TimerMode::query) {
        timers.current_.passes.back().begin = stamp();
    } else {
        glFinish();
        timers.passStart_ = Clock::now();
    }
}

PassTimers::Scope::~Scope() {
    timers_.inPass_ = false;
    if (timers_.inFrame_) {
        if (timers_.mode_ == TimerMode::query) {
            timers_.current_.passes.back().end = stamp();
        } else {
            glFinish();
            timers_.current_.passes.back().milliseconds = millisecondsBetween(timers_.passStart_, Clock::now());
        }
    }
    glPopDebugGroup();
}

void PassTimers::collect(bool block) {
    while (!pending_.empty()) {
        const Frame& frame = pending_.front();
        const bool query = mode_ == TimerMode::query;
        if (query && !block) {
            GLint available = GL_FALSE;
            glGetQueryObjectiv(frame.total.end.id(), GL_QUERY_RESULT_AVAILABLE, &available);
            if (available == GL_FALSE) return;
        }
        results_.clear();
        byLabel_.clear();
        for (const Mark& mark : frame.passes) {
            const double ms = query ? millisecondsBetween(mark.begin.id(), mark.end.id()) : mark.milliseconds;
            if (mark.label >= 0) byLabel_[mark.label] += ms;
            const auto same = std::find_if(results_.begin(), results_.end(),
                                           [&](const PassTime& time) { return time.name == mark.name; });
            if (same == results_.end()) {
                results_.push_back({mark.name, ms});
            } else {
                same->milliseconds += ms;
            }
        }
        frameMilliseconds_ =
            query ? millisecondsBetween(frame.total.begin.id(), frame.total.end.id()) : frame.total.milliseconds;
        pending_.pop_front();
    }
}

void PassTimers::wait() {
    collect(true);
}

}  // namespace voxcone::gl
