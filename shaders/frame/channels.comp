// One channel of the G-buffer as floats at output resolution: mean over the u_supersample² samples of a pixel, over those
// that hit something for depth and position (w: share of samples that hit).
#include "frame/gbuffer.glsl"

#define CHANNEL_ALBEDO 0
#define CHANNEL_NORMAL 1
#define CHANNEL_DEPTH 2
#define CHANNEL_POSITION 3
#define CHANNEL_EMISSION 4

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) uniform writeonly image2D u_output;
uniform int u_channel;
uniform int u_supersample;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_output)))) return;
    vec3 sum = vec3(0.0);
    float hits = 0.0;
    for (int i = 0; i < u_supersample * u_supersample; ++i) {
        GBufferSample s = loadGBuffer(pixel * u_supersample + ivec2(i % u_supersample, i / u_supersample));
        if (!s.hit) continue;
        hits += 1.0;
        if (u_channel == CHANNEL_ALBEDO) sum += s.baseColor;
        if (u_channel == CHANNEL_NORMAL) sum += gbufferNormal(pixel * u_supersample + ivec2(i % u_supersample, i / u_supersample));
        if (u_channel == CHANNEL_DEPTH) sum += vec3(s.viewDepth);
        if (u_channel == CHANNEL_POSITION) sum += s.position;
        if (u_channel == CHANNEL_EMISSION) sum += s.emission;
    }
    float samples = float(u_supersample * u_supersample);
    bool overHits = u_channel == CHANNEL_DEPTH || u_channel == CHANNEL_POSITION;
    imageStore(u_output, pixel, vec4(sum / (overHits ? max(hits, 1.0) : samples), hits / samples));
}
