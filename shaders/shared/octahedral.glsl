// Unit vectors on the octahedron (Cigolle et al. 2014). Twin of src/core/octahedral.h.
#ifndef VOXCONE_OCTAHEDRAL_GLSL
#define VOXCONE_OCTAHEDRAL_GLSL

/// In [-1,1]².
vec2 octahedralFromUnit(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z >= 0.0 ? p : folded;
}

vec3 unitFromOctahedral(vec2 p) {
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    float fold = max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -fold : fold;
    n.y += n.y >= 0.0 ? -fold : fold;
    return normalize(n);
}

/// 16-bit snorm each: at most 6e-5 radians off.
uint packOctahedral(vec3 n) { return packSnorm2x16(octahedralFromUnit(n)); }
vec3 unpackOctahedral(uint bits) { return unitFromOctahedral(unpackSnorm2x16(bits)); }

#endif
