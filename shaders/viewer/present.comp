// A display-referred picture as the window shows it: sRGB encoded (IEC 61966-2-1) in eight bits, NaN as magenta.
layout(local_size_x = 8, local_size_y = 8) in;

uniform sampler2D u_picture;
layout(rgba8) uniform writeonly image2D u_encoded;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_encoded)))) return;
    vec3 x = texelFetch(u_picture, pixel, 0).rgb;
    if (any(isnan(x))) x = vec3(1.0, 0.0, 1.0);
    x = clamp(x, 0.0, 1.0);
    vec3 encoded = mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
    imageStore(u_encoded, pixel, vec4(encoded, 1.0));
}
