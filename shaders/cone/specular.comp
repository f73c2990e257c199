// One specular cone a pixel along the mirror direction, weighted by the lobe's directional albedo (split sum).
#include "frame/gbuffer.glsl"
#include "cone/sky.glsl"
#include "cone/trace.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform float u_inverseVoxelSize;
uniform sampler2D u_specularAlbedo;  // (A, B) over (n·v, roughness): f0 A + f90 B
layout(rgba32f) uniform writeonly image2D u_specular;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_specular)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec3 radiance = vec3(0.0);
    if (s.hit) {
        float nDotV = max(dot(s.normal, s.toEye), 1e-3);
        float roughness = sqrt(s.surface.alpha);
        vec2 parts = textureLod(u_specularAlbedo, vec2(nDotV, roughness), 0.0).rg;
        vec3 albedo = s.surface.f0 * parts.x + s.surface.f90 * parts.y;
        if (max(albedo.r, max(albedo.g, albedo.b)) > 0.0) {
            Cone cone;
            cone.origin = s.position * u_inverseVoxelSize;
            cone.normal = s.geometricNormal;
            cone.level = 0.0;
            vec3 mirror = reflect(-s.toEye, s.normal);
#if APERTURE_GGX
            // Half the energy of the lobe of reflected directions lies within 2 atan(alpha) of the mirror direction; wide
            // lobes lean to the normal, because what would go below the surface is lost (Lagarde and de Rousiers 2014).
            float halfAngle = min(2.0 * atan(s.surface.alpha), 1.0);
            float lean = (1.0 - s.surface.alpha) * (sqrt(1.0 - s.surface.alpha) + s.surface.alpha);
            cone.direction = normalize(mix(s.normal, mirror, lean));
#else
            // The thesis, section 3.4.4: 1 to 80 degrees, linear in roughness.
            float halfAngle = radians(0.5 * mix(1.0, 80.0, roughness));
            cone.direction = mirror;
#endif
            // Bumps may mirror the eye into the surface.
            float below = dot(cone.direction, cone.normal);
            if (below < 0.05) cone.direction = normalize(cone.direction + cone.normal * (0.05 - below));
            cone.tanHalfAngle = tan(halfAngle);
            cone.near = nearOfOne(cone.tanHalfAngle);
            ConeResult result = traceCone(cone);
            radiance = albedo * (result.radiance + result.transmittance * skyRadiance(cone.direction, cone.tanHalfAngle));
        }
    }
    imageStore(u_specular, pixel, vec4(radiance, 1.0));
}
