// Light through the visible surface: src/cone/refraction.h.
#include "frame/gbuffer.glsl"
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
#include "cone/refraction_cones.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform float u_inverseVoxelSize;
layout(rgba32f) uniform writeonly image2D u_transmission;

/// Radiance that a cone gathers, with the sky.
vec3 gather(Cone cone) {
    ConeResult result = traceCone(cone);
    return result.radiance + result.transmittance * skyRadiance(cone.direction, cone.tanHalfAngle);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_transmission)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec3 radiance = vec3(0.0);
    if (s.hit) {
        Cone cone;
#if BEAMS
        if (maxComponent(s.beam) > 0.0) {
            vec3 share = beamCone(s, u_inverseVoxelSize, cone);
            radiance += share * gather(cone);
        }
#endif
#if SCATTERING
        if (maxComponent(s.scattered) > 0.0) {
            vec3 sum = vec3(0.0);
            for (int i = 0; i < CONES; ++i) {
                float weight = scatteredCone(s, u_inverseVoxelSize, i, cone);
                sum += weight * gather(cone);
            }
            radiance += sum * scatteredShare(s);
        }
#endif
    }
    storeSamples();
    imageStore(u_transmission, pixel, vec4(radiance, 1.0));
}
