// Sum of what a pixel sends to the eye: its own emission, the layers that exist, or the sky behind everything.
#include "frame/gbuffer.glsl"
#include "cone/sky.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) uniform writeonly image2D u_output;
uniform sampler2D u_layer0;
uniform sampler2D u_layer1;
uniform sampler2D u_layer2;
uniform sampler2D u_layer3;
uniform int u_layers;
uniform float u_exposureScale;  // 2^exposure

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_output)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec3 radiance = vec3(0.0);
    if (s.hit) {
        radiance = s.emission;
        if (u_layers > 0) radiance += texelFetch(u_layer0, pixel, 0).rgb;
        if (u_layers > 1) radiance += texelFetch(u_layer1, pixel, 0).rgb;
        if (u_layers > 2) radiance += texelFetch(u_layer2, pixel, 0).rgb;
        if (u_layers > 3) radiance += texelFetch(u_layer3, pixel, 0).rgb;
    } else {
        radiance = skyRadiance(-s.toEye, 0.0);
    }
    imageStore(u_output, pixel, vec4(radiance * u_exposureScale, 1.0));
}
