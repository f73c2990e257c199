// The series of bounces, as the device follows it. Twin of Series in src/light/radiance.cpp.
layout(std430, binding = LIT_STORAGE) coherent buffer Series {
    uint b_faceGroups[3];  // work groups of the next bounce for the faces that gather and for all slots; 0 when the series
    uint b_slotGroups[3];  // has ended
    uint b_bounces;        // made so far
    float b_before[3];     // light that the last bounce added, by channel, in steps of the sums
    float b_total[3];      // light that all bounces added
    float b_gain[3];       // ratio of what the last two bounces added
    float b_tail[3];       // what all further bounces would add, over what the last one added
};
