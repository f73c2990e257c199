// Depth only. With ALPHA_TEST texels of masked materials below the cut-off are left out. Blended ones, and masked ones
// whose texture is minified, are drawn through a screen door: of each 4×4 texels as many as their opacity says (Bayer's
// matrix), which the shadow filter averages to a part of the light. So is what transmits light: its shadow has no colour,
// and of several bodies in a row the darkest counts.
#if ALPHA_TEST
#include "shared/material.glsl"

in Vertex {
    vec2 uv0, uv1;
    vec4 color;
    vec3 normal, fromLight;
    float scale;
} v;

float screenDoor(ivec2 texel) {
    const float bayer[16] = float[16](0.0, 8.0, 2.0, 10.0, 12.0, 4.0, 14.0, 6.0, 3.0, 11.0, 1.0, 9.0, 15.0, 7.0, 13.0, 5.0);
    return (bayer[(texel.x & 3) + 4 * (texel.y & 3)] + 0.5) / 16.0;
}
#endif

void main() {
#if ALPHA_TEST
    float door = screenDoor(ivec2(gl_FragCoord.xy));
    MaterialSample material = sampleMaterial(v.uv0, v.uv1, v.color);
    if (materialAlphaMode() != ALPHA_OPAQUE && material.alpha < materialAlphaThreshold(v.uv0, v.uv1, door)) discard;
    float cosine = min(abs(dot(v.normal, v.fromLight)) * inversesqrt(max(dot(v.fromLight, v.fromLight), 1e-30)), 1.0);
    float m = 1.0 - cosine;
    vec3 passing = materialTransmittance(material, v.scale, m * m * m * m * m);
    if (dot(passing, vec3(1.0 / 3.0)) > door) discard;
#endif
}
