// The first occupied voxel along each pixel's ray (Amanatides and Woo 1987), and what it holds: of its face towards the eye, of
// a given face, or by direction. Levels are marched one after the other, each inside its own box.
#include "cascade/buffers.glsl"
#include "cascade/clipmap.glsl"
#include "cascade/records.glsl"
#include "shared/octahedral.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform usampler3D u_index;
#if LAYERS == 2
uniform usampler3D u_movingIndex;
#endif
uniform int u_what;  // 0 albedo, 1 normal, 2 radiance, 3 opacity, 4 lobes
uniform int u_face;  // of 0 to 3; -1: that towards the eye
uniform int u_firstLevel, u_lastLevel, u_coarsest;  // those that are marched; the last mip
uniform vec3 u_boxLow[16], u_boxHigh[16];  // of every level, in voxels of level 0
uniform float u_inverseVoxelSize;          // of level 0
uniform float u_radianceScale;
uniform vec3 u_cameraPosition;
uniform mat3 u_cameraRays;
uniform vec4 u_cut;     // voxels whose centres lie where dot(u_cut.xyz, x) > u_cut.w (voxels of level 0) are left away
uniform bool u_edges;   // darken the edges of voxels
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = RADIANCE_STORAGE) readonly buffer Radiance { uvec2 b_radiance[]; };
layout(std430, binding = 4) readonly buffer Lobes { uvec2 b_lobes[]; };  // radiance as cones read it: cone/trace.glsl
layout(rgba32f) uniform writeonly image2D u_picture;

float shareOf(uint face) { return unpackHalf2x16(b_radiance[face].y).y; }

vec3 faceValue(uint face) {
    if (u_what == 0) return unpackAlbedo(b_faces[face].albedo);
    if (u_what == 1) return unpackOctahedral(b_faces[face].normal);
    uvec2 stored = b_radiance[face];
    if (u_what == 2) return u_radianceScale * vec3(unpackHalf2x16(stored.x), unpackHalf2x16(stored.y).x);
    return vec3(shareOf(face));
}

/// Radiance that a cone along -n takes of a record: of its fullest face that looks that way, or of all its light at once.
vec3 lobeValue(uint mark, vec3 n) {
    uint slot = mark - 1u;
#if SIX_FACE
    uint face = 0u;
    float most = 0.0;
    for (int k = 0; k < 3; ++k) {
        uint side = slot * 6u + uint(2 * k + (n[k] > 0.0 ? 0 : 1));
        float seen = abs(n[k]) * shareOf(side);
        if (seen > most) face = side, most = seen;
    }
    return most > 0.0 ? u_radianceScale * unpackHalf4(b_radiance[face]).rgb : vec3(0.0);
#elif SH1
    vec4 shown = unpackHalf4(b_lobes[slot * 4u]) + n.x * unpackHalf4(b_lobes[slot * 4u + 1u]) +
                 n.y * unpackHalf4(b_lobes[slot * 4u + 2u]) + n.z * unpackHalf4(b_lobes[slot * 4u + 3u]);
    return shown.a > 0.0 ? u_radianceScale * max(shown.rgb, vec3(0.0)) / shown.a : vec3(0.0);
#else
    return u_radianceScale * unpackHalf4(b_lobes[slot]).rgb;
#endif
}

