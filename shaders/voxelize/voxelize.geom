// Projects each triangle along the dominant axis of its normal and covers every pixel that its projection touches. The
// fragment shader clips the exact triangle to each voxel, so the cover may be generous but must never be too small.
layout(triangles) in;
layout(triangle_strip, max_vertices = 4) out;

uniform int u_resolution;
uniform ivec3 u_windowOrigin;       // lower corner of the window
uniform ivec3 u_boxLow, u_boxHigh;  // the region, half open

in Vertex {
    vec3 voxelPos;
    vec3 normal;
    vec4 uv;
    vec4 color;
    flat float mirror;
} v[];

#include "voxelize/fragment_input.glsl"
VOXELIZE_VARYINGS(out)

// Half a pixel reaches exactly the centres of the touched pixels; the rasteriser snaps vertices to 1/256 pixel, and half
// plus 1/500 was measured to be enough: 1/128 leaves room.
const float kEnlarge = 0.5 + 1.0 / 128.0;

// The triangle, permuted, and the axis that went to z.
int g_axis;
vec3 g_p0, g_p1, g_p2;
vec2 g_window;

void emitAt(vec2 q) {
    // Outputs are undefined after EmitVertex, and flat ones come from the last vertex of a triangle: set them every time.
    f_axis = g_axis;
    f_p0 = g_p0, f_p1 = g_p1, f_p2 = g_p2;
    f_n0 = v[0].normal, f_n1 = v[1].normal, f_n2 = v[2].normal;
    f_uv0 = v[0].uv, f_uv1 = v[1].uv, f_uv2 = v[2].uv;
    f_color0 = v[0].color, f_color1 = v[1].color, f_color2 = v[2].color;
    f_mirror = v[0].mirror;
    gl_ViewportIndex = g_axis;  // one scissor an axis
    gl_Position = vec4((q - g_window) * (2.0 / float(u_resolution)) - 1.0, 0.0, 1.0);
    EmitVertex();
}

float supportOfPixel(vec2 direction) { return kEnlarge * (abs(direction.x) + abs(direction.y)); }

void emitRectangle(vec2 q0, vec2 q1, vec2 q2, vec2 along) {
    vec2 across = vec2(-along.y, along.x);
    vec3 s = vec3(dot(q0, along), dot(q1, along), dot(q2, along));
    vec3 t = vec3(dot(q0, across), dot(q1, across), dot(q2, across));
    float s0 = min(s.x, min(s.y, s.z)) - supportOfPixel(along), s1 = max(s.x, max(s.y, s.z)) + supportOfPixel(along);
    float t0 = min(t.x, min(t.y, t.z)) - supportOfPixel(across), t1 = max(t.x, max(t.y, t.z)) + supportOfPixel(across);
    emitAt(along * s0 + across * t0);
    emitAt(along * s1 + across * t0);
    emitAt(along * s0 + across * t1);
    emitAt(along * s1 + across * t1);
    EndPrimitive();
}

void main() {
    vec3 p0 = v[0].voxelPos, p1 = v[1].voxelPos, p2 = v[2].voxelPos;
    vec3 low = min(p0, min(p1, p2)), high = max(p0, max(p1, p2));
    float size = float(u_resolution);
    if (any(lessThan(high, vec3(u_boxLow))) || any(greaterThanEqual(low, vec3(u_boxHigh)))) return;

    vec3 n = cross(p1 - p0, p2 - p0);
    vec3 a = abs(n);
    float largest = max(a.x, max(a.y, a.z));
    if (!(largest > 0.0)) return;  // no area: nothing to store (NaN too)

    // An even permutation that brings the dominant axis to z keeps the winding.
    int axis = a.z == largest ? 2 : (a.x == largest ? 0 : 1);
    if (axis == 0) p0 = p0.yzx, p1 = p1.yzx, p2 = p2.yzx;
    if (axis == 1) p0 = p0.zxy, p1 = p1.zxy, p2 = p2.zxy;

    g_axis = axis;
    g_p0 = p0, g_p1 = p1, g_p2 = p2;
    ivec3 window = u_windowOrigin;
    g_window = vec2(axis == 2 ? window.xy : (axis == 0 ? window.yz : window.zx));

#if !CONSERVATIVE
    emitAt(p0.xy), emitAt(p1.xy), emitAt(p2.xy);
    EndPrimitive();
    return;
#endif

    vec2 q0 = p0.xy, q1 = p1.xy, q2 = p2.xy;
    vec2 boxLow = min(q0, min(q1, q2)), boxHigh = max(q0, max(q1, q2));
    if (any(lessThan(boxLow, g_window - size)) || any(greaterThan(boxHigh, g_window + 2.0 * size))) {
        // Far larger than the window: clipping by the rasteriser would move its edges. Cover its bounds inside it.
        vec2 l = max(boxLow, g_window - 1.0), h = min(boxHigh, g_window + size + 1.0);
        emitRectangle(l, h, l, vec2(1.0, 0.0));
        return;
    }

    // Shift the edges outwards by the support of half a pixel and intersect neighbours.
    float winding = sign((q1.x - q0.x) * (q2.y - q0.y) - (q1.y - q0.y) * (q2.x - q0.x));
    vec2 e0 = q1 - q0, e1 = q2 - q1, e2 = q0 - q2;
    float l0 = length(e0), l1 = length(e1), l2 = length(e2);
    vec2 u0 = e0 / l0, u1 = e1 / l1, u2 = e2 / l2;
    vec2 o0 = winding * vec2(u0.y, -u0.x), o1 = winding * vec2(u1.y, -u1.x), o2 = winding * vec2(u2.y, -u2.x);
    float sine01 = abs(u0.x * u1.y - u0.y * u1.x), sine12 = abs(u1.x * u2.y - u1.y * u2.x),
          sine20 = abs(u2.x * u0.y - u2.y * u0.x);
    // Sharp corners throw the intersection far out, and lose its precision: an oriented rectangle covers those better.
    if (!(min(sine01, min(sine12, sine20)) > 0.2)) {
        vec2 longest = l0 >= l1 && l0 >= l2 ? u0 : (l1 >= l2 ? u1 : u2);
        emitRectangle(q0, q1, q2, longest);
        return;
    }
    float d0 = dot(o0, q0) + supportOfPixel(o0), d1 = dot(o1, q1) + supportOfPixel(o1),
          d2 = dot(o2, q2) + supportOfPixel(o2);
    // Line i is dot(o, x) = d; corner between lines a and b by Cramer's rule.
    #define CORNER(oa, da, ob, db) (vec2((da) * (ob).y - (db) * (oa).y, (db) * (oa).x - (da) * (ob).x) / \
                                    ((oa).x * (ob).y - (oa).y * (ob).x))
    emitAt(CORNER(o2, d2, o0, d0));
    emitAt(CORNER(o0, d0, o1, d1));
    emitAt(CORNER(o1, d1, o2, d2));
    EndPrimitive();
}
