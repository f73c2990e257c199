// The direct channel of the renderer against that of the path tracer: same scene, camera, lights and BRDF.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "frame/gbuffer.h"
#include "gl/bindings.h"
#include "light/direct.h"
#include "reference/path_tracer.h"
#include "support/gl_context.h"
#include "support/shapes.h"

namespace voxcone {
namespace {

using glm::dvec3;
using test::GlTest;

constexpr int kWidth = 96, kHeight = 72;

Image drawDirect(const Scene& scene, const Camera& camera) {
    const gl::ShaderLibrary shaders;
    gl::PassTimers timers(gl::TimerMode::finish);
    gl::GpuScene gpuScene(scene);
    gpuScene.setOrigin(gpuScene.bounds().min);
    GBuffer gbuffer(shaders, gpuScene, kWidth, kHeight);
    gbuffer.draw(gpuScene, cameraView(camera, gpuScene.origin(), gpuScene.bounds(), kWidth, kHeight), timers);
    ShadowMaps maps(test::glContext(), shaders, Settings::Light{});
    maps.update(gpuScene, timers);
    DirectPass direct(shaders, gbuffer.defines(), kWidth, kHeight);
    direct.run(
        maps, [&](gl::Program& program) { gbuffer.bind(program, gl::kPassTextureUnit); }, timers);
    return imageFromTexture(direct.texture(), 3);
}

struct Difference {
    double bias, median, p90;  ///< relative to the mean of the reference
};

/// Direct light of `light` over a floor with a box and a ball of roughness `roughness`.
Difference compare(const Light& light, float roughness) {
    Material white = test::lambert(0.7f);
    const Scene scene = test::SceneBuilder()
                            .add(test::quad(6, 6), white)
                            .add(test::box(dvec3(1)), white, test::translation({-0.9, 0.5, -0.3}))
                            .add(test::sphere(0.6, 4), test::glossy({0.8f, 0.5f, 0.2f}, 0.5f, roughness),
                                 test::translation({0.7, 0.6, 0.2}))
                            .light(light)
                            .build();
    const Camera camera = test::camera({1, 2.2, 4}, {0, 0.4, 0});
    const Image mine = drawDirect(scene, camera);
    Settings settings;
    settings.output.width = kWidth;
    settings.output.height = kHeight;
    settings.reference.samples = 64;
    settings.reference.maxDepth = 1;
    const Image truth = PathTracer(scene).render(camera, settings).direct;
    std::vector<double> errors;
    double sum = 0, bias = 0;
    for (std::size_t i = 0; i < truth.data.size(); ++i) {
        const double error = static_cast<double>(mine.data[i]) - static_cast<double>(truth.data[i]);
        errors.push_back(std::abs(error));
        bias += error;
        sum += static_cast<double>(truth.data[i]);
    }
    std::sort(errors.begin(), errors.end());
    const double mean = sum / static_cast<double>(errors.size());
    return {bias / sum, errors[errors.size() / 2] / mean, errors[errors.size() * 9 / 10] / mean};
}

Light at(LightType type, float intensity) {
    Light light;
    light.type = type;
    light.position = {-1.5, 3, 1.5};
    light.direction = glm::normalize(-light.position);
    light.intensity = glm::vec3(intensity);
    return light;
}

class LightPicture : public GlTest {};

TEST_F(LightPicture, PunctualLightsAgreeButForEdges) {
    Light spot = at(LightType::spot, 20);
    spot.innerConeAngle = 0.3;
    spot.outerConeAngle = 0.6;
    for (const Light& light : {at(LightType::directional, 2), at(LightType::point, 20), spot}) {
        const Difference d = compare(light, 0.5f);
        EXPECT_LT(std::abs(d.bias), 0.01) << static_cast<int>(light.type);
        EXPECT_LT(d.median, 1e-4) << static_cast<int>(light.type);
        EXPECT_LT(d.p90, 2e-3) << static_cast<int>(light.type);
    }
}

TEST_F(LightPicture, AreaLightsAgree) {
    Light sphere = at(LightType::sphere, 20);
    sphere.radius = 0.3;
    Light panel = at(LightType::rectangle, 20);
    panel.up = glm::normalize(glm::cross(panel.direction, dvec3(0, 0, 1)));
    panel.width = 1;
    panel.height = 0.6;
    for (const Light& light : {sphere, panel}) {
        for (const float roughness : {0.6f, 0.3f}) {
            const Difference d = compare(light, roughness);
            EXPECT_LT(std::abs(d.bias), 0.015) << static_cast<int>(light.type) << " roughness " << roughness;
            EXPECT_LT(d.median, 0.01) << static_cast<int>(light.type) << " roughness " << roughness;
            EXPECT_LT(d.p90, 0.1) << static_cast<int>(light.type) << " roughness " << roughness;
        }
    }
}

}  // namespace
}  // namespace voxcone
