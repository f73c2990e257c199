// Slots of new records: free ones first, then what lies behind all that are in use.
layout(std430, binding = FREE_STORAGE) readonly buffer Free { uint b_free[]; };
uniform uint u_freeCount;  // free slots before this update takes any
uniform uint u_firstSlot;  // behind all that were ever in use

uint slotOfFresh(uint number) {
    return number < u_freeCount ? b_free[u_freeCount - 1u - number] : u_firstSlot + number - u_freeCount;
}
