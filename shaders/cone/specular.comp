// Specular cones of every pixel: sum over the lobe of radiance times weight, and of weights in a. Smooth lobes take one cone,
// rough ones CONES; cone/specular_filter.comp makes the surface's light of them. Without APERTURE_GGX the thesis' one cone.
#include "frame/gbuffer.glsl"
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
#include "cone/specular_cones.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform float u_inverseVoxelSize;
uniform ivec2 u_firstPixel;  // of this dispatch
layout(rgba32f) uniform writeonly image2D u_gathered;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + u_firstPixel;
    if (any(greaterThanEqual(pixel, imageSize(u_gathered)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec4 sum = vec4(0.0);
    if (s.hit) {
        Cone cone;
        cone.origin = s.position * u_inverseVoxelSize;
        cone.normal = s.geometricNormal;
        cone.level = 0.0;
        int count = specularCones(s.surface);
        for (int i = 0; i < count; ++i) {
            float skyTanHalfAngle, weight = specularCone(s, pixel, i, count, cone, skyTanHalfAngle);
            if (weight <= 0.0) continue;
            ConeResult result = traceCone(cone);
            sum += weight * vec4(result.radiance + result.transmittance * skyRadiance(cone.direction, skyTanHalfAngle), 1.0);
        }
    }
    storeSamples();
    imageStore(u_gathered, pixel, sum);
}
