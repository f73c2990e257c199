// Which level each pixel's surface reads, as colours: red, orange, green, cyan, blue, violet, magenta, white from the finest
// on, mixed where levels blend; in a the level itself, its fraction being the weight of the next one.
#include "frame/gbuffer.glsl"
#include "cascade/containment.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform float u_inverseVoxelSize;  // of level 0
layout(rgba32f) uniform writeonly image2D u_picture;

vec3 colorOfLevel(int level) {
    const vec3 kColors[8] = vec3[](vec3(0.9, 0.1, 0.1), vec3(0.9, 0.5, 0.05), vec3(0.1, 0.7, 0.1), vec3(0.05, 0.7, 0.7),
                                   vec3(0.1, 0.2, 0.9), vec3(0.45, 0.1, 0.8), vec3(0.9, 0.1, 0.7), vec3(0.9));
    return kColors[level];
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_picture)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec4 value = vec4(0.0, 0.0, 0.0, -1.0);
    if (s.hit) {
        vec2 level = containment(s.position * u_inverseVoxelSize);
        vec3 color = mix(colorOfLevel(int(level.x)), colorOfLevel(min(int(level.x) + 1, 7)), level.y);
        // A little of the surface's direction shows where things are.
        value = vec4(color * (0.5 + 0.5 * abs(dot(s.geometricNormal, s.toEye))), level.x + level.y);
    }
    imageStore(u_picture, pixel, value);
}
