// Radiance from outside the scene for cones. SKY: 0 black, 1 constant, 2 panorama.
#if SKY == 2
#include "shared/environment.glsl"
uniform sampler2D u_environment;
uniform float u_environmentRotation;  // radians
#endif
#if SKY != 0
uniform vec3 u_environmentColor;  // radiance; multiplies the panorama
#endif

vec3 skyRadiance(vec3 direction, float tanHalfAngle) {
#if SKY == 2
    // The mip whose texels (π/height radians) are as wide as the cone.
    float height = float(textureSize(u_environment, 0).y);
    float lod = log2(max(2.0 * atan(tanHalfAngle) * height / 3.14159265, 1.0));
    return u_environmentColor * textureLod(u_environment, environmentUv(direction, u_environmentRotation), lod).rgb;
#elif SKY == 1
    return u_environmentColor;
#else
    return vec3(0.0);
#endif
}
