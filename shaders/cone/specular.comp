// Specular cones of every pixel: sum over the lobe of radiance times weight, and of weights in a. Smooth lobes take one cone,
// rough ones CONES; cone/specular_filter.comp makes the surface's light of them. Without APERTURE_GGX the thesis' one cone.
#include "frame/gbuffer.glsl"
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
#include "cone/specular_lobe.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform float u_inverseVoxelSize;
uniform float u_smoothAlpha;  // lobes up to this width take one cone
uniform ivec2 u_firstPixel;  // of this dispatch
layout(rgba32f) uniform writeonly image2D u_gathered;

vec3 gatherCone(Cone cone, vec3 direction, float halfAngle, float skyHalfAngle) {
    // Bumps may mirror the eye into the surface.
    float below = dot(direction, cone.normal);
    cone.direction = below < 0.05 ? normalize(direction + cone.normal * (0.05 - below)) : direction;
    cone.tanHalfAngle = tan(halfAngle);
    ConeResult result = traceCone(cone);
    return result.radiance + result.transmittance * skyRadiance(cone.direction, tan(skyHalfAngle));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + u_firstPixel;
    if (any(greaterThanEqual(pixel, imageSize(u_gathered)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec4 sum = vec4(0.0);
    if (s.hit && (maxComponent(s.surface.f0) > 0.0 || s.surface.f90 > 0.0)) {
        Cone cone;
        cone.origin = s.position * u_inverseVoxelSize;
        cone.normal = s.geometricNormal;
        cone.level = 0.0;
        float alpha = s.surface.alpha;
        vec3 mirror = reflect(-s.toEye, s.normal);
#if !APERTURE_GGX
        // The thesis, section 3.4.4: 1 to 80 degrees, linear in roughness.
        float halfAngle = radians(0.5 * mix(1.0, 80.0, sqrt(alpha)));
        cone.near = nearOfOne(tan(halfAngle));
        sum = vec4(gatherCone(cone, mirror, halfAngle, halfAngle), 1.0);
#else
        if (CONES == 1 || alpha <= u_smoothAlpha) {
            // Half the energy of the reflected directions lies within 2 atan(alpha) of the mirror direction; wide lobes lean
            // to the normal, because what would go below the surface is lost (Lagarde and de Rousiers 2014).
            float lean = (1.0 - alpha) * (sqrt(1.0 - alpha) + alpha);
            float halfAngle = min(2.0 * atan(alpha), 1.0);
            cone.near = nearOfOne(tan(halfAngle));
            sum = vec4(gatherCone(cone, normalize(mix(s.normal, mirror, lean)), halfAngle, halfAngle), 1.0);
        } else {
            mat3 frame = frameAround(s.normal);
            vec3 v = s.toEye * frame;
            v.z = max(v.z, 1e-3);
#if ROTATE
            // As in cone/diffuse.comp.
            const int kBayer[16] = int[](0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5);
            int k = kBayer[(pixel.y & 3) * 4 + (pixel.x & 3)];
            float turn = turnOf(k, 16), shift = shiftOf(k, 16);
#else
            float turn = 0.0, shift = 0.0;
#endif
            cone.near = u_nearDistance;
            for (int i = 0; i < CONES; ++i) {
                vec2 place = spiralPlace(i, turn, shift);
                LobeSample lobe = sampleLobe(s.surface, v, place.x, place.y);
                if (lobe.weight <= 0.0) continue;
                // Neighbours' cones fill the gaps, so each takes half of its share of the lobe. The sky needs no steps and
                // is smooth enough to show the lobe's shape: an eighth.
                float share = lobe.solidAngle / float(CONES);
                vec3 radiance = gatherCone(cone, frame * lobe.direction, coneHalfAngle(0.5 * share), coneHalfAngle(0.125 * share));
                sum += lobe.weight * vec4(radiance, 1.0);
            }
        }
#endif
    }
    storeSamples();
    imageStore(u_gathered, pixel, sum);
}
