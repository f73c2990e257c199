// Directions of a diffuse cone set around +z. C++ twin: src/cone/cone_set.h. Needs CONES and SPIRAL, for pixels ROTATE too.
#if !SPIRAL
uniform vec4 u_cones[CONES];  // direction, weight
#endif
uniform float u_coneTanHalfAngle;

#if SPIRAL
/// Place of cone `i` of a spiral: u in (0,1), azimuth.
vec2 spiralPlace(int i, float turn, float shift) {
    return vec2((float(i) + 0.5 + shift) / float(CONES), 2.39996322972865332 * float(i) + 6.28318530717958648 * turn);
}
#endif

/// Direction and weight of cone `i`, turned by `turn` (0 to 1 of a revolution); a spiral is also shifted by `shift`
/// (-1/2 to 1/2 of a stratum) in cos²θ, so that pixels that turn and shift differently integrate together.
vec4 coneOfSet(int i, float turn, float shift) {
#if SPIRAL
    vec2 place = spiralPlace(i, turn, shift);
    float u = place.x, azimuth = place.y;
    return vec4(sqrt(u) * cos(azimuth), sqrt(u) * sin(azimuth), sqrt(1.0 - u), 1.0 / float(CONES));
#else
    const float kTwoPi = 6.28318530717958648;
    float c = cos(kTwoPi * turn), s = sin(kTwoPi * turn);
    vec4 cone = u_cones[i];
    return vec4(c * cone.x - s * cone.y, s * cone.x + c * cone.y, cone.zw);
#endif
}

/// Orientation `k` of `n` that together cover a revolution and a stratum evenly. `n` is 1 or 16.
float turnOf(int k, int n) { return float(k) / float(n); }
float shiftOf(int k, int n) {
    return n == 1 ? 0.0 : (float(bitfieldReverse(uint(k)) >> 28) + 0.5) / 16.0 - 0.5;
}

#ifdef ROTATE
/// Turn and shift of a pixel's cones: sixteen orientations over a tile of 4 x 4 pixels, in the order of a Bayer matrix so that
/// neighbours differ most; filters take their mean.
vec2 orientationOf(ivec2 pixel) {
#if ROTATE
    const int kBayer[16] = int[](0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5);
    int k = kBayer[(pixel.y & 3) * 4 + (pixel.x & 3)];
    return vec2(turnOf(k, 16), shiftOf(k, 16));
#else
    return vec2(0.0);
#endif
}
#endif

/// Right-handed frame around unit `n` (columns tangent, bitangent, n), Duff et al. 2017.
mat3 frameAround(vec3 n) {
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z), b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}
