#include "viewer/tracer.h"

#include <array>
#include <cmath>
#include <utility>

#include "capture/script.h"

namespace voxcone {
namespace {

constexpr std::array kImages = {
    std::pair{&ReferenceImages::beauty, &TracedPicture::beauty},
    std::pair{&ReferenceImages::direct, &TracedPicture::direct},
    std::pair{&ReferenceImages::indirectDiffuse, &TracedPicture::indirectDiffuse},
    std::pair{&ReferenceImages::indirectSpecular, &TracedPicture::indirectSpecular},
    std::pair{&ReferenceImages::transmission, &TracedPicture::transmission},
    std::pair{&ReferenceImages::emission, &TracedPicture::emission},
};

}  // namespace

BackgroundTracer::BackgroundTracer(std::shared_ptr<const Scene> scene, double time, const Camera& worldCamera,
                                   const Settings& settings, int passSamples, std::function<void()> wake)
    : wake_(std::move(wake)) {
    thread_ = std::thread([this, scene = std::move(scene), time, worldCamera, settings, passSamples] {
        run(*scene, time, worldCamera, settings, passSamples);
    });
}

BackgroundTracer::~BackgroundTracer() {
    quit_ = true;
    thread_.join();
}

std::shared_ptr<const TracedPicture> BackgroundTracer::picture() const {
    const std::scoped_lock lock(mutex_);
    return picture_;
}

void BackgroundTracer::run(const Scene& scene, double time, const Camera& camera, Settings settings, int passSamples) {
    const PathTracer tracer(scene, time);
    const int wanted = settings.reference.samples;
    settings.reference.samples = passSamples;
    settings.reference.error = 0;
    TracedPicture sum;
    std::vector<double> squares;
    while (!quit_ && sum.samples < wanted) {
        const ReferenceImages pass = tracer.render(camera, settings);
        ++settings.reference.seed;
        const double n = ++sum.passes;
        sum.samples += pass.samples;
        squares.resize(pass.beauty.data.size());
        // Means and sums of squared deviations, after Welford 1962.
        for (const auto& [from, to] : kImages) {
            const Image& image = pass.*from;
            Image& mean = sum.*to;
            if (mean.data.empty()) mean = Image(image.width, image.height, image.channels);
            for (std::size_t i = 0; i < mean.data.size(); ++i) {
                const double before = static_cast<double>(mean.data[i]), value = static_cast<double>(image.data[i]);
                const double after = before + (value - before) / n;
                if (to == &TracedPicture::beauty) squares[i] += (value - before) * (value - after);
                mean.data[i] = static_cast<float>(after);
            }
        }
        if (sum.passes > 1) {
            double variance = 0, mean = 0;
            for (const double square : squares) variance += square / ((n - 1) * n);
            for (const float value : sum.beauty.data) mean += static_cast<double>(value);
            const auto count = static_cast<double>(squares.size());
            sum.error = mean > 0 ? std::sqrt(variance / count) / (mean / count) : 0;
        }
        {
            const std::scoped_lock lock(mutex_);
            picture_ = std::make_shared<TracedPicture>(sum);
        }
        wake_();
    }
    running_ = false;
    wake_();
}

Camera pixelCamera(const Camera& camera, int width, int height, int x, int y) {
    const glm::dvec3 forward = glm::normalize(camera.target - camera.position);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, camera.up)), up = glm::cross(right, forward);
    const double tanY = std::tan(glm::radians(0.5 * camera.verticalFovDeg)), tanX = tanY * width / height;
    const glm::dvec3 ray =
        forward + ((2 * (x + 0.5) / width - 1) * tanX) * right + ((1 - 2 * (y + 0.5) / height) * tanY) * up;
    Camera pixel = camera;
    pixel.target = camera.position + glm::length(camera.target - camera.position) * ray;
    pixel.up = uprightOf(up, glm::normalize(ray));
    // The pixel's height as it is seen along its ray.
    pixel.verticalFovDeg = glm::degrees(2 * std::atan(tanY / (height * glm::length(ray))));
    return pixel;
}

}  // namespace voxcone
