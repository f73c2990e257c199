// Half floats that are right in the mean: light is stored and read again in every bounce, and where neighbours hold nearly
// the same, rounding to the nearest would make the same error in all of them, which the series of bounces multiplies.

/// The same for a face wherever its record lies and whatever frame it is.
uint faceHash(uint place, uint face) {
    uint h = (place * 6u + face) * 747796405u + 2891336453u;
    h = ((h >> ((h >> 28) + 4u)) ^ h) * 277803737u;
    return (h >> 22) ^ h;
}

/// Rounds to 11 bits, up as often as the hash (its low 13 bits) and the rest of the value say: packing is then exact.
vec3 ditherToHalf(vec3 v, uint hash) {
    return uintBitsToFloat((floatBitsToUint(v) + (hash & 0x1fffu)) & ~0x1fffu);
}
