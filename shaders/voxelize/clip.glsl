// The part of the fragment's triangle that lies in one voxel, in permuted voxel units.
//
// Its boundary is made of at most nine segments: the three edges clipped to the voxel, and on each of the six faces the
// chord that the triangle cuts. Areas and moments are sums over the segments, so that no polygon has to be kept: arrays
// with computed indices are slow on every device.

/// Sums over the boundary of the piece.
struct Piece {
    bool any;      // something of the triangle is in there
    vec3 anchor;   // a point of the boundary: what the sums are relative to
    vec3 area;     // area times normal: its components are the projected areas
    vec3 moment;   // of the projected area along z, relative to the anchor
    float weight;  // projected area along z, signed
    vec3 low, high;  // bounds of the segments
};

vec3 vertexOf(int i) { return i == 0 ? f_p0 : (i == 1 ? f_p1 : f_p2); }

/// Clips segment (a, b) to the box and adds what is left to the piece. A segment that lies in a bounding plane counts where
/// `closedLow` and `closedHigh` say so.
void addSegment(inout Piece piece, vec3 a, vec3 b, vec3 low, vec3 high, bvec3 closedLow, bvec3 closedHigh) {
    vec3 d = b - a;
    bvec3 parallel = equal(d, vec3(0.0));
    vec3 inverse = 1.0 / mix(d, vec3(1.0), parallel);
    vec3 toLow = (low - a) * inverse, toHigh = (high - a) * inverse;
    vec3 aboveLow = vec3(greaterThan(a, low)) + vec3(closedLow) * vec3(equal(a, low));
    vec3 belowHigh = vec3(lessThan(a, high)) + vec3(closedHigh) * vec3(equal(a, high));
    vec3 inside = aboveLow * belowHigh;
    vec3 enter = mix(min(toLow, toHigh), mix(vec3(2.0), vec3(-1.0), inside), parallel);
    vec3 leave = mix(max(toLow, toHigh), mix(vec3(-1.0), vec3(2.0), inside), parallel);
    float t0 = max(max(enter.x, enter.y), max(enter.z, 0.0)), t1 = min(min(leave.x, leave.y), min(leave.z, 1.0));
    if (!(t1 >= t0)) return;  // a point is enough to touch
    vec3 from = t0 > 0.0 ? a + d * t0 : a, to = t1 < 1.0 ? a + d * t1 : b;
    if (!piece.any) {
        piece.any = true;
        piece.anchor = piece.low = piece.high = from;
    }
    vec3 u = from - piece.anchor, v = to - piece.anchor;
    vec3 part = 0.5 * cross(u, v);
    piece.area += part;
    piece.moment += part.z * (u + v) / 3.0;
    piece.weight += part.z;
    piece.low = min(piece.low, min(from, to));
    piece.high = max(piece.high, max(from, to));
}

/// What of the triangle lies in the half-open box [low, high): a triangle in an upper face belongs to the next voxel.
/// `faces` is 6, or 4 for a column without ends.
Piece pieceIn(vec3 low, vec3 high, int faces) {
    Piece piece = Piece(false, vec3(0.0), vec3(0.0), vec3(0.0), 0.0, vec3(0.0), vec3(0.0));
    for (int i = 0; i < 3 + faces; ++i) {
        vec3 a, b, clipLow = low, clipHigh = high;
        bvec3 closedLow = bvec3(true), closedHigh = bvec3(false);
        bool exists = true;
        if (i < 3) {
            a = vertexOf(i);
            b = vertexOf(i == 2 ? 0 : i + 1);
        } else {
            // The chord in the plane of a face. Vertices on the plane count as above it.
            int axis = (i - 3) >> 1;
            bool upper = ((i - 3) & 1) != 0;
            float plane = upper ? high[axis] : low[axis];
            bvec3 above = greaterThanEqual(vec3(f_p0[axis], f_p1[axis], f_p2[axis]), vec3(plane));
            exists = above.x != above.y || above.y != above.z;
            int odd = above.y == above.z ? 0 : (above.x == above.z ? 1 : 2);  // the vertex alone on its side
            vec3 o = vertexOf(odd), n = vertexOf(odd == 2 ? 0 : odd + 1), p = vertexOf(odd == 0 ? 2 : odd - 1);
            float toNext = n[axis] - o[axis], toPrevious = p[axis] - o[axis];
            vec3 onNext = o + (n - o) * ((plane - o[axis]) / (toNext != 0.0 ? toNext : 1.0));
            vec3 onPrevious = o + (p - o) * ((plane - o[axis]) / (toPrevious != 0.0 ? toPrevious : 1.0));
            onNext[axis] = onPrevious[axis] = plane;
            // The way around the piece.
            bool forward = above[odd] != upper;
            a = forward ? onNext : onPrevious;
            b = forward ? onPrevious : onNext;
            // A chord along an edge of the box lies in two faces: it counts once, in the face of the lower axis.
            closedLow = closedHigh = axis == 0 ? bvec3(true) : (axis == 1 ? bvec3(false, true, true) : bvec3(false));
            clipLow[axis] = -1e30;
            clipHigh[axis] = 1e30;
        }
        if (exists) addSegment(piece, a, b, clipLow, clipHigh, closedLow, closedHigh);
    }
    piece.any = piece.any && all(lessThan(piece.low, high));
    return piece;
}

/// Centre of area of a piece that is there; of a piece without area, of its bounds.
vec3 middleOf(Piece piece) {
    vec3 middle = piece.weight != 0.0 ? piece.anchor + piece.moment / piece.weight : 0.5 * (piece.low + piece.high);
    return clamp(middle, piece.low, piece.high);
}

vec3 unpermute(vec3 p, int axis) { return axis == 2 ? p : (axis == 0 ? p.zxy : p.yzx); }
