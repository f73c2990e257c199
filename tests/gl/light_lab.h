// Asks the device for direct light at points of a scene: what the light tests compare with closed forms.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "gl/gpu_scene.h"
#include "gl/shader_library.h"
#include "light/shadow_maps.h"
#include "scene/scene.h"
#include "support/gl_context.h"

namespace voxcone::test {

/// A point of a surface, positions in world space.
struct Receiver {
    glm::dvec3 position;
    glm::vec3 normal;
};

/// A scene with its shadow maps, and compute shaders that evaluate shaders/light/lights.glsl at given points.
class LightLab {
  public:
    explicit LightLab(const Scene& scene, const glm::dvec3& origin = glm::dvec3(0),
                      const Settings::Light& settings = {})
        : scene_(scene), gpuScene_(scene_), maps_(glContext(), shaders(), settings) {
        gpuScene_.setOrigin(origin);
        gl::PassTimers timers(gl::TimerMode::finish);
        maps_.update(gpuScene_, timers);
    }

    /// directIrradiance of lights.glsl, W/m².
    std::vector<glm::vec3> irradiance(const std::vector<Receiver>& receivers, float slack = 0) {
        static gl::Program program = compile("directIrradiance(position, normal, u_slack)");
        program.set("u_slack", slack);
        return run(program, receivers);
    }
    /// unshadowedIrradiance of light 0.
    std::vector<glm::vec3> unshadowed(const std::vector<Receiver>& receivers) {
        static gl::Program program = compile("unshadowedIrradiance(b_lights[0], position, normal)");
        return run(program, receivers);
    }
    /// Irradiance with shadows over the one without: the visible part of the lights.
    std::vector<double> visibility(const std::vector<Receiver>& receivers) {
        const std::vector<glm::vec3> lit = irradiance(receivers), bare = unshadowed(receivers);
        std::vector<double> parts;
        for (std::size_t i = 0; i < lit.size(); ++i) parts.push_back(lit[i].x / bare[i].x);
        return parts;
    }

    const ShadowMaps& maps() const { return maps_; }
    ShadowMaps& maps() { return maps_; }
    gl::GpuScene& gpuScene() { return gpuScene_; }

  private:
    static const gl::ShaderLibrary& shaders() {
        static const gl::ShaderLibrary library;
        return library;
    }

    static gl::Program compile(const std::string& expression) {
        return shaders().computeFromText("light_lab.comp", R"(
            layout(local_size_x = 64) in;
            #include "light/lights.glsl"
            struct Receiver { vec4 position, normal; };
            layout(std430, binding = 5) readonly buffer Receivers { Receiver b_receivers[]; };
            layout(std430, binding = 6) writeonly buffer Answers { vec4 b_answers[]; };
            uniform int u_count;
            uniform float u_slack;
            void main() {
                uint i = gl_GlobalInvocationID.x;
                if (i >= uint(u_count)) return;
                vec3 position = b_receivers[i].position.xyz, normal = b_receivers[i].normal.xyz;
                b_answers[i] = vec4()" + expression + R"(, 0.0);
            })");
    }

    std::vector<glm::vec3> run(gl::Program& program, const std::vector<Receiver>& receivers) {
        std::vector<glm::vec4> packed;
        for (const Receiver& r : receivers) {
            packed.emplace_back(glm::vec3(r.position - gpuScene_.origin()), 1);
            packed.emplace_back(glm::normalize(r.normal), 0);
        }
        const gl::Buffer in = gl::Buffer::of(packed), out(receivers.size() * sizeof(glm::vec4));
        in.bindBase(GL_SHADER_STORAGE_BUFFER, 5);
        out.bindBase(GL_SHADER_STORAGE_BUFFER, 6);
        maps_.bind(program);
        program.set("u_count", static_cast<int>(receivers.size()));
        gl::dispatch(program, gl::groupsFor(static_cast<int>(receivers.size()), 64), 1, 1);
        gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        std::vector<glm::vec3> answers;
        for (const glm::vec4& v : out.read<glm::vec4>()) answers.emplace_back(v);
        return answers;
    }

    Scene scene_;
    gl::GpuScene gpuScene_;
    ShadowMaps maps_;
};

}  // namespace voxcone::test
