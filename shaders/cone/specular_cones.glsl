// The cones of a pixel's specular lobe: of cone/specular.comp, and of whoever asks what they meet. Needs frame/gbuffer.glsl,
// cone/trace.glsl and cone/cone_set.glsl, and the define APERTURE_GGX.
#include "cone/specular_lobe.glsl"

uniform float u_smoothAlpha;  // lobes up to this width take one cone

/// Cones that the surface's lobe takes; 0 when it reflects nothing.
int specularCones(Surface surface) {
    if (maxComponent(surface.f0) <= 0.0 && surface.f90 <= 0.0) return 0;
#if APERTURE_GGX
    return surface.alpha <= u_smoothAlpha ? 1 : CONES;
#else
    return 1;
#endif
}

/// Sets direction, aperture and near field of cone `i` of `count`, and the tangent of the half-angle that it sees the sky with.
/// Answers its weight in the lobe, 0 when it would go below the surface.
float specularCone(GBufferSample s, ivec2 pixel, int i, int count, inout Cone cone, out float skyTanHalfAngle) {
    float alpha = s.surface.alpha, halfAngle, skyHalfAngle, weight = 1.0;
    vec3 direction = reflect(-s.toEye, s.normal);
#if !APERTURE_GGX
    // The thesis, section 3.4.4: 1 to 80 degrees, linear in roughness.
    halfAngle = skyHalfAngle = radians(0.5 * mix(1.0, 80.0, sqrt(alpha)));
    cone.near = nearOfOne(tan(halfAngle));
#else
    if (count == 1) {
        // Half the energy of the reflected directions lies within 2 atan(alpha) of the mirror direction; wide lobes lean
        // to the normal, because what would go below the surface is lost (Lagarde and de Rousiers 2014).
        float lean = (1.0 - alpha) * (sqrt(1.0 - alpha) + alpha);
        direction = normalize(mix(s.normal, direction, lean));
        halfAngle = skyHalfAngle = min(2.0 * atan(alpha), 1.0);
        cone.near = nearOfOne(tan(halfAngle));
    } else {
        mat3 frame = frameAround(s.normal);
        vec3 v = s.toEye * frame;
        v.z = max(v.z, 1e-3);
        vec2 orientation = orientationOf(pixel), place = spiralPlace(i, orientation.x, orientation.y);
        LobeSample lobe = sampleLobe(s.surface, v, place.x, place.y);
        // Neighbours' cones fill the gaps, so each takes half of its share of the lobe. The sky needs no steps and is smooth
        // enough to show the lobe's shape: an eighth.
        float share = lobe.solidAngle / float(CONES);
        direction = frame * lobe.direction;
        halfAngle = coneHalfAngle(0.5 * share);
        skyHalfAngle = coneHalfAngle(0.125 * share);
        weight = max(lobe.weight, 0.0);
        cone.near = u_nearDistance;
    }
#endif
    // Bumps may mirror the eye into the surface.
    float below = dot(direction, cone.normal);
    cone.direction = below < 0.05 ? normalize(direction + cone.normal * (0.05 - below)) : direction;
    cone.tanHalfAngle = tan(halfAngle);
    skyTanHalfAngle = tan(skyHalfAngle);
    return weight;
}
