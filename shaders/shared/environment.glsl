// Look-up of an equirectangular panorama: row 0 is +y, the column centre is −z, x to the right. The same arithmetic stands
// in src/scene/environment.cpp.

/// Texture coordinates in [0,1)² of unit direction `d` (towards the sky). `rotation` turns the panorama about +y,
/// counter-clockwise seen from above, in radians.
vec2 environmentUv(vec3 d, float rotation) {
    const float pi = 3.14159265358979;
    // atan(0, 0) is undefined in GLSL: at the poles every column shows the same place.
    float longitude = (d.x == 0.0 && d.z == 0.0 ? 0.0 : atan(d.x, -d.z)) + rotation;
    return vec2(fract(0.5 + longitude / (2.0 * pi)), min(acos(clamp(d.y, -1.0, 1.0)) / pi, 0.99999994));
}
