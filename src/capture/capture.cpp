#include "capture/capture.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <optional>

#include "capture/output.h"
#include "core/progress.h"
#include "frame/renderer.h"
#include "gl/context.h"
#include "metric/temporal.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

json frameJson(const FrameStats& stats, int frame, double time) {
    json passes = json::array(), memory = json::array();
    std::uint64_t bytes = 0;
    for (const FrameStats::Pass& pass : stats.passes)
        passes.push_back({{"name", pass.name}, {"ms", pass.milliseconds}});
    for (const FrameStats::Memory& item : stats.memory) {
        memory.push_back({{"name", item.name}, {"bytes", item.bytes}});
        bytes += item.bytes;
    }
    return {{"frame", frame},   {"time_s", time},   {"timer", stats.timer},  {"frame_ms", stats.frameMilliseconds},
            {"passes", passes}, {"memory", memory}, {"memory_bytes", bytes}, {"counts", stats.counts}};
}

/// Drivers compile shaders at their first use: a frame of the same passes, but tiny, keeps that out of the times.
void warmUp(const CaptureScript& script, gl::Context& context) {
    Settings tiny = script.settings;
    tiny.output.width = tiny.output.height = 16;
    tiny.voxel.resolution = 16;
    tiny.light.shadowResolution = 128;
    tiny.light.bounces = std::min(tiny.light.bounces, 1);
    Renderer renderer(context, script.scene, tiny);
    const Shot& shot = script.shots.front();
    renderer.render(cameraAt(shot, script.scene, shot.timeOf(shot.firstFrame)));
}

json changeJson(const TemporalChange& change) {
    return {{"rms", change.rms}, {"mean", change.mean}, {"jump", change.jump()}, {"valid", change.valid}};
}

json figureJson(const TemporalFigure& figure) {
    return {{"F", figure.f},
            {"worst_jump", figure.worstJump},
            {"worst_rms", figure.worstRms},
            {"mean", figure.mean},
            {"valid", figure.valid}};
}

json seamJson(const std::vector<SeamStep>& steps) {
    json out = json::array();
    for (const SeamStep& step : steps)
        out.push_back({{"level", step.level}, {"pixels", step.pixels}, {"mean", step.mean}, {"rms", step.rms}});
    return out;
}

}  // namespace

TemporalFrame temporalFrame(Renderer& renderer, const Camera& camera) {
    TemporalFrame out{renderer.channel("indirect_diffuse"), renderer.channel("albedo"), renderer.channel("position"),
                      renderer.channel("normal"), viewMatrix(camera)};
    // Depth plays no part, so the near plane may lie anywhere.
    out.worldToClip = glm::infinitePerspective(glm::radians(camera.verticalFovDeg),
                                               static_cast<double>(out.position.width) / out.position.height, 1.0) *
                      out.worldToClip;
    return out;
}

json describeDevice(const gl::DeviceInfo& info) {
    return {{"vendor", info.vendor},
            {"renderer", info.renderer},
            {"version", info.version},
            {"glsl_version", info.glslVersion},
            {"platform", info.platform},
            {"software_rasterizer", info.softwareRasterizer},
            {"limits",
             {{"texture_2d", info.max2DTextureSize},
              {"texture_3d", info.max3DTextureSize},
              {"texture_cube", info.maxCubeSize},
              {"array_layers", info.maxArrayLayers},
              {"ssbo_bytes", info.maxSsboBytes},
              {"compute_image_uniforms", info.maxImageUniforms},
              {"fragment_image_uniforms", info.maxFragmentImageUniforms},
              {"texture_units", info.maxTextureUnits},
              {"compute_invocations", info.maxComputeInvocations},
              {"geometry_invocations", info.maxGeometryInvocations},
              {"draw_buffers", info.maxDrawBuffers}}}};
}

std::vector<fs::path> runCapture(const CaptureScript& script, gl::Context& context, const fs::path& out) {
    ShotWriter writer(out);
    warmUp(script, context);
    Renderer renderer(context, script.scene, script.settings);
    Progress progress("capture " + script.scene.file.stem().string());
    int frames = 0, done = 0;
    for (const Shot& shot : script.shots) frames += shot.frameCount();

    for (const Shot& shot : script.shots) {
        json stats = statsHead("capture", script, shot);
        stats["device"] = describeDevice(context.info());
        stats["frames"] = json::array();
        renderer.invalidate();
        std::optional<TemporalFrame> before;
        std::vector<TemporalChange> changes, lightChanges;
        for (int frame = shot.firstFrame; frame <= shot.lastFrame; ++frame) {
            const double time = shot.timeOf(frame);
            const Camera camera = cameraAt(shot, script.scene, time);
            if (moves(script.scene)) renderer.setTime(time);
            TemporalChange light;
            if (shot.temporal && frame > shot.firstFrame) {
                light = lightChanges.emplace_back(renderer.renderAndCompare(camera));
            } else {
                renderer.render(camera);
            }
            context.checkErrors();
            json& frameStats = stats["frames"].emplace_back(frameJson(renderer.stats(), frame, time));
            if (shot.temporal) {
                TemporalFrame now = temporalFrame(renderer, camera);
                if (before) {
                    const TemporalChange change = changes.emplace_back(temporalChange(*before, now));
                    frameStats["temporal"] = changeJson(light);
                    frameStats["temporal"]["picture"] = changeJson(change);
                }
                before = std::move(now);
            }
            for (const std::string& channel : shot.channels) {
                if (channel == "seam") frameStats["seam"] = seamJson(renderer.seam());
                const Image image = renderer.channel(channel);
                writer.channel(shot, channel, frame, image,
                               channel == "beauty" ? renderer.display() : pictureOf(channel, image, script.settings));
            }
            progress.update(static_cast<double>(++done) / frames);
        }
        if (shot.temporal) {
            stats["temporal"] = figureJson(temporalFigure(lightChanges));
            stats["temporal"]["picture"] = figureJson(temporalFigure(changes));
        }
        writer.stats(shot, stats);
    }
    return writer.take();
}

}  // namespace voxcone
