// One level of the coverage volumes from the next finer one.
//
// Both hold optical density per edge of the finest voxel. A surface that crosses a coarse cell fills half of its children,
// so its coverage of the coarse face is twice their mean; over an edge twice as long the density is the mean itself. It is
// clamped where the surfaces of a cell hide each other: at coverage 1, which is a density of 2^-level.
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;

uniform sampler3D u_finer;
uniform int u_finerLevel;
layout(rgba16) uniform writeonly image3D u_coarser;

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, imageSize(u_coarser)))) return;
    vec4 sum = vec4(0.0);
    for (int child = 0; child < 8; ++child)
        sum += texelFetch(u_finer, 2 * cell + ivec3(child & 1, (child >> 1) & 1, child >> 2), u_finerLevel);
    imageStore(u_coarser, cell, min(0.125 * sum, vec4(exp2(-float(u_finerLevel + 1)))));
}
