// What the geometry shader hands to the fragment shaders: the whole triangle, flat, in voxel units with the dominant axis
// permuted to z.
#define VOXELIZE_VARYINGS(QUALIFIER)                  \
    flat QUALIFIER int f_axis;                        \
    flat QUALIFIER vec3 f_p0, f_p1, f_p2;             \
    flat QUALIFIER vec3 f_n0, f_n1, f_n2;             \
    flat QUALIFIER vec4 f_uv0, f_uv1, f_uv2;          \
    flat QUALIFIER vec4 f_color0, f_color1, f_color2; \
    flat QUALIFIER float f_mirror;
