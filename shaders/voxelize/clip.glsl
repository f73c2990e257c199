// The triangle of a fragment clipped to the voxels of its pixel column (Sutherland-Hodgman), in permuted voxel units.

const int kMaxCorners = 9;  // a triangle clipped by six planes

struct Polygon {
    vec3 corner[kMaxCorners];
    int count;
};

/// Keeps the part of `polygon` with side * (corner[axis] - bound) >= 0.
void clipPolygon(inout Polygon polygon, int axis, float bound, float side) {
    if (polygon.count == 0) return;
    vec3 kept[kMaxCorners];
    int count = 0;
    vec3 previous = polygon.corner[polygon.count - 1];
    float before = side * (previous[axis] - bound);
    for (int i = 0; i < polygon.count; ++i) {
        vec3 current = polygon.corner[i];
        float here = side * (current[axis] - bound);
        if ((before < 0.0) != (here < 0.0) && count < kMaxCorners) {
            vec3 crossing = mix(previous, current, before / (before - here));
            crossing[axis] = bound;
            kept[count++] = crossing;
        }
        if (here >= 0.0 && count < kMaxCorners) kept[count++] = current;
        previous = current;
        before = here;
    }
    polygon.corner = kept;
    polygon.count = count;
}

/// Cells are half-open, [i, i+1): a polygon that lies in an upper face belongs to the next cell.
bool insideHalfOpenCell(Polygon polygon, vec3 cell) {
    if (polygon.count == 0) return false;
    vec3 low = polygon.corner[0];
    for (int i = 1; i < polygon.count; ++i) low = min(low, polygon.corner[i]);
    return all(lessThan(low, cell + 1.0));
}

/// Area times normal (its components are the projected areas), and the middle.
vec3 vectorArea(Polygon polygon, out vec3 middle) {
    vec3 area = vec3(0.0), moment = vec3(0.0), mean = vec3(0.0);
    float total = 0.0;
    for (int i = 0; i < polygon.count; ++i) {
        mean += polygon.corner[i];
        if (i < 2) continue;
        vec3 part = 0.5 * cross(polygon.corner[i - 1] - polygon.corner[0], polygon.corner[i] - polygon.corner[0]);
        float size = length(part);
        area += part;
        total += size;
        moment += size * (polygon.corner[0] + polygon.corner[i - 1] + polygon.corner[i]) / 3.0;
    }
    middle = total > 0.0 ? moment / total : mean / float(max(polygon.count, 1));
    return area;
}

/// First and last cell along z that `column`, clipped to its pixel already, reaches. Not from the triangle's plane: the
/// normal of a sliver is too uncertain to tell its depth some voxels on.
ivec2 depthRange(Polygon column, int resolution) {
    vec2 range = column.corner[0].zz;
    for (int i = 1; i < column.count; ++i)
        range = vec2(min(range.x, column.corner[i].z), max(range.y, column.corner[i].z));
    return ivec2(floor(vec2(max(range.x, 0.0), min(range.y, float(resolution - 1)))));
}

vec3 unpermute(vec3 p, int axis) { return axis == 2 ? p : (axis == 0 ? p.zxy : p.yzx); }
