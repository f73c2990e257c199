// Mean of the specular cones over the orientations of a tile, among neighbours on the same surface whose lobes are much the
// same; times the lobe's directional albedo (split sum): indirect specular radiance towards the eye.
#include "frame/gbuffer.glsl"
#include "cascade/containment.glsl"
#include "cone/neighbours.glsl"
#include "cone/specular_albedo.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform sampler2D u_gathered;
uniform float u_smoothAlpha;
layout(rgba32f) uniform writeonly image2D u_specular;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_specular)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec3 radiance = vec3(0.0);
    if (s.hit) {
        vec4 sum = texelFetch(u_gathered, pixel, 0);
#if CONES > 1 && ROTATE
        if (s.surface.alpha > u_smoothAlpha) {
            sum = vec4(0.0);
            float voxelSize = voxelSizeAt(s.position);
            // As stored, like those of the neighbours.
            vec3 mirror = reflect(normalize(gbufferRay(pixel)), gbufferNormal(pixel));
            for (int i = 0; i < 25; ++i) {
                ivec2 offset = ivec2(i % 5 - 2, i / 5 - 2), tap = pixel + offset;
                float weight = boxWeight(offset) * sameSurface(s, tap, voxelSize);
                if (weight <= 0.0) continue;
                // Lobes overlap: their middles are closer than the half-angle of half their energy, twice over.
                vec3 mirrorThere = reflect(normalize(gbufferRay(tap)), gbufferNormal(tap));
                float lobe = 1.0 - distance(mirrorThere, mirror) / (4.0 * s.surface.alpha);
                float roughness = unpackUnorm2x16(texelFetch(u_gbufferSurface, tap, 0).z).y;
                float alike = 1.0 - 10.0 * abs(roughness / s.roughness - 1.0);
                sum += weight * clamp(lobe, 0.0, 1.0) * clamp(alike, 0.0, 1.0) * texelFetch(u_gathered, tap, 0);
            }
        }
#endif
        if (sum.a > 0.0) radiance = sum.rgb / sum.a * specularAlbedo(s);
    }
    imageStore(u_specular, pixel, vec4(radiance, 1.0));
}
