// The first occupied voxel along each pixel's ray (Amanatides and Woo 1987), and what its face towards the eye holds.
#include "voxelize/buffers.glsl"
#include "voxelize/records.glsl"
#include "shared/octahedral.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform usampler3D u_index;
uniform int u_what;  // 0 albedo, 1 normal, 2 radiance, 3 opacity
uniform int u_resolution;
uniform float u_inverseVoxelSize;
uniform vec3 u_cameraPosition;
uniform mat3 u_cameraRays;
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = RADIANCE_STORAGE) readonly buffer Radiance { vec4 b_radiance[]; };
layout(rgba32f) uniform writeonly image2D u_picture;

vec3 faceValue(uint face) {
    if (u_what == 0) return unpackAlbedo(b_faces[face].albedo);
    if (u_what == 1) return unpackOctahedral(b_faces[face].normal);
    if (u_what == 2) return b_radiance[face].rgb;
    return vec3(b_radiance[face].a);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_picture)))) return;
    vec3 d = normalize(u_cameraRays * vec3(vec2(pixel) + 0.5, 1.0));
    d = mix(d, vec3(1e-9), equal(d, vec3(0.0)));
    vec3 o = u_cameraPosition * u_inverseVoxelSize;
    vec3 a = -o / d, b = (float(u_resolution) - o) / d;
    vec3 enter3 = min(a, b), leave3 = max(a, b);
    float enter = max(max(enter3.x, enter3.y), max(enter3.z, 0.0)), leave = min(leave3.x, min(leave3.y, leave3.z));
    vec3 value = vec3(0.0);
    if (enter < leave) {
        vec3 start = o + d * enter;
        ivec3 voxel = clamp(ivec3(floor(start)), ivec3(0), ivec3(u_resolution - 1));
        ivec3 stepTo = ivec3(sign(d));
        vec3 next = (vec3(voxel) + max(vec3(stepTo), vec3(0.0)) - o) / d, delta = abs(1.0 / d);
        vec3 entered = enter3;
        for (int i = 0; i < 3 * u_resolution; ++i) {
            uint mark = texelFetch(u_index, voxel, 0).r;
            if (mark != 0u) {
                // The side that the ray came in by, or else the fullest of those that look to the eye.
                int axis = entered.x >= entered.y && entered.x >= entered.z ? 0 : (entered.y >= entered.z ? 1 : 2);
                uint first = (mark - 1u) * 6u;
                uint face = first + uint(2 * axis + (d[axis] > 0.0 ? 1 : 0));
                for (int k = 0; k < 3; ++k) {
                    uint other = first + uint(2 * k + (d[k] > 0.0 ? 1 : 0));
                    if (b_radiance[other].a > b_radiance[face].a + 0.25) face = other;
                }
                value = faceValue(face);
                break;
            }
            entered = vec3(-1e30);
            if (next.x <= next.y && next.x <= next.z) voxel.x += stepTo.x, entered.x = next.x, next.x += delta.x;
            else if (next.y <= next.z) voxel.y += stepTo.y, entered.y = next.y, next.y += delta.y;
            else voxel.z += stepTo.z, entered.z = next.z, next.z += delta.z;
            if (any(lessThan(voxel, ivec3(0))) || any(greaterThanEqual(voxel, ivec3(u_resolution)))) break;
        }
    }
    imageStore(u_picture, pixel, vec4(value, 1.0));
}
