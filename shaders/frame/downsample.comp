// Mean over u_supersample² texels; with TONE_MAP, tone curve u_curve after that.
#ifdef TONE_MAP
#include "shared/tone_curve.glsl"
uniform int u_curve;
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) uniform writeonly image2D u_output;
uniform sampler2D u_source;
uniform int u_supersample;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_output)))) return;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < u_supersample * u_supersample; ++i) {
        sum += texelFetch(u_source, pixel * u_supersample + ivec2(i % u_supersample, i / u_supersample), 0);
    }
    vec4 mean = sum / float(u_supersample * u_supersample);
#ifdef TONE_MAP
    mean.rgb = toneCurve(u_curve, mean.rgb);
#endif
    imageStore(u_output, pixel, mean);
}
