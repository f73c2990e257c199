// Scene into one tile of the shadow atlas.
#include "shared/objects.glsl"
#include "light/shadow_view.glsl"

uniform int u_view;

#if ALPHA_TEST
out Vertex {
    vec2 uv0, uv1;
    vec4 color;
    vec3 normal, fromLight;
    float scale;
} v;
#endif

void main() {
    ShadowView view = b_shadowViews[u_view];
    vec3 offset = objectWorldPosition() - view.origin;
    vec2 plane = view.scale * vec2(dot(offset, view.right), dot(offset, view.up));
    float z = dot(offset, view.forward);
    // Window depth depth.x ∓ depth.y/z or ·z is (clip.z / clip.w + 1) / 2.
    gl_Position = view.perspective > 0.0 ? vec4(plane, (2.0 * view.depth.x - 1.0) * z - 2.0 * view.depth.y, z)
                                         : vec4(plane, 2.0 * (view.depth.x + view.depth.y * z) - 1.0, 1.0);
#if ALPHA_TEST
    v.uv0 = a_texCoord0;
    v.uv1 = a_texCoord1;
    v.color = a_color;
    v.normal = objectWorldNormal();
    v.fromLight = view.perspective > 0.0 ? offset : view.forward;
    v.scale = objectScale();
#endif
}
