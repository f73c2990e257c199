// New records have neither been lit nor gathered anything yet.
#include "cascade/buffers.glsl"
layout(local_size_x = 64) in;

uniform uint u_faceCount;
layout(std430, binding = LIST_STORAGE) readonly buffer List { uint b_list[]; };
layout(std430, binding = GATHERED_STORAGE) writeonly buffer Gathered { uvec2 b_gathered[]; };
layout(std430, binding = DIRECT_STORAGE) writeonly buffer Direct { uint b_direct[]; };

void main() {
    uint item = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    if (item >= u_faceCount) return;
    uint index = b_list[item / 6u] * 6u + item % 6u;
    b_gathered[index] = uvec2(0u);
    b_direct[index] = 0u;
}
