// First pass: which voxels of a region does any triangle touch?
#include "voxelize/fragment_input.glsl"
VOXELIZE_VARYINGS(in)
#include "voxelize/region.glsl"
#include "cascade/records.glsl"

layout(r32ui) uniform writeonly uimage3D u_index;

void main() {
    ivec2 cell = cellOfFragment();
    ivec2 depths = depthRange(cell);
    for (int z = depths.x; z <= depths.y; ++z) {
        if (!pieceIn(vec3(cell, z), vec3(cell, z) + 1.0, 6).any) continue;
        ivec3 voxel = ivec3(unpermute(vec3(cell, z), f_axis));
        imageStore(u_index, levelTexel(voxel, u_level), uvec4(kTouched));
    }
}
