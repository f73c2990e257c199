// Falloffs of KHR_lights_punctual. Twin of src/scene/light_math.h: same names, same arithmetic.
#ifndef VOXCONE_LIGHT_MATH_GLSL
#define VOXCONE_LIGHT_MATH_GLSL

// 1 inside the inner cone, 0 outside the outer one, smooth between. Arguments are cosines.
float spotFalloff(float cosAngle, float cosInner, float cosOuter) {
    float t = clamp((cosAngle - cosOuter) / max(cosInner - cosOuter, 1e-3), 0.0, 1.0);
    return t * t;
}

// Window that takes the inverse-square law to zero at `range`; 0 means unlimited. 1/distance² is not included.
float rangeWindow(float distance, float range) {
    if (range <= 0.0) return 1.0;
    float r = distance / range;
    return clamp(1.0 - r * r * r * r, 0.0, 1.0);
}

#endif
