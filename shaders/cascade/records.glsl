// The records of occupied voxels. Twin of src/cascade/records.h.
//
// Faces of a voxel: 0 +x, 1 -x, 2 +y, 3 -y, 4 +z, 5 -z, named by the side that the surface looks to.

/// A face of a resolved voxel; emission is kept apart, for scenes that have some.
struct FaceRecord {
    uint albedo;    // unorm 11:11:10
    uint normal;    // octahedral, snorm 16:16
    uint position;  // place in the voxel, unorm 10:10:10; bit 31: the face holds a surface
};

uint packAlbedo(vec3 a) {
    uvec3 q = uvec3(clamp(a, 0.0, 1.0) * vec3(2047.0, 2047.0, 1023.0) + 0.5);
    return q.x | (q.y << 11) | (q.z << 22);
}
vec3 unpackAlbedo(uint p) { return vec3(p & 2047u, (p >> 11) & 2047u, p >> 22) / vec3(2047.0, 2047.0, 1023.0); }

uint packPosition(vec3 p) {
    uvec3 q = uvec3(clamp(p, 0.0, 1.0) * 1023.0 + 0.5);
    return q.x | (q.y << 10) | (q.z << 20) | 0x80000000u;
}
vec3 unpackPosition(uint p) { return vec3(p & 1023u, (p >> 10) & 1023u, (p >> 20) & 1023u) / 1023.0; }
bool faceHoldsSurface(FaceRecord face) { return (face.position & 0x80000000u) != 0u; }

// Coverages of three faces, unorm 10:10:10: what the volumes hold.
uint packCoverage(vec3 c) {
    uvec3 q = uvec3(clamp(c, 0.0, 1.0) * 1023.0 + 0.5);
    return q.x | (q.y << 10) | (q.z << 20);
}
vec3 unpackCoverage(uint p) { return vec3(p & 1023u, (p >> 10) & 1023u, (p >> 20) & 1023u) / 1023.0; }
/// Coverage of face `f` of a voxel whose faces +xyz and -xyz are in x and y.
float faceCoverage(uvec2 p, int f) { return float(((f & 1) == 0 ? p.x : p.y) >> (10 * (f >> 1)) & 1023u) / 1023.0; }
/// Surfaces of both in one voxel.
uvec2 addCoverage(uvec2 a, uvec2 b) {
    return uvec2(packCoverage(unpackCoverage(a.x) + unpackCoverage(b.x)),
                 packCoverage(unpackCoverage(a.y) + unpackCoverage(b.y)));
}

// Radiance over a scale that is common to all: three half floats.
const float kMostHalf = 65504.0;
uvec2 packHalf3(vec3 v) { return uvec2(packHalf2x16(v.rg), packHalf2x16(vec2(v.b, 0.0))); }
uvec2 packHalf4(vec4 v) { return uvec2(packHalf2x16(v.rg), packHalf2x16(v.ba)); }
vec4 unpackHalf4(uvec2 p) { return vec4(unpackHalf2x16(p.x), unpackHalf2x16(p.y)); }
vec3 unpackHalf3(uvec2 p) { return vec3(unpackHalf2x16(p.x), unpackHalf2x16(p.y).x); }

// What a voxel stops where there are leaves: solid coverage of +xyz and -xyz, and along each axis the optical depth of leaves
// per edge, as half floats.
uvec4 addMatter(uvec4 a, uvec4 b) {
    return uvec4(addCoverage(a.xy, b.xy), packHalf3(min(unpackHalf3(a.zw) + unpackHalf3(b.zw), vec3(kMostHalf))));
}

// Where a record belongs: texel in its level (8 bits each), level (4), moving geometry (1), and bit 31 while it is in use.
uint packPlace(ivec3 texel, int level, int moving) {
    return uint(texel.x) | (uint(texel.y) << 8) | (uint(texel.z) << 16) | (uint(level) << 24) | (uint(moving) << 28) |
           0x80000000u;
}
bool placeInUse(uint p) { return (p & 0x80000000u) != 0u; }
ivec3 placeTexel(uint p) { return ivec3(uvec3(p & 255u, (p >> 8) & 255u, (p >> 16) & 255u)); }
int placeLevel(uint p) { return int((p >> 24) & 15u); }
bool placeMoves(uint p) { return ((p >> 28) & 1u) != 0u; }

// The index volumes hold 0 where nothing is, 1 + the slot of the record, and during an update these marks.
const uint kTouched = 0xffffffffu;  // gets a record
const uint kFresh = 0x80000000u;    // plus its number among the new ones
