// Direct light and emission of the voxel faces that hold a surface: outgoing radiance of their Lambert stand-in.
#include "cascade/buffers.glsl"
#include "cascade/clipmap.glsl"
#include "cascade/records.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#if LIGHTS
#include "light/lights.glsl"
#endif
layout(local_size_x = 64) in;

uniform uint u_firstFace, u_endFace;  // of this dispatch; six a record
uniform bool u_listed;          // the records of the list; else the first ones
uniform float u_voxelSize;      // of level 0
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
layout(std430, binding = LIST_STORAGE) readonly buffer List { uint b_list[]; };
layout(std430, binding = PLACE_STORAGE) readonly buffer Places { uint b_places[]; };
layout(std430, binding = FACE_STORAGE) readonly buffer Faces { FaceRecord b_faces[]; };
layout(std430, binding = DIRECT_STORAGE) writeonly buffer Direct { uint b_direct[]; };
#if EMISSION
layout(std430, binding = EMISSION_STORAGE) readonly buffer Emission { uint b_emission[]; };
#endif

void main() {
    uint item = gl_WorkGroupID.y * gl_NumWorkGroups.x * 64u + gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;
    item += u_firstFace;
    if (item >= u_endFace) return;
    uint slot = item / 6u;
    if (u_listed) slot = b_list[slot];
    uint place = b_places[slot], index = slot * 6u + item % 6u;
    int level = placeLevel(place);
    // Mips take the light of their children.
    if (!placeInUse(place) || level >= u_levels) return;
    FaceRecord face = b_faces[index];
    vec3 radiance = vec3(0.0);
    if (faceHoldsSurface(face)) {
#if EMISSION
        radiance = unpackRgb9e5(b_emission[index]);
#endif
#if LIGHTS
        ivec3 voxel = fromToroidal(placeTexel(place), level);
        float edge = u_voxelSize * float(1 << level);
        vec3 worldPos = (vec3(voxel) + unpackPosition(face.position)) * edge;
        vec3 normal = unpackOctahedral(face.normal);
        // A record is the mean of what lies in its voxel: half an edge is how far a bent surface is from it.
        radiance += unpackAlbedo(face.albedo) * directIrradiance(worldPos, normal, 0.5 * edge) * 0.318309886;
#endif
        if (any(greaterThan(radiance, vec3(kMaxRgb9e5)))) atomicAdd(b_clamped, 1u);
    }
    b_direct[index] = packRgb9e5(radiance);
}
