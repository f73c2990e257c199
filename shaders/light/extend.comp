// Continues the bounces to their limit: adds to what each face has gathered the rest of the geometric series.
#include "cascade/buffers.glsl"
#include "cascade/records.glsl"
#include "shared/rgb9e5.glsl"
layout(local_size_x = 64) in;

uniform uint u_faceCount;  // of the list
layout(std430, binding = LIST_STORAGE) readonly buffer List { uvec2 b_list[]; };
layout(std430, binding = GATHERED_STORAGE) buffer Gathered { uvec2 b_gathered[]; };
#include "light/series.glsl"

void main() {
    uint item = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (item >= u_faceCount) return;
    uint index = b_list[item].x;
    vec3 rest = vec3(b_tail[0], b_tail[1], b_tail[2]) * unpackRgb9e5(b_list[item].y);
    b_gathered[index] = packHalf3(min(unpackHalf3(b_gathered[index]) + rest, vec3(kMostHalf)));
}
