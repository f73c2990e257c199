// Which level may be read where. Needs the define CASCADES (more than one level).
#include "cascade/clipmap.glsl"

#if CASCADES
// Voxels of level 0.
uniform vec3 u_cascadeCenter;
uniform float u_cascadeRadius;  // half the edge of the cube that level 0 fills
uniform float u_cascadeBand;    // the part of it that blends with the next level
uniform float u_cascadeBlend;   // 1; 0 shows levels end without a blend, to measure the seam
#endif

/// Finest level that may be read at `x`, and as fraction the weight of the next one in the outer band of each level (thesis,
/// eq. 3.2, by the largest component). It depends on where the camera is, not on where the windows have snapped to, and a
/// voxel's content on its index alone: so a window that moves changes nothing that cones see. Twin of
/// src/cascade/clipmap.h.
///
/// x is the level, y the weight of the next one.
vec2 containment(vec3 x) {
#if CASCADES
    vec3 a = abs(x - u_cascadeCenter);
    float distance_ = max(a.x, max(a.y, a.z)) / u_cascadeRadius;
    float last = float(u_levels - 1), level = 0.0, edge = 1.0;
    while (level < last && distance_ > edge) edge *= 2.0, level += 1.0;
    if (level >= last) return vec2(last, 0.0);
    return vec2(level, clamp((distance_ / edge - (1.0 - u_cascadeBand)) / u_cascadeBand, 0.0, 1.0));
#else
    return vec2(0.0);
#endif
}

float containmentLevel(vec3 x) {
    vec2 level = containment(x);
#if CASCADES
    return level.x + u_cascadeBlend * level.y;
#else
    return level.x;
#endif
}
