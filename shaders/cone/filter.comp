// Mean over the orientations of a tile among the neighbours that lie on the same surface, then what the surface makes of
// it: indirect diffuse radiance towards the eye, and openness in a.
#include "frame/gbuffer.glsl"
#include "cascade/containment.glsl"
#include "cone/neighbours.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform sampler2D u_gathered;
layout(rgba32f) uniform writeonly image2D u_diffuse;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_diffuse)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec4 result = vec4(0.0, 0.0, 0.0, 1.0);
    if (s.hit) {
        vec4 own = texelFetch(u_gathered, pixel, 0);
#if ROTATE
        vec4 sum = vec4(0.0);
        float weights = 0.0;
        float voxelSize = voxelSizeAt(s.position);
        vec3 normal = gbufferNormal(pixel);  // as stored, like those of the neighbours
        for (int i = 0; i < 25; ++i) {
            ivec2 offset = ivec2(i % 5 - 2, i / 5 - 2);
            float weight = boxWeight(offset) * sameSurface(s, pixel + offset, voxelSize);
            if (weight <= 0.0) continue;
            // Normals within 25 degrees.
            weight *= clamp((dot(gbufferNormal(pixel + offset), normal) - 0.9) * 10.0, 0.0, 1.0);
            sum += weight * texelFetch(u_gathered, pixel + offset, 0);
            weights += weight;
        }
        vec4 gathered = sum / weights;  // the pixel itself always counts
#else
        vec4 gathered = own;
#endif
        result = vec4(gathered.rgb * s.surface.diffuseColor *
                          diffuseAlbedoScale(s.surface, max(dot(s.normal, s.toEye), 0.0)),
                      clamp(gathered.a, 0.0, 1.0));
    }
    imageStore(u_diffuse, pixel, result);
}
