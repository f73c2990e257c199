// Radiance from outside the scene for cones. SKY: 0 black, 1 constant, 2 panorama.
#if SKY == 2
#include "shared/environment.glsl"
uniform sampler2D u_environment;  // mips hold means over cones: src/gl/gpu_environment.h
uniform float u_environmentRotation;  // radians
#endif
#if SKY != 0
uniform vec3 u_environmentColor;  // radiance; multiplies the panorama
#endif

#if SKY == 2
int skyRows(int level) { return max(textureSize(u_environment, 0).y >> level, 1); }

/// Half-angle of the cones that mip `level` holds the means over.
float skyAngle(int level) {
    const float pi = 3.14159265;
    return level == 0 ? 0.0 : min(2.0 * pi / float(skyRows(level)), pi);
}

vec3 skyLevel(vec2 uv, int level) {
    float rows = float(skyRows(level));
    if (level > 0) uv.y = (uv.y * (rows - 1.0) + 0.5) / rows;  // first and last row are the poles
    return textureLod(u_environment, uv, float(level)).rgb;
}
#endif

/// Mean over a cone.
vec3 skyRadiance(vec3 direction, float tanHalfAngle) {
#if SKY == 2
    const float pi = 3.14159265;
    vec2 uv = environmentUv(direction, u_environmentRotation);
    float angle = atan(tanHalfAngle);
    float lod = log2(max(angle * float(skyRows(0)) / (2.0 * pi), 1.0));
    int coarsest = textureQueryLevels(u_environment) - 1;
    int level = min(int(lod), max(coarsest - 1, 0));
    float own = skyAngle(level), next = skyAngle(min(level + 1, coarsest));
    // Between two mips such that the variance of directions is the cone's.
    float blend = next > own ? clamp((angle * angle - own * own) / (next * next - own * own), 0.0, 1.0) : 0.0;
    vec3 radiance = skyLevel(uv, level);
    if (blend > 0.0) radiance = mix(radiance, skyLevel(uv, level + 1), blend);
    return u_environmentColor * radiance;
#elif SKY == 1
    return u_environmentColor;
#else
    return vec3(0.0);
#endif
}
