// Scene geometry to the G-buffer. Positions are relative to the scene's origin.
#include "shared/objects.glsl"

uniform mat4 u_clipFromWorld;
uniform vec3 u_cameraPosition;
uniform vec2 u_clipRange;  // nearest and farthest distance along the view that is drawn, metres

out vec3 v_fromEye;  // relative to the camera, where floats are finest
out vec3 v_normal;
out vec4 v_tangent;
out vec4 v_texCoord;  // sets 0 and 1
out vec4 v_color;
flat out uint v_object;
flat out float v_scale;

out float gl_ClipDistance[2];

void main() {
    vec3 position = objectWorldPosition();
    v_fromEye = position - u_cameraPosition;
    v_normal = objectWorldNormal();
    v_tangent = objectWorldTangent();
    v_texCoord = vec4(a_texCoord0, a_texCoord1);
    v_color = a_color;
    v_object = a_objectIndex;
    v_scale = objectScale();
    gl_Position = u_clipFromWorld * vec4(position, 1.0);
    // Clip w is the distance along the view.
    gl_ClipDistance[0] = gl_Position.w - u_clipRange.x;
    gl_ClipDistance[1] = u_clipRange.y - gl_Position.w;
}
