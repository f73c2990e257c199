// The records of one slice of a level: for each voxel 25 words, whether it has one, then albedo, normal and radiance with
// coverage (two half pairs) of its six faces as they are stored.
#include "cascade/buffers.glsl"
#include "cascade/clipmap.glsl"
#include "cascade/records.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform usampler3D u_index;
#if LAYERS == 2
uniform usampler3D u_movingIndex;
#endif
uniform int u_level;
uniform ivec3 u_low;        // voxel at the slice's lower corner
uniform ivec2 u_size;
uniform int u_axis;         // perpendicular to the slice
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = RADIANCE_STORAGE) readonly buffer Radiance { uvec2 b_radiance[]; };
layout(std430, binding = 4) writeonly buffer Slice { uint b_slice[]; };

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, u_size))) return;
    ivec3 voxel = u_low + (u_axis == 0 ? ivec3(0, at.y, at.x) : (u_axis == 1 ? ivec3(at.x, 0, at.y) : ivec3(at.x, at.y, 0)));
    ivec3 texel = levelTexel(voxel, u_level);
    uint mark = texelFetch(u_index, texel, 0).r;
#if LAYERS == 2
    if (mark == 0u && u_level < u_levels) mark = texelFetch(u_movingIndex, texel, 0).r;
#endif
    uint word = uint(at.y * u_size.x + at.x) * 25u;
    b_slice[word] = mark == 0u ? 0u : 1u;
    if (mark == 0u) return;
    for (uint f = 0u; f < 6u; ++f) {
        uint face = (mark - 1u) * 6u + f;
        b_slice[word + 1u + 4u * f] = b_faces[face].albedo;
        b_slice[word + 2u + 4u * f] = b_faces[face].normal;
        b_slice[word + 3u + 4u * f] = b_radiance[face].x;
        b_slice[word + 4u + 4u * f] = b_radiance[face].y;
    }
}