/// The face of a record that is shown: the side that the ray came in by, unless another that looks to the eye is fuller.
uint faceSeen(uint mark, vec3 d, int axis) {
    if (u_face >= 0) return (mark - 1u) * 6u + uint(u_face);
    uint first = (mark - 1u) * 6u, face = first + uint(2 * axis + (d[axis] > 0.0 ? 1 : 0));
    for (int k = 0; k < 3; ++k) {
        uint other = first + uint(2 * k + (d[k] > 0.0 ? 1 : 0));
        if (shareOf(other) > shareOf(face) + (shareOf(face) > 0.0 ? 0.25 : 0.0)) face = other;
    }
    return face;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_picture)))) return;
    vec3 d = normalize(u_cameraRays * vec3(vec2(pixel) + 0.5, 1.0));
    d = mix(d, vec3(1e-9), equal(d, vec3(0.0)));
    vec3 value = vec3(0.0);
    float done = 0.0;  // distance marched, in voxels of level 0
    bool found = false;
    for (int level = u_firstLevel; level <= u_lastLevel && !found; ++level) {
        float edge = float(1 << level);
        vec3 o = u_cameraPosition * (u_inverseVoxelSize / edge);
        vec3 low = u_boxLow[level] / edge, high = u_boxHigh[level] / edge;
        vec3 a = (low - o) / d, b = (high - o) / d;
        vec3 enter3 = min(a, b), leave3 = max(a, b);
        float leave = min(leave3.x, min(leave3.y, leave3.z));
        float enter = max(max(enter3.x, max(enter3.y, enter3.z)), done / edge);
        if (enter >= leave) continue;
        ivec3 voxel = clamp(ivec3(floor(o + d * enter)), ivec3(floor(low)), ivec3(ceil(high)) - 1);
        ivec3 stepTo = ivec3(sign(d));
        vec3 next = (vec3(voxel) + max(vec3(stepTo), vec3(0.0)) - o) / d, delta = abs(1.0 / d);
        int axis = enter3.x >= enter3.y && enter3.x >= enter3.z ? 0 : (enter3.y >= enter3.z ? 1 : 2);
        float t = enter;
        // Mips hold the last level: where one of their voxels is empty, all within it are, and the ray leaps over them.
        int leap = level < u_levels - 1 ? 0 : min(3, u_coarsest - level);
        ivec3 known = ivec3(1 << 30);  // voxel of that mip, which is not empty
        for (int i = 0; i < 3 * u_resolution && t < leave && !found; ++i) {
            if (any(lessThan(vec3(voxel), floor(low))) || any(greaterThanEqual(vec3(voxel), ceil(high)))) break;
            ivec3 wide = voxel >> leap;
            if (leap > 0 && wide != known) {
                known = wide;
                if (texelFetch(u_index, levelTexel(wide, level + leap), 0).r == 0u) {
                    ivec3 first = wide << leap, last = first + (1 << leap) - 1;
                    vec3 beyond = (vec3(first) + max(vec3(stepTo), vec3(0.0)) * float(1 << leap) - o) / d;
                    axis = beyond.x <= beyond.y && beyond.x <= beyond.z ? 0 : (beyond.y <= beyond.z ? 1 : 2);
                    t = beyond[axis];
                    voxel = clamp(ivec3(floor(o + d * t)), first, last);
                    voxel[axis] = stepTo[axis] > 0 ? last[axis] + 1 : first[axis] - 1;
                    next = (vec3(voxel) + max(vec3(stepTo), vec3(0.0)) - o) / d;
                    continue;
                }
            }
            ivec3 texel = levelTexel(voxel, level);
            uint mark = texelFetch(u_index, texel, 0).r;
#if LAYERS == 2
            uint moving = level < u_levels ? texelFetch(u_movingIndex, texel, 0).r : 0u;
            if (moving != 0u &&
                (mark == 0u || shareOf(faceSeen(moving, d, axis)) > shareOf(faceSeen(mark, d, axis)))) mark = moving;
#endif
            vec3 centre = (vec3(voxel) + 0.5) * edge;
            // The voxel around the eye would hide all others.
            if (mark != 0u && t > 0.0 && dot(u_cut.xyz, centre) <= u_cut.w) {
                value = u_what == 4 ? lobeValue(mark, normalize(o + d * t - vec3(voxel) - 0.5))
                                    : faceValue(faceSeen(mark, d, axis));
                found = true;
                if (u_edges) {
                    vec3 place = fract(o + d * t), aside = min(place, 1.0 - place);
                    aside[axis] = 1.0;
                    float width = 1.5 * t * length(u_cameraRays[1]) / max(length(d), 1e-6);
                    if (min(aside.x, min(aside.y, aside.z)) < min(width, 0.15)) value *= 0.35;
                }
            }
            axis = next.x <= next.y && next.x <= next.z ? 0 : (next.y <= next.z ? 1 : 2);
            t = next[axis];
            voxel[axis] += stepTo[axis];
            next[axis] += delta[axis];
        }
        done = leave * edge;
    }
    imageStore(u_picture, pixel, vec4(value, 1.0));
}
