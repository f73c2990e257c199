// Diffuse gathering at listed points, as the picture's pixels do it: for tests and for questions about one point.
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
layout(local_size_x = 64) in;

struct Probe {
    vec4 position;  // voxels
    vec4 normal;
};
uniform uint u_probeCount;
uniform int u_turns;  // orientations of the cone set that are averaged
layout(std430, binding = 4) readonly buffer Probes { Probe b_probes[]; };
layout(std430, binding = 5) writeonly buffer Results { vec4 b_results[]; };  // mean radiance, openness

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= u_probeCount) return;
    Cone cone;
    cone.origin = b_probes[index].position.xyz;
    cone.normal = b_probes[index].normal.xyz;
    cone.level = 0.0;
    cone.near = u_nearDistance;
    cone.tanHalfAngle = u_coneTanHalfAngle;
    mat3 frame = frameAround(cone.normal);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < CONES * u_turns; ++i) {
        int turn = i / CONES;
        vec4 local = coneOfSet(i - turn * CONES, turnOf(turn, u_turns), shiftOf(turn, u_turns));
        cone.direction = frame * local.xyz;
        ConeResult result = traceCone(cone);
        sum += local.w * vec4(result.radiance + result.transmittance * skyRadiance(cone.direction, cone.tanHalfAngle),
                              result.openness);
    }
    b_results[index] = sum / float(u_turns);
}
