// Mean over the orientations of a tile among the neighbours that lie on the same surface, then what the surface makes of
// it: indirect diffuse radiance towards the eye, and openness in a.
#include "frame/gbuffer.glsl"
#include "cascade/containment.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform sampler2D u_gathered;
uniform float u_voxelSize;  // of level 0
layout(rgba32f) uniform writeonly image2D u_diffuse;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_diffuse)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec4 result = vec4(0.0, 0.0, 0.0, 1.0);
    if (s.hit) {
        vec4 own = texelFetch(u_gathered, pixel, 0);
#if ROTATE
        // A box of 4 x 4 pixels centred on this one: five taps a side, the outer ones of half weight, so that each of the
        // sixteen orientations counts once.
        vec4 sum = vec4(0.0);
        float weights = 0.0;
        float voxelSize = u_voxelSize * exp2(containmentLevel(s.position / u_voxelSize));
        vec3 normal = gbufferNormal(pixel);  // as stored, like those of the neighbours
        ivec2 size = gbufferSize();
        for (int i = 0; i < 25; ++i) {
            ivec2 step_ = ivec2(i % 5 - 2, i / 5 - 2);
            ivec2 tap = pixel + step_;
            if (any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, size))) continue;
            float depth = gbufferViewDepth(tap);
            if (depth <= 0.0) continue;
            vec3 offset = u_cameraPosition + gbufferRay(tap) * depth - s.position;
            // Out of the tangent plane by less than half a voxel (light varies over voxels) or the slope of the pixels
            // between them; normals within 25 degrees.
            float bound = 0.1 * length(offset) + 0.05 * voxelSize;
            float plane = 1.0 - abs(dot(offset, s.geometricNormal)) / bound;
            float facing = (dot(gbufferNormal(tap), normal) - 0.9) * 10.0;
            float near = 1.0 - length(offset) / (4.0 * voxelSize);
            float weight = clamp(plane, 0.0, 1.0) * clamp(facing, 0.0, 1.0) * clamp(near, 0.0, 1.0);
            weight *= (abs(step_.x) == 2 ? 0.5 : 1.0) * (abs(step_.y) == 2 ? 0.5 : 1.0);
            sum += weight * texelFetch(u_gathered, tap, 0);
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
