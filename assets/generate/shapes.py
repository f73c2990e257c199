"""Shapes for the scenes, in metres, y up. Every solid is watertight, its normals point outwards, its front is
counter-clockwise seen from outside."""

import math

from gltf_writer import Mesh


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(v):
    length = math.sqrt(dot(v, v))
    return tuple(x / length for x in v)


def quad(a, b, c, d, uv_size=(1.0, 1.0)):
    """Flat quad, counter-clockwise seen from its front."""
    mesh = Mesh()
    normal = unit(cross(sub(b, a), sub(d, a)))
    u, v = uv_size
    corners = [mesh.add(p, normal, uv) for p, uv in zip((a, b, c, d), ((0, v), (u, v), (u, 0), (0, 0)))]
    mesh.triangle(corners[0], corners[1], corners[2])
    mesh.triangle(corners[0], corners[2], corners[3])
    return mesh


def box(low, high):
    """Axis-aligned solid; texture coordinates are metres."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    mesh = Mesh()
    for corners, size in (
            (((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)), (x1 - x0, y1 - y0)),
            (((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)), (x1 - x0, y1 - y0)),
            (((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)), (z1 - z0, y1 - y0)),
            (((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)), (z1 - z0, y1 - y0)),
            (((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)), (x1 - x0, z1 - z0)),
            (((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)), (x1 - x0, z1 - z0))):
        mesh.append(quad(*corners, uv_size=size))
    return mesh


def prism(ring, y0, y1):
    """Solid over a convex polygon `ring` of (x, z), given in either order."""
    area = sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, ring[1:] + ring[:1]))
    if area > 0:  # counter-clockwise in (x, z) is clockwise seen from above
        ring = ring[::-1]
    mesh = Mesh()
    for (ax, az), (bx, bz) in zip(ring, ring[1:] + ring[:1]):
        mesh.append(quad((ax, y0, az), (bx, y0, bz), (bx, y1, bz), (ax, y1, az), (math.dist((ax, az), (bx, bz)), y1 - y0)))
    for y, normal, order in ((y1, (0, 1, 0), ring), (y0, (0, -1, 0), ring[::-1])):
        corners = [mesh.add((x, y, z), normal, (x, z)) for x, z in order]
        for i in range(1, len(corners) - 1):
            mesh.triangle(corners[0], corners[i], corners[i + 1])
    return mesh


def shell(inner_low, inner_high, thickness):
    """Sealed hollow room: six closed boxes around an empty inside. They run into each other by half the thickness, so that
    no two faces lie in one plane and no crack is left between them."""
    (x0, y0, z0), (x1, y1, z1) = inner_low, inner_high
    t, h = thickness, thickness / 2
    o = 1.25 * t  # floor and ceiling stand out a little, so do the walls along x
    return [box((x0 - o, y0 - t, z0 - o), (x1 + o, y0, z1 + o)), box((x0 - o, y1, z0 - o), (x1 + o, y1 + t, z1 + o)),
            box((x0 - 1.1 * t, y0 - h, z0 - t), (x1 + 1.1 * t, y1 + h, z0)),
            box((x0 - 1.1 * t, y0 - h, z1), (x1 + 1.1 * t, y1 + h, z1 + t)),
            box((x0 - t, y0 - .4 * t, z0 - h), (x0, y1 + .4 * t, z1 + h)),
            box((x1, y0 - .4 * t, z0 - h), (x1 + t, y1 + .4 * t, z1 + h))]


def sphere(radius, slices=48, stacks=24):
    mesh = Mesh()
    rows = []
    for i in range(stacks + 1):
        polar = math.pi * i / stacks
        row = []
        for j in range(slices + 1):
            around = 2 * math.pi * (j % slices) / slices
            # Exact poles, so that the solid welds there.
            n = ((0.0, 1.0 if i == 0 else -1.0, 0.0) if i in (0, stacks) else
                 (math.sin(polar) * math.cos(around), math.cos(polar), -math.sin(polar) * math.sin(around)))
            row.append(mesh.add(tuple(radius * c for c in n), n, (j / slices, i / stacks)))
        rows.append(row)
    for i in range(stacks):
        for j in range(slices):
            a, b, c, d = rows[i][j], rows[i + 1][j], rows[i + 1][j + 1], rows[i][j + 1]
            if i < stacks - 1:
                mesh.triangle(a, b, c)
            if i > 0:
                mesh.triangle(a, c, d)
    return mesh


def height_field(width, cells, height):
    """Square around the origin of `cells`² cells; `height(x, z)` gives height and slopes along x and z."""
    mesh = Mesh()
    for i in range(cells + 1):
        for j in range(cells + 1):
            x, z = width * (j / cells - 0.5), width * (i / cells - 0.5)
            y, along_x, along_z = height(x, z)
            mesh.add((x, y, z), unit((-along_x, 1.0, -along_z)), (j / cells, i / cells))
    for i in range(cells):
        for j in range(cells):
            a = i * (cells + 1) + j
            b, c, d = a + cells + 1, a + cells + 2, a + 1
            mesh.triangle(a, b, c)
            mesh.triangle(a, c, d)
    return mesh


def lathe(profile, sides):
    """Solid of revolution about y. `profile` is a list of (radius, y) from bottom to top, first and last radius above 0;
    a sharp edge is a point given twice. Both ends are closed by discs."""
    mesh = Mesh()
    smooth = []
    for i, point in enumerate(profile):
        # The slope of one point is the mean of its neighbours' within the same smooth run.
        before = profile[i - 1] if i > 0 and profile[i - 1] != point else point
        after = profile[i + 1] if i + 1 < len(profile) and profile[i + 1] != point else point
        dr, dy = after[0] - before[0], after[1] - before[1]
        length = math.hypot(dr, dy)
        smooth.append((dy / length, -dr / length))
    around = [2 * math.pi * (j % sides) / sides for j in range(sides + 1)]
    rows = [[mesh.add((r * math.cos(a), y, -r * math.sin(a)), (nr * math.cos(a), ny, -nr * math.sin(a)), (j / sides, y))
             for j, a in enumerate(around)] for (r, y), (nr, ny) in zip(profile, smooth)]
    for i in range(len(profile) - 1):
        if profile[i] == profile[i + 1]:
            continue
        for j in range(sides):
            a, b, c, d = rows[i][j], rows[i][j + 1], rows[i + 1][j + 1], rows[i + 1][j]
            mesh.triangle(a, b, c)
            mesh.triangle(a, c, d)
    for (r, y), normal in ((profile[0], -1.0), (profile[-1], 1.0)):
        ring = [mesh.add((r * math.cos(a), y, -r * math.sin(a)), (0.0, normal, 0.0), (math.cos(a), math.sin(a)))
                for a in around[:-1]]
        for j in range(1, sides - 1):
            mesh.triangle(ring[0], *((ring[j], ring[j + 1]) if normal > 0 else (ring[j + 1], ring[j])))
    return mesh


def arch(width, springing, top, depth, segments=16):
    """Wall panel of `width` (x, centred) and `depth` (z, centred) from y = `springing` to `top`, with a semicircle cut out
    of its lower edge that leaves `foot` on each side."""
    foot = 0.12 * width
    radius = width / 2 - foot
    assert springing + radius < top
    curve = [(-radius * math.cos(math.pi * i / segments), springing + radius * math.sin(math.pi * i / segments))
             for i in range(segments + 1)]
    curve[0], curve[-1] = (-radius, springing), (radius, springing)
    outline = [(-width / 2, springing)] + curve + [(width / 2, springing)]
    mesh = Mesh()
    for z, normal, front in ((depth / 2, (0, 0, 1), True), (-depth / 2, (0, 0, -1), False)):
        lower = [mesh.add((x, y, z), normal, (x, y)) for x, y in outline]
        upper = [mesh.add((x, top, z), normal, (x, top)) for x, y in outline]
        for i in range(len(outline) - 1):
            a, b, c, d = lower[i], lower[i + 1], upper[i + 1], upper[i]
            if outline[i][0] == outline[i + 1][0]:
                continue
            for tri in ((a, b, c), (a, c, d)):
                mesh.triangle(*(tri if front else tri[::-1]))
    h = depth / 2
    for (ax, ay), (bx, by) in zip(outline, outline[1:]):  # soffit
        flat = ay == by == springing
        normals = [(0.0, -1.0, 0.0)] * 2 if flat else [unit((-x, -(y - springing), 0.0)) for x, y in ((ax, ay), (bx, by))]
        a0, a1 = (mesh.add((ax, ay, z), normals[0], (ax, z)) for z in (-h, h))
        b0, b1 = (mesh.add((bx, by, z), normals[1], (bx, z)) for z in (-h, h))
        mesh.triangle(a0, b0, b1)
        mesh.triangle(a0, b1, a1)
    for (ax, _), (bx, _) in zip(outline, outline[1:]):  # upper edge, cut at the same places so that it welds
        mesh.append(quad((ax, top, h), (bx, top, h), (bx, top, -h), (ax, top, -h)))
    w = width / 2
    mesh.append(quad((w, springing, h), (w, springing, -h), (w, top, -h), (w, top, h)))
    mesh.append(quad((-w, springing, -h), (-w, springing, h), (-w, top, h), (-w, top, -h)))
    return mesh


def curtain(width, height, waves, depth, columns=48, rows=5):
    """Hanging sheet in the plane z = 0, from y = -height to 0, x centred; the folds deepen downwards."""
    mesh = Mesh()
    grid = []
    for i in range(rows + 1):
        s = i / rows
        amplitude = depth * (0.35 + 0.65 * s)
        row = []
        for j in range(columns + 1):
            t = j / columns
            phase = 2 * math.pi * waves * t
            slope_x = amplitude * math.cos(phase) * 2 * math.pi * waves / width
            slope_y = -depth * 0.65 * math.sin(phase) / height
            row.append(mesh.add((width * (t - 0.5), -height * s, amplitude * math.sin(phase)),
                                unit((-slope_x, -slope_y, 1.0)), (t, s)))
        grid.append(row)
    for i in range(rows):
        for j in range(columns):
            a, b, c, d = grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1], grid[i][j]
            mesh.triangle(a, b, c)
            mesh.triangle(a, c, d)
    return mesh
