// World space to voxel units: the grid's lower corner is the scene's origin, so a position over the voxel edge is its
// place in the grid.
#include "shared/objects.glsl"

layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 3) in vec2 a_uv0;
layout(location = 4) in vec2 a_uv1;
layout(location = 5) in vec4 a_color;
layout(location = 6) in uint a_object;

uniform float u_inverseVoxelSize;

out Vertex {
    vec3 voxelPos;
    vec3 normal;
    vec4 uv;
    vec4 color;
    flat float mirrored;  // -1 when the object's transform mirrors: the winding of its front flips
} v;

void main() {
    vec3 worldPos = objectToWorld(a_object, a_position);
    v.voxelPos = worldPos * u_inverseVoxelSize;
    v.normal = objectNormalToWorld(a_object, a_normal);
    v.uv = vec4(a_uv0, a_uv1);
    v.color = a_color;
    v.mirrored = objectMirrored(a_object) ? -1.0 : 1.0;
}
