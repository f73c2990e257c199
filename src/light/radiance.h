// Radiance of the voxels: direct light and emission of every face that holds a surface, then bounces between them.
#pragma once

#include <functional>

#include "cone/cone_uniforms.h"
#include "core/settings.h"
#include "gl/pass_timers.h"
#include "gl/pieces.h"
#include "gl/shader_library.h"
#include "voxelize/voxelizer.h"

namespace voxcone {

class RadianceField {
  public:
    /// What has changed since the last update, beside the records of the last voxelization.
    struct Change {
        bool light = true;     ///< lights or shadows: direct light of all records is taken anew
        bool coarsest = true;  ///< voxels of the last level, which is where light bounces
        bool forget = true;    ///< bounces begin from nothing, so that the result depends on what is there alone; else
                               ///< one more bounce is added to those of the updates before
    };

    /// `lights`: the scene has analytic lights. Compiles for what settings, voxels and sky need.
    RadianceField(const gl::ShaderLibrary& shaders, const Settings& settings, const Voxels& voxels, const Sky& sky,
                  bool lights);

    using BindLights = std::function<void(gl::Program&)>;

    /// Lights `voxels`: begin() and all of resume(). `bindLights` binds what light/lights.glsl reads to the given
    /// program.
    void update(const Voxels& voxels, const Sky& sky, const Change& change, const BindLights& bindLights,
                gl::PassTimers& timers);

    /// Takes up a change, before the next voxelization: new records are lit unless all are to be. What was under way
    /// goes on, or begins anew where the change asks for it. `shown`: cones may read the voxels before all is done; new
    /// records are black until they are lit.
    void begin(const Voxels& voxels, const Change& change, const BindLights& bindLights, gl::PassTimers& timers,
               bool shown);

    /// Goes on with what has begun, until `stop` says true; at least one piece is done. The light that cones read
    /// meanwhile is that before the change until direct light is whole, then direct light and all whole bounces. True
    /// when light is whole, which is then the same, bit for bit, however often it was stopped.
    bool resume(const Voxels& voxels, const Sky& sky, const BindLights& bindLights, gl::PassTimers& timers,
                const gl::Stop& stop = {});

    bool whole() const { return step_ == Step::whole; }
    /// How far resume() has come: whether direct light is whole; bounces made and to be made at most; the share of
    /// direct light or of the present bounce, 0 to 1.
    bool directWhole() const { return step_ == Step::whole || step_ == Step::bounces; }
    int bouncesMade() const { return made_; }
    int bouncesWanted() const { return wanted_; }
    double share() const { return items_ > 0 ? static_cast<double>(next_) / items_ : 0; }

    /// Keeps of all light what the last bounce of the last update has brought alone. It must have begun from nothing,
    /// with a light.bounces of 1 or more, light.tolerance 0 and no light.extrapolate; so must the next update.
    void isolateLastBounce(const Voxels& voxels);

    /// Valid until the next update; `voxels` must still live.
    RadianceVolume volume(const Voxels& voxels) const { return {&voxels, sixFace_ ? &faces_ : &folded_, scale_}; }

    /// Radiances that were beyond the range of their storage at the last update.
    std::uint32_t clamped() const { return counters_.clamped; }
    /// Records in use at a level or mip.
    std::uint32_t records(int level) const { return counters_.records[level]; }
    /// Faces of the last level: those that gather bounces.
    std::uint32_t activeFaces() const { return counters_.activeFaces; }
    /// Bounces that were made when they last began from nothing: light.bounces, or fewer by light.tolerance.
    int bounces() const { return bounces_; }
    /// Ratio of the light that the last two of them added, by channel; 0 with fewer than two.
    const glm::vec3& gain() const { return gain_; }
    std::uint64_t bytes() const {
        return direct_.bytes() + gathered_.bytes() + faces_.bytes() + folded_.bytes() + list_.bytes() + state_.bytes();
    }

    /// RGB radiance over volume().scale and coverage of each face of each slot, as half floats.
    const gl::Buffer& faces() const { return faces_; }

  private:
    /// What an update has still to do.
    enum class Step : int { whole, direct, measure, bounces };
    void reserve(const Voxels& voxels);
    void reset(const Voxels& voxels);
    bool inject(const Voxels& voxels, bool listed, const BindLights& bindLights, int& next, int items,
                const gl::Stop& stop);
    void measure(const Voxels& voxels, bool list);
    bool decide(const Sky& sky);
    void beginSeries(const Voxels& voxels);
    bool bounce(const Voxels& voxels, const Sky& sky, const gl::Stop& stop);
    void show(const Voxels& voxels, bool all, bool count);
    void spread(const Voxels& voxels, bool all);
    void store(const Voxels& voxels, int firstLevel, bool all, bool count, bool inSeries = false);

    Settings settings_;
    bool lights_, sixFace_;
    gl::Program inject_, reset_, measure_, store_, bounce_, series_, extend_, spread_, mip_, fold_;
    gl::Buffer direct_;  ///< six RGB9E5 a slot: from lights and emission, W/(m² sr)
    gl::Buffer
        gathered_;       ///< six uvec2 a slot: mean incoming radiance over the hemisphere, over scale_, as half floats
    gl::Buffer faces_;   ///< six uvec2 a slot
    gl::Buffer folded_;  ///< what shaders/light/fold.comp makes of the faces, unless cones read those
    gl::Buffer list_;    ///< faces of the last level, and what each has gathered in the last bounce
    gl::Buffer state_;   ///< shaders/light/series.glsl
    gl::Buffer counterBuffer_;
    VoxelCounters counters_;  ///< as they were last read
    int bounces_ = 0;
    glm::vec3 gain_{0};
    float scale_ = 1;

    Step step_ = Step::whole;
    Change change_;                                     ///< all that step_ has to regard
    bool again_ = false;                                ///< something gathers
    int next_ = 0, items_ = 0;                          ///< faces of the step that are done, and all
    int made_ = 0, wanted_ = 0;                         ///< bounces
    bool roundStored_ = false;                          ///< faces_ holds the last level as the present bounce reads it
    int directPiece_ = 1 << 10, bouncePiece_ = 1 << 8;  ///< faces at a time: gl::inPieces
};

}  // namespace voxcone
