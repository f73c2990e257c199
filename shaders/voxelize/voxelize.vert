// World space to voxels of a level: the lattice begins at the scene's origin, so a position over the voxel edge is its place
// in it.
#include "shared/objects.glsl"

uniform float u_inverseVoxelSize;

out Vertex {
    vec3 voxelPos;
    vec3 normal;
    vec4 uv;
    vec4 color;
    flat float mirror;  // the object's scale, negative when its transform mirrors: the winding of its front flips
} v;

void main() {
    v.voxelPos = objectWorldPosition() * u_inverseVoxelSize;
    v.normal = objectWorldNormal();
    v.uv = vec4(a_texCoord0, a_texCoord1);
    v.color = a_color;
    v.mirror = objectMirror() * objectScale();
}
