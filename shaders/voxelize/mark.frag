// First pass: which voxels does any triangle touch?
#include "voxelize/fragment_input.glsl"
VOXELIZE_VARYINGS(in)
#include "voxelize/clip.glsl"

uniform int u_resolution;
layout(r32ui) uniform writeonly uimage3D u_index;

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy);
    ivec2 depths = depthRange(cell, u_resolution);
    for (int z = depths.x; z <= depths.y; ++z) {
        if (!pieceIn(vec3(cell, z), vec3(cell, z) + 1.0, 6).any) continue;
        ivec3 voxel = ivec3(unpermute(vec3(cell, z), f_axis));
        imageStore(u_index, voxel, uvec4(1u));
    }
}
