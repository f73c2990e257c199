// Tone curves. Twin of src/frame/tone_curve.h.
#define TONE_LINEAR 0
#define TONE_REINHARD 1
#define TONE_ACES 2

// Linear exposed radiance to linear display-referred values in [0,1].
vec3 toneCurve(int curve, vec3 x) {
    x = max(x, vec3(0.0));
    if (curve == TONE_REINHARD) return x / (1.0 + x);
    // Above 1e4 the fit has long been at its limit; the square would overflow.
    if (curve == TONE_ACES) {
        x = min(x, vec3(1e4));
        x = (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
    }
    return min(x, vec3(1.0));
}
