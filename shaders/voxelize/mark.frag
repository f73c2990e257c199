// First pass: which voxels does any triangle touch?
#include "voxelize/fragment_input.glsl"
VOXELIZE_VARYINGS(in)
#include "voxelize/clip.glsl"

uniform int u_resolution;
layout(r32ui) uniform writeonly uimage3D u_index;

void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy);
    Polygon column = Polygon(vec3[](f_p0, f_p1, f_p2, f_p0, f_p0, f_p0, f_p0, f_p0, f_p0), 3);
    for (int plane = 0; plane < 4; ++plane) {
        int axis = plane >> 1;
        bool upper = (plane & 1) != 0;
        clipPolygon(column, axis, float(cell[axis] + int(upper)), upper ? -1.0 : 1.0);
    }
    if (column.count == 0) return;
    ivec2 depths = depthRange(column, u_resolution);
    for (int z = depths.x; z <= depths.y; ++z) {
        Polygon inside = column;
        for (int plane = 0; plane < 2; ++plane) clipPolygon(inside, 2, float(z + plane), plane == 0 ? 1.0 : -1.0);
        if (!insideHalfOpenCell(inside, vec3(cell, z))) continue;
        ivec3 voxel = ivec3(unpermute(vec3(cell, z), f_axis));
        imageStore(u_index, voxel, uvec4(1u));
    }
}
