// Clipmap arithmetic. Twin of src/cascade/clipmap.h, where the terms are explained.

uniform int u_resolution;  // of a level
uniform int u_levels;      // clipmap levels; coarser ones are mips of the last
uniform int u_firstFixed;  // levels and mips from here on stay where they are, and do not wrap around
uniform int u_rows;        // levels stacked along z in a volume; what is beyond lies in a second column along y
uniform ivec3 u_windowLow[16];  // lower corner of the window of every level and mip

int levelResolution(int level) { return level < u_levels ? u_resolution : u_resolution >> (level - u_levels + 1); }

/// First texel inside the border of a level's box in a volume.
ivec3 levelOrigin(int level, int border) {
    int box = u_resolution + 2 * border;
    if (level < u_levels)
        return ivec3(border) + ivec3(0, level < u_rows ? 0 : box, (level < u_rows ? level : level - u_rows) * box);
    int mip = level - u_levels + 1;
    if (mip == 1) return ivec3(border) + ivec3(0, 0, u_rows * box);
    return ivec3(border) + ivec3(u_resolution / 2 + 2 * border,
                                 u_resolution / 2 - (u_resolution >> (mip - 1)) + 2 * border * (mip - 2), u_rows * box);
}

/// Texel of voxel `i` in a volume without borders.
ivec3 levelTexel(ivec3 i, int level) { return levelOrigin(level, 0) + (i & (levelResolution(level) - 1)); }

/// The voxel of a level's window that lies at texel `t` of the level's box.
ivec3 fromToroidal(ivec3 t, int level) {
    ivec3 low = u_windowLow[level];
    return low + ((t - low) & (levelResolution(level) - 1));
}
