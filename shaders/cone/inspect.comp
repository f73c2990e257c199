// The diffuse cones of one pixel as cone/diffuse.comp traces them, one an invocation, with every sample that they take.
struct Sample {
    vec4 place;     // distance, length, level, transmittance after it
    vec4 radiance;  // so far, W/(m² sr); openness so far
};
layout(std430, binding = 5) writeonly buffer Samples { Sample b_samples[]; };  // SAMPLES a cone
uint g_count = 0u;
#define RECORD(t, length, lod, result) \
    { \
        if (g_count < uint(SAMPLES)) \
            b_samples[gl_GlobalInvocationID.x * uint(SAMPLES) + g_count] = \
                Sample(vec4(t, length, lod, result.transmittance), vec4(u_radianceScale * result.radiance, result.openness)); \
        ++g_count; \
    }
#include "frame/gbuffer.glsl"
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
layout(local_size_x = 32) in;

uniform float u_inverseVoxelSize;
uniform ivec2 u_pixel;
struct InspectedCone {
    vec4 origin;     // voxels of level 0; 1 where the pixel shows a surface
    vec4 direction;  // world space; weight
    vec4 radiance;   // of voxels, W/(m² sr); samples taken
    vec4 sky;        // radiance of the sky over the cone; transmittance
    vec4 surface;    // geometric normal; openness
};
layout(std430, binding = 4) writeonly buffer Results { InspectedCone b_results[]; };

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= CONES) return;
    GBufferSample s = loadGBuffer(u_pixel);
    if (!s.hit) {
        b_results[index].origin = vec4(0.0);
        return;
    }
    Cone cone;
    cone.origin = s.position * u_inverseVoxelSize;
    cone.normal = s.geometricNormal;
    cone.level = 0.0;
    cone.near = u_nearDistance;
    cone.tanHalfAngle = u_coneTanHalfAngle;
#if ROTATE
    // As in cone/diffuse.comp.
    const int kBayer[16] = int[](0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5);
    int k = kBayer[(u_pixel.y & 3) * 4 + (u_pixel.x & 3)];
    float turn = turnOf(k, 16), shift = shiftOf(k, 16);
#else
    float turn = 0.0, shift = 0.0;
#endif
    vec4 local = coneOfSet(index, turn, shift);
    cone.direction = frameAround(s.normal) * local.xyz;
    ConeResult result = traceCone(cone);
    b_results[index] =
        InspectedCone(vec4(cone.origin, 1.0), vec4(cone.direction, local.w), vec4(result.radiance, float(g_count)),
               vec4(skyRadiance(cone.direction, cone.tanHalfAngle), result.transmittance),
               vec4(cone.normal, result.openness));
}
