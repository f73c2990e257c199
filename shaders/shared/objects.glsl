// Vertex inputs of gl::GpuScene and the transforms of its objects. For vertex shaders.
// "World" here is relative to the scene's origin (GpuScene::setOrigin), so that floats stay precise.
#include "shared/bindings.glsl"

layout(location = POSITION_LOCATION) in vec3 a_position;
layout(location = NORMAL_LOCATION) in vec3 a_normal;
layout(location = TANGENT_LOCATION) in vec4 a_tangent;
layout(location = TEX_COORD_0_LOCATION) in vec2 a_texCoord0;
layout(location = TEX_COORD_1_LOCATION) in vec2 a_texCoord1;
layout(location = COLOR_LOCATION) in vec4 a_color;
layout(location = OBJECT_INDEX_LOCATION) in uint a_objectIndex;

struct Object {
    mat4 worldFromObject;
    mat4 normalFromObject;  // inverse transpose in the upper 3×3
    vec4 mirror;            // x: -1 for a transform that mirrors, else 1; y: mean length in the world of a unit
};
layout(std430, binding = OBJECT_STORAGE) readonly buffer Objects { Object b_objects[]; };

vec3 objectWorldPosition() { return (b_objects[a_objectIndex].worldFromObject * vec4(a_position, 1.0)).xyz; }

// Unit, or zero for a degenerate normal.
vec3 objectWorldNormal() {
    vec3 n = mat3(b_objects[a_objectIndex].normalFromObject) * a_normal;
    float length2 = dot(n, n);
    return length2 > 0.0 ? n * inversesqrt(length2) : vec3(0.0);
}

// xyz unit tangent or zero, w handedness in world space (mirroring flips it).
vec4 objectWorldTangent() {
    vec3 t = mat3(b_objects[a_objectIndex].worldFromObject) * a_tangent.xyz;
    float length2 = dot(t, t);
    return vec4(length2 > 0.0 ? t * inversesqrt(length2) : vec3(0.0), a_tangent.w * b_objects[a_objectIndex].mirror.x);
}

// -1 where the transform mirrors, which swaps front and back faces in the window, else 1.
float objectMirror() { return b_objects[a_objectIndex].mirror.x; }
// Mean length in the world of a unit of the mesh.
float objectScale() { return b_objects[a_objectIndex].mirror.y; }
