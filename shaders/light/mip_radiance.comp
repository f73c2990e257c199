// One level of the radiance volume from the next finer one.
//
// SIX_FACE: faces are stacked along z; texels are radiance times coverage density, so the clamp of the coverage (see
// voxelize/mip_coverage.comp) scales them alike. Isotropic: radiance times opacity, and opacity, plainly averaged.
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;

uniform sampler3D u_finer;
uniform int u_finerLevel;
layout(rgba16f) uniform writeonly image3D u_coarser;
#if SIX_FACE
uniform sampler3D u_coveragePositive;
uniform sampler3D u_coverageNegative;
#endif

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    ivec3 size = imageSize(u_coarser);
    if (any(greaterThanEqual(cell, size))) return;
    vec4 sum = vec4(0.0);
    float coverage = 0.0;
#if SIX_FACE
    int resolution = size.x, face = cell.z / resolution;
    ivec3 firstChild = 2 * ivec3(cell.xy, cell.z - face * resolution);
#endif
    for (int child = 0; child < 8; ++child) {
        ivec3 step_ = ivec3(child & 1, (child >> 1) & 1, child >> 2);
        sum += texelFetch(u_finer, 2 * cell + step_, u_finerLevel);
#if SIX_FACE
        vec4 density = (face & 1) == 0 ? texelFetch(u_coveragePositive, firstChild + step_, u_finerLevel)
                                       : texelFetch(u_coverageNegative, firstChild + step_, u_finerLevel);
        coverage += density[face >> 1];
#endif
    }
    vec4 mean = 0.125 * sum;
#if SIX_FACE
    float most = exp2(-float(u_finerLevel + 1));
    coverage *= 0.125;
    if (coverage > most) mean *= most / coverage;
#endif
    imageStore(u_coarser, cell, mean);
}
