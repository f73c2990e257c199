// After each bounce, once: what it added, and whether another one is needed.
#include "cascade/buffers.glsl"
layout(local_size_x = 1) in;

uniform float u_tolerance;  // 0: all bounces are made
uniform bool u_extrapolate;
layout(std430, binding = COUNTER_STORAGE) coherent buffer Counters { VOXEL_COUNTERS };
#include "light/series.glsl"

// A scene that reflects all of its light has no answer; no more is believed of any.
const float kMostGain = 0.995;

void main() {
    if (b_faceGroups[0] == 0u) return;
    ++b_bounces;
    bool enough = true;
    for (int c = 0; c < 3; ++c) {
        float added = max(float(int(b_added[2 * c + 1])) * 4294967296.0 + float(b_added[2 * c]), 0.0);
        b_added[2 * c] = 0u;
        b_added[2 * c + 1] = 0u;
        // Bounces k and k+1 add in the ratio g of a geometric series: the rest is g/(1-g) of the last. What has added
        // nothing goes on adding nothing; of a first bounce nobody knows.
        float gain = b_before[c] > 0.0 ? min(added / b_before[c], kMostGain) : 0.0;
        b_before[c] = added;
        b_total[c] += added;
        b_gain[c] = gain;
        b_tail[c] = gain / (1.0 - gain);
        float rest = b_tail[c] * added;
        bool known = b_bounces > 1u || added == 0.0;
        enough = enough && known && (u_extrapolate ? added : rest) <= u_tolerance * (b_total[c] + rest);
    }
    if (u_tolerance > 0.0 && enough) {
        for (int i = 0; i < 3; ++i) b_faceGroups[i] = b_slotGroups[i] = 0u;
    }
}
