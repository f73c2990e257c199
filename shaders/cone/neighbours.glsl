// What filters of gathered light ask of a neighbour. Needs frame/gbuffer.glsl and cascade/containment.glsl.
uniform float u_voxelSize;  // of level 0

/// Edge of the voxels that a surface reads, metres.
float voxelSizeAt(vec3 position) { return u_voxelSize * exp2(containmentLevel(position / u_voxelSize)); }

/// 1 for a pixel that lies where `s` does, 0 for one of another surface or outside of the picture.
float sameSurface(GBufferSample s, ivec2 tap, float voxelSize) {
    if (any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, gbufferSize()))) return 0.0;
    float depth = gbufferViewDepth(tap);
    if (depth <= 0.0) return 0.0;
    vec3 offset = u_cameraPosition + gbufferRay(tap) * depth - s.position;
    // Out of the tangent plane by less than half a voxel (light varies over voxels) or the slope of the pixels between them.
    float bound = 0.1 * length(offset) + 0.05 * voxelSize;
    float plane = 1.0 - abs(dot(offset, s.geometricNormal)) / bound;
    float near = 1.0 - length(offset) / (4.0 * voxelSize);
    return clamp(plane, 0.0, 1.0) * clamp(near, 0.0, 1.0);
}

/// Weight of a tap `offset` (-2 to 2) of a box of 4 x 4 pixels centred on a pixel: five taps a side, the outer ones half, so
/// that each of sixteen orientations counts once.
float boxWeight(ivec2 offset) { return (abs(offset.x) == 2 ? 0.5 : 1.0) * (abs(offset.y) == 2 ? 0.5 : 1.0); }
