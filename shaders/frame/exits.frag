// Where light leaves solids that transmit: back faces of their closed bodies, the nearest one along the eye's ray.
#include "shared/material.glsl"
#include "shared/octahedral.glsl"

in vec3 v_fromEye;
in vec3 v_normal;

layout(location = 0) out uvec2 o_exit;  // shading normal (outwards), distance along the view

void main() {
    if (gl_FrontFacing || !u_closed || b_material.transmission.x * b_material.transmission.y <= 0.0) discard;
    vec3 normal = dot(v_normal, v_normal) > 0.0 ? normalize(v_normal) : normalize(v_fromEye);
    o_exit = uvec2(packOctahedral(normal), floatBitsToUint(1.0 / gl_FragCoord.w));
}
