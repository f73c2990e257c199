#include "capture/reference.h"

#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "capture/output.h"
#include "core/log.h"
#include "core/progress.h"
#include "reference/path_tracer.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// The image of a channel; null for those that only the renderer has.
const Image* referenceChannel(const ReferenceImages& images, const std::string& name) {
    const std::map<std::string, const Image*> all = {{"beauty", &images.beauty},
                                                     {"direct", &images.direct},
                                                     {"indirect_diffuse", &images.indirectDiffuse},
                                                     {"indirect_specular", &images.indirectSpecular},
                                                     {"transmission", &images.transmission},
                                                     {"emission", &images.emission},
                                                     {"albedo", &images.albedo},
                                                     {"normal", &images.normal},
                                                     {"ao", &images.ao},
                                                     {"depth", &images.depth},
                                                     {"position", &images.position}};
    const auto found = all.find(name);
    return found == all.end() ? nullptr : found->second;
}

}  // namespace

std::vector<fs::path> runReference(const CaptureScript& script, const fs::path& out) {
    ShotWriter writer(out);
    Progress progress("reference " + script.scene.file.stem().string());
    std::optional<PathTracer> tracer;
    double tracerTime = -1;
    int frames = 0, done = 0;
    for (const Shot& shot : script.shots) frames += shot.frameCount();

    for (const Shot& shot : script.shots) {
        json stats = statsHead("reference", script, shot);
        stats["frames"] = json::array();
        for (const std::string& channel : shot.channels) {
            if (referenceChannel(ReferenceImages{}, channel) == nullptr)
                log::info("{}: {} is the renderer's alone, left out of the reference", shot.name, channel);
        }
        std::optional<ReferenceImages> images;
        Camera camera;
        for (int frame = shot.firstFrame; frame <= shot.lastFrame; ++frame) {
            const double time = shot.timeOf(frame);
            if (!tracer || (moves(script.scene) && time != tracerTime)) {
                tracer.emplace(script.scene, time);
                tracerTime = time;
                images.reset();
            }
            const Camera cameraBefore = std::exchange(camera, cameraAt(shot, script.scene, time));
            // Where nothing has moved, the picture is that of the frame before.
            if (!images || camera.position != cameraBefore.position || camera.target != cameraBefore.target) {
                const auto tell = [&](double part) { progress.update((done + part) / frames); };
                images = tracer->render(camera, script.settings, tell);
                // As the renderer's: exposed, before the tone curve.
                const auto exposure = static_cast<float>(std::exp2(script.settings.output.exposure));
                for (float& value : images->beauty.data) value *= exposure;
            }
            stats["frames"].push_back({{"frame", frame},
                                       {"time_s", time},
                                       {"samples", images->samples},
                                       {"seconds", images->seconds},
                                       {"beauty_error", images->beautyError},
                                       {"indirect_diffuse_error", images->indirectDiffuseError},
                                       {"noise_relmse", images->noise}});
            for (const std::string& channel : shot.channels) {
                const Image* image = referenceChannel(*images, channel);
                if (image == nullptr) continue;
                writer.channel(shot, channel, frame, *image,
                               channel == "beauty" ? displayOf(*image, script.settings.output.toneMap)
                                                   : pictureOf(channel, *image, script.settings));
            }
            progress.update(static_cast<double>(++done) / frames);
        }
        writer.stats(shot, stats);
    }
    return writer.take();
}

}  // namespace voxcone
