// The cones of one lobe of one pixel as the picture traces them, one an invocation, with every sample that they take. LOBE as
// ConeLobe in src/cone/inspect.h.
#define DIFFUSE 0
#define SPECULAR 1
#define BEAM 2
#define SCATTERED 3
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
#include "cone/specular_albedo.glsl"
#if LOBE == SPECULAR
#include "cone/specular_cones.glsl"
#elif LOBE == BEAM || LOBE == SCATTERED
#include "cone/refraction_cones.glsl"
#endif
layout(local_size_x = 32) in;

uniform float u_inverseVoxelSize;
uniform ivec2 u_pixel;
struct InspectedCone {
    vec4 surface;    // position, voxels of level 0
    vec4 normal;     // geometric; tangent of the cone's half-angle
    vec4 share;      // of the lobe's light that leaves towards the eye, by channel; openness
    vec4 origin;     // of the cone, voxels of level 0; weight in the lobe, 0: there is no such cone
    vec4 direction;  // world space; samples taken
    vec4 radiance;   // of voxels, W/(m² sr); tangent of the half-angle that the sky is seen with
    vec4 sky;        // radiance of the sky over the cone; transmittance
};
layout(std430, binding = 4) writeonly buffer Results { InspectedCone b_results[]; };  // INVOCATIONS

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= INVOCATIONS) return;
    GBufferSample s = loadGBuffer(u_pixel);
    InspectedCone seen;
    seen.surface = vec4(s.position * u_inverseVoxelSize, 1.0);
    seen.origin = vec4(0.0);
    Cone cone;
    cone.origin = s.position * u_inverseVoxelSize;
    cone.normal = s.geometricNormal;
    cone.level = 0.0;
    float weight = 0.0;
    vec3 share = vec3(0.0);
    float skyTanHalfAngle = u_coneTanHalfAngle;
    if (s.hit) {
#if LOBE == DIFFUSE
        cone.near = u_nearDistance;
        cone.tanHalfAngle = u_coneTanHalfAngle;
        vec2 orientation = orientationOf(u_pixel);
        vec4 local = coneOfSet(index, orientation.x, orientation.y);
        cone.direction = frameAround(s.normal) * local.xyz;
        weight = local.w;
        share = s.surface.diffuseColor * diffuseAlbedoScale(s.surface, max(dot(s.normal, s.toEye), 0.0));
#elif LOBE == SPECULAR
        int count = specularCones(s.surface);
        if (index < count) weight = specularCone(s, u_pixel, index, count, cone, skyTanHalfAngle);
        share = specularAlbedo(s);
#elif LOBE == BEAM
        if (maxComponent(s.beam) > 0.0) {
            share = beamCone(s, u_inverseVoxelSize, cone);
            weight = 1.0;
            skyTanHalfAngle = cone.tanHalfAngle;
        }
#else
        if (maxComponent(s.scattered) > 0.0) {
            weight = scatteredCone(s, u_inverseVoxelSize, index, cone);
            share = scatteredShare(s);
        }
#endif
    }
    if (weight > 0.0) {
        ConeResult result = traceCone(cone);
        seen.normal = vec4(s.geometricNormal, cone.tanHalfAngle);
        seen.share = vec4(share, result.openness);
        seen.origin = vec4(cone.origin, weight);
        seen.direction = vec4(cone.direction, float(g_count));
        seen.radiance = vec4(result.radiance, skyTanHalfAngle);
        seen.sky = vec4(skyRadiance(cone.direction, skyTanHalfAngle), result.transmittance);
    }
    b_results[index] = seen;
}
