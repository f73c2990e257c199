// Shared-exponent colour, EXT_texture_shared_exponent: three 9-bit mantissas and a 5-bit exponent, bias 15. Twin:
// src/core/rgb9e5.h. A step is at most 1/256 of the largest component.

const float kMaxRgb9e5 = 65408.0;

uint packRgb9e5(vec3 color) {
    vec3 c = clamp(color, vec3(0.0), vec3(kMaxRgb9e5));
    float largest = max(c.x, max(c.y, c.z));
    // floor(log2(x)) read from the exponent bits: log2 itself may be off by an ulp around powers of two.
    int exponent = max(-16, int(floatBitsToUint(largest) >> 23) - 127) + 16;
    float scale = exp2(float(24 - exponent));
    if (floor(largest * scale + 0.5) == 512.0) {
        ++exponent;
        scale *= 0.5;
    }
    uvec3 mantissa = uvec3(floor(c * scale + 0.5));
    return mantissa.x | (mantissa.y << 9) | (mantissa.z << 18) | (uint(exponent) << 27);
}

vec3 unpackRgb9e5(uint p) {
    float scale = exp2(float(int(p >> 27) - 24));
    return vec3(p & 511u, (p >> 9) & 511u, (p >> 18) & 511u) * scale;
}
