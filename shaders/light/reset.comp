// New records have gathered nothing yet.
#include "cascade/buffers.glsl"
layout(local_size_x = 64) in;

uniform uint u_faceCount;
layout(std430, binding = LIST_STORAGE) readonly buffer List { uint b_list[]; };
layout(std430, binding = GATHERED_STORAGE) writeonly buffer Gathered { uvec2 b_gathered[]; };

void main() {
    uint item = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (item < u_faceCount) b_gathered[b_list[item / 6u] * 6u + item % 6u] = uvec2(0u);
}
