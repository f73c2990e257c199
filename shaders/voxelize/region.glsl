// The region that a draw voxelizes: a box of voxels of one level, inside the level's window. Pixels are the voxels of the
// window, seen along the axis that went to z; the scissor of that axis keeps fragments inside the box.
#include "cascade/clipmap.glsl"
#include "voxelize/clip.glsl"

uniform int u_level;
uniform ivec3 u_windowOrigin;       // lower corner of the window
uniform ivec3 u_boxLow, u_boxHigh;  // half open

ivec3 permuted(ivec3 p, int axis) { return axis == 2 ? p : (axis == 0 ? p.yzx : p.zxy); }

/// Cell of the level, permuted, that this fragment stands for.
ivec2 cellOfFragment() { return ivec2(gl_FragCoord.xy) + permuted(u_windowOrigin, f_axis).xy; }

/// First and last cell along z that the triangle reaches over the pixel (x, y) inside the box; first > last when it misses
/// the pixel. Not from the triangle's plane: the normal of a sliver is too uncertain to tell its depth some voxels on.
ivec2 depthRange(ivec2 cell) {
    Piece column = pieceIn(vec3(cell, -1e30), vec3(cell + 1, 1e30), 4);
    if (!column.any) return ivec2(0, -1);
    float low = float(permuted(u_boxLow, f_axis).z), high = float(permuted(u_boxHigh, f_axis).z - 1);
    return ivec2(floor(vec2(max(column.low.z, low), min(column.high.z, high))));
}
