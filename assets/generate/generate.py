#!/usr/bin/env python3
"""Writes the scenes of assets/scenes. `generate.py` writes all of them, `generate.py cornell leak --thickness 0.1` some;
`generate.py --check` says whether the committed files are what this program writes."""

import argparse
import math
import sys
import tempfile
from pathlib import Path

import shapes
from gltf_writer import Mesh, Writer

SCENES = Path(__file__).resolve().parent.parent / "scenes"

# Linear Rec. 709 reflectances of the Cornell box: the published spectra, integrated, as renderers usually quote them.
CORNELL_RED, CORNELL_GREEN, CORNELL_WHITE = (0.63, 0.065, 0.05), (0.14, 0.45, 0.091), (0.725, 0.71, 0.68)
CORNELL_LAMP = (0.78, 0.78, 0.78)


def cornell(_):
    """The Cornell box as measured (Cornell University Program of Computer Graphics), ten times as large, 5.55 m. The file
    looks along -z: x and z of the published data change sign, the floor's middle front edge is the origin. The lamp is a
    surface that does not emit; the capture script puts a rectangle light of its size in front of it."""
    def at(x, y, z):
        return (2.78 - x / 100, y / 100, -z / 100)

    def sheet(*corners):
        return shapes.quad(*(at(*c) for c in corners))

    w = Writer(cornell.__doc__)
    white = w.material("white", CORNELL_WHITE, lambert=True)
    red = w.material("red", CORNELL_RED, lambert=True)
    green = w.material("green", CORNELL_GREEN, lambert=True)
    lamp = w.material("lamp", CORNELL_LAMP, lambert=True)

    room = sheet((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2))
    room.append(sheet((549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)))
    # The ceiling is cut out around the lamp (213..343 x 227..332), so that no two surfaces share a place.
    y = 548.8
    for x0, z0, x1, z1 in ((0, 0, 556, 227), (0, 332, 556, 559.2), (0, 227, 213, 332), (343, 227, 556, 332)):
        room.append(sheet((x1, y, z0), (x1, y, z1), (x0, y, z1), (x0, y, z0)))
    w.node("room", w.mesh("room", [(room, white)]))
    w.node("lamp", w.mesh("lamp", [(sheet((343, y, 227), (343, y, 332), (213, y, 332), (213, y, 227)), lamp)]))
    left = sheet((552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0))
    right = sheet((0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2))
    w.node("left wall", w.mesh("left wall", [(left, red)]))
    w.node("right wall", w.mesh("right wall", [(right, green)]))
    for name, ring, height in (("short block", ((130, 65), (82, 225), (240, 272), (290, 114)), 165),
                               ("tall block", ((423, 247), (265, 296), (314, 456), (472, 406)), 330)):
        ring = [(at(x, 0, z)[0], at(x, 0, z)[2]) for x, z in ring]
        w.node(name, w.mesh(name, [(shapes.prism(ring, 0, height / 100), white)]))
    return w


def basic(_):
    """The test scene of Y. ten Brug's thesis "Real-time Global Illumination" (Utrecht 2017, section 5.1): a floor, a red
    sphere and a white cube whose near side takes the sphere's colour. All pure Lambert, as the thesis'."""
    w = Writer(basic.__doc__)
    grey = w.material("floor", (0.6, 0.6, 0.6), lambert=True)
    red = w.material("red", (0.75, 0.06, 0.05), lambert=True)
    white = w.material("white", (0.75, 0.75, 0.75), lambert=True)
    w.node("floor", w.mesh("floor", [(shapes.box((-4, -.25, -4), (4, 0, 4)), grey)]))
    w.node("sphere", w.mesh("sphere", [(shapes.sphere(.75), red)]), translation=(-1.2, .75, 0))
    w.node("cube", w.mesh("cube", [(shapes.box((-.75, 0, -.75), (.75, 1.5, .75)), white)]), translation=(.95, 0, 0))
    return w


def furnace(options):
    """Closed room whose every surface emits radiance 0.5 and reflects half: radiance is 1 everywhere (docs/accuracy.md, row A1)."""
    w = Writer(furnace.__doc__)
    wall = w.material("wall", (0.5, 0.5, 0.5), emission=(0.5, 0.5, 0.5), lambert=True)
    for i, slab in enumerate(shapes.shell((-2, 0, -2.5), (2, 3, 2.5), options.thickness or 0.25)):
        w.node(f"wall {i}", w.mesh(f"wall {i}", [(slab, wall)]))
    return w


def leak(options):
    """Sealed dark room with a white ball in it, to be lit from outside: no light may reach the inside, whatever the
    thickness of the walls (here {} m)."""
    thickness = options.thickness or 0.06
    w = Writer(leak.__doc__.format(thickness))
    wall = w.material("wall", (0.02, 0.02, 0.02), lambert=True)
    ball = w.material("ball", (0.8, 0.8, 0.8), lambert=True)
    for i, slab in enumerate(shapes.shell((-1.5, 0, -1.5), (1.5, 3, 1.5), thickness)):
        w.node(f"wall {i}", w.mesh(f"wall {i}", [(slab, wall)]))
    w.node("ball", w.mesh("ball", [(shapes.sphere(.6, 32, 16), ball)]), translation=(0, 1.2, 0))
    return w


def glass(_):
    """Light through matter, in a small room with a chequered floor that is open to the front: a clear ball, a tinted slab, a
    frosted pane, and a leaf that scatters light to its other side."""
    w = Writer(glass.__doc__)
    white, red, blue = (w.material(name, color, lambert=True) for name, color in
                        (("white", (.7, .7, .7)), ("red", (.6, .08, .06)), ("blue", (.08, .15, .6))))
    dark = w.material("dark", (.1, .1, .1), lambert=True)
    clear = w.material("clear", (1, 1, 1), roughness=0.0, transmission=1.0, volume=(1.0, 1.0, (1, 1, 1)))
    green = w.material("green", (1, 1, 1), roughness=0.0, transmission=1.0, volume=(.2, .3, (.2, .8, .4)))
    frosted = w.material("frosted", (.95, .8, .6), roughness=.35, transmission=.9, double_sided=True)
    leaf = w.material("leaf", (.25, .5, .1), lambert=True, double_sided=True, diffuse_transmission=(.5, (.5, .8, .1)))

    squares = {white: Mesh(), dark: Mesh()}
    for i in range(8):
        for k in range(8):
            x, z = -2 + .5 * i, -2 + .5 * k
            squares[dark if (i + k) % 2 else white].append(shapes.box((x, -.2, z), (x + .5, 0, z + .5)))
    w.node("floor", w.mesh("floor", [(mesh, material) for material, mesh in squares.items()]))
    for name, low, high, material in (("ceiling", (-2.2, 3, -2.2), (2.2, 3.2, 2.2), white),
                                      ("back", (-2.2, -.25, -2.2), (2.2, 3.1, -2), white),
                                      ("left", (-2.2, -.2, -2.1), (-2, 3.1, 2.2), red),
                                      ("right", (2, -.2, -2.1), (2.2, 3.1, 2.2), blue)):
        w.node(name, w.mesh(name, [(shapes.box(low, high), material)]))
    w.node("ball", w.mesh("ball", [(shapes.sphere(.5, 64, 32), clear)]), translation=(-.6, .55, .6))
    w.node("slab", w.mesh("slab", [(shapes.box((-.5, 0, -.1), (.5, 1, .1)), green)]), translation=(.8, .05, .4),
           rotation=about_y(25))
    w.node("pane", w.mesh("pane", [(shapes.quad((-.6, 0, 0), (.6, 0, 0), (.6, 1.2, 0), (-.6, 1.2, 0)), frosted)]),
           translation=(-.9, .05, -1), rotation=about_y(-20))
    w.node("leaf", w.mesh("leaf", [(shapes.quad((-.5, 0, -.4), (-.5, 0, .4), (.5, 0, .4), (.5, 0, -.4)), leaf)]),
           translation=(.9, 1.7, -.7), rotation=(math.sin(.2), 0, 0, math.cos(.2)))
    return w


def hills(_):
    """Gentle hills, 48 m wide: their indirect light varies smoothly, so that steps between levels of voxels show."""
    w = Writer(hills.__doc__)
    ground = w.material("ground", (0.55, 0.5, 0.4), lambert=True)
    w.node("hills", w.mesh("hills", [(shapes.height_field(48.0, 64, hill), ground)]))
    return w


def hill(x, z):
    """Height, and its slopes along x and z."""
    a, b = 0.35 * x, 0.3 * z
    c = 0.5 * x + 0.6 * z
    return (1.6 * math.sin(a) * math.cos(b) + 0.7 * math.sin(c),
            0.56 * math.cos(a) * math.cos(b) + 0.35 * math.cos(c),
            -0.48 * math.sin(a) * math.sin(b) + 0.42 * math.cos(c))


def about_y(degrees):
    return (0.0, math.sin(math.radians(degrees) / 2), 0.0, math.cos(math.radians(degrees) / 2))


def column_profile(radius, height):
    """Tuscan column: square-edged base, torus, shaft with a slight entasis, neck ring, capital. (radius, y) pairs."""
    r, points = radius, []

    def edge(*pts):
        for i, p in enumerate(pts):
            points.append(p)
            if 0 < i < len(pts) - 1:
                points.append(p)

    edge((1.45 * r, 0.0), (1.45 * r, .28 * r), (1.3 * r, .28 * r))
    points.append(points[-1])
    points += [(r * (1.12 + .2 * math.cos(a)), r * (.48 + .2 * math.sin(a))) for a in
               (-math.pi / 3, 0, math.pi / 3)]
    points.append((1.06 * r, .72 * r))
    points.append(points[-1])
    shaft, top = .72 * r, height - 1.1 * r
    points += [(r * (1 - .16 * (i / 6) ** 1.8), shaft + (top - shaft) * i / 6) for i in range(7)]
    points.append(points[-1])
    points += [(r * (.95 + .08 * math.cos(a)), top + r * (.1 + .1 * math.sin(a))) for a in (-math.pi / 2.5, 0, math.pi / 2.5)]
    points.append((.86 * r, top + .25 * r))
    points.append(points[-1])
    points += [(.9 * r, top + .45 * r), (1.05 * r, top + .62 * r), (1.35 * r, top + .72 * r)]
    points.append(points[-1])
    edge_top = [(1.45 * r, top + .72 * r), (1.45 * r, height)]
    points += [edge_top[0], edge_top[0], edge_top[1]]
    return points


def vase_profile(height):
    r = height / 2.2
    half = [(.42, 0), (.45, .03), (.38, .08), (.42, .16), (.62, .3), (.78, .46), (.82, .58), (.74, .72), (.52, .84), (.4, .9),
            (.46, .96), (.5, 1)]
    return [(x * r, y * height) for x, y in half]


def atrium(_):
    """Two-storey colonnade around an open court, about 30 x 12 x 18 m: arcades on round columns, galleries, coloured
    curtains, bronze vases and a fountain. For a low sun through the open roof."""
    w = Writer(atrium.__doc__)
    stone = w.material("wall stone", (.55, .47, .37), roughness=.85)
    pale = w.material("column stone", (.62, .57, .48), roughness=.6)
    floor = w.material("polished floor", (.42, .38, .34), roughness=.3)
    gallery_floor = w.material("gallery floor", (.5, .4, .3), roughness=.5)
    bronze = w.material("bronze", (.75, .48, .25), roughness=.35, metallic=1.0)
    basin = w.material("basin", (.55, .55, .53), roughness=.45)
    cloth = [w.material(f"{name} cloth", color, roughness=.95, double_sided=True) for name, color in
             (("red", (.62, .06, .05)), ("green", (.08, .38, .10)), ("blue", (.06, .12, .50)))]

    # Plan: court 20 x 8, arcades 4.6 deep around it, outer wall 0.4. Heights: gallery floor 5.6 to 6, roof 11.4 to 11.8.
    cx, cz, bx, bz, t = 10.0, 4.0, 14.6, 8.6, .4
    w.node("ground", w.mesh("ground", [(shapes.box((-bx - t - .1, -.4, -bz - t - .1), (bx + t + .1, 0, bz + t + .1)), floor)]))
    walls = Mesh()
    for low, high in (((-bx - t, -.1, -bz - t), (bx + t, 12, -bz)), ((-bx - t, -.1, bz), (bx + t, 12, bz + t)),
                      ((-bx - t, -.1, -bz - t / 2), (-bx, 12, bz + t / 2)), ((bx, -.1, -bz - t / 2), (bx + t, 12, bz + t / 2))):
        # Side walls are shorter by a finger, so that their tops and ends are not in one plane with the long walls'.
        if low[2] == -bz - t / 2:
            low, high = (low[0] + (.05 if low[0] < 0 else 0), low[1] + .02, low[2]), \
                        (high[0] - (.05 if low[0] > 0 else 0), high[1] - .02, high[2])
        walls.append(shapes.box(low, high))
    w.node("outer walls", w.mesh("outer walls", [(walls, stone)]))

    def ring(y0, y1, overhang):
        """Floor of the arcades: four slabs, those on the long sides first; the others run half a finger into them."""
        mesh = Mesh()
        ix, iz = cx - overhang, cz - overhang
        mesh.append(shapes.box((-bx - t / 4, y0, -bz - t / 4), (bx + t / 4, y1, -iz)))
        mesh.append(shapes.box((-bx - t / 4, y0, iz), (bx + t / 4, y1, bz + t / 4)))
        for low, high in ((-bx - t / 5, -ix), (ix, bx + t / 5)):
            mesh.append(shapes.box((low, y0, -iz), (high, y1, iz)))
        return mesh

    w.node("gallery", w.mesh("gallery", [(ring(5.6, 6.0, .45), gallery_floor)]))
    w.node("roof", w.mesh("roof", [(ring(11.4, 11.8, .45), stone)]))

    # Eight bays of 2.5 m along the court, three of 2.667 m across; columns stand at the bays' ends.
    long_bays, short_bays = 8, 3
    places = [(-cx + 2 * cx * i / long_bays, side * cz) for side in (-1, 1) for i in range(long_bays + 1)]
    places += [(side * cx, -cz + 2 * cz * i / short_bays) for side in (-1, 1) for i in range(1, short_bays)]
    lower = w.mesh("column", [(shapes.lathe(column_profile(.32, 3.7), 18), pale)])
    upper = w.mesh("upper column", [(shapes.lathe(column_profile(.25, 3.7), 16), pale)])
    plinth = w.mesh("plinth", [(shapes.box((-.5, -.05, -.5), (.5, .12, .5)), pale)])
    # Abutments carry the arches' feet: they close the gap between two panels above a column.
    abutment = w.mesh("abutment", [(shapes.box((-.36, 3.72, -.36), (.36, 4.0, .36)), pale)])
    for i, (x, z) in enumerate(places):
        w.node(f"plinth {i}", plinth, (x, 0, z))
        w.node(f"column {i}", lower, (x, .1, z))
        w.node(f"abutment {i}", abutment, (x, 0, z))
        w.node(f"upper plinth {i}", plinth, (x, 6, z), scale=(.8, 1, .8))
        w.node(f"upper column {i}", upper, (x, 6.1, z))
        w.node(f"upper abutment {i}", abutment, (x, 6, z), scale=(.85, 1, .85))
    for bays, length, name in ((long_bays, 2 * cx, "long"), (short_bays, 2 * cz, "short")):
        width = length / bays
        for y, storey, depth in ((0, "lower", .5), (5.9, "upper", .42)):
            mesh = w.mesh(f"{storey} {name} arch", [(shapes.arch(width, 3.9, 5.65 if y == 0 else 5.55, depth), stone)])
            for side in (-1, 1):
                for i in range(bays):
                    along = -length / 2 + width * (i + .5)
                    at = (along, y, side * cz) if name == "long" else (side * cx, y, along)
                    w.node(f"{storey} {name} arch {side} {i}", mesh, at, about_y(0 if name == "long" else 90))

    # Balustrade of the gallery: rail and balusters between the columns of the long sides.
    rail = w.mesh("rail", [(shapes.box((-cx, 6.95, -.09), (cx, 7.08, .09)), pale)])
    baluster = w.mesh("baluster", [(shapes.lathe([(.07, 0), (.09, .08), (.05, .22), (.085, .45), (.085, .52), (.045, .78),
                                                  (.08, .9), (.08, .98)], 8), pale)])
    for side in (-1, 1):
        w.node(f"rail {side}", rail, (0, 0, side * cz))
        for bay in range(long_bays):
            for k in range(1, 5):
                w.node(f"baluster {side} {bay} {k}", baluster, (-cx + (bay + k / 5) * 2 * cx / long_bays, 5.99, side * cz))

    hanging = [w.mesh(f"curtain {i}", [(shapes.curtain(1.5, 3.0, 5, .09), c)]) for i, c in enumerate(cloth)]
    for n, (side, bay) in enumerate(((-1, 1), (1, 0), (-1, 3), (1, 2), (-1, 5), (1, 4), (-1, 6), (1, 6), (-1, 0), (1, 7))):
        x = -cx + (bay + .5) * 2 * cx / long_bays
        w.node(f"curtain {n}", hanging[n % 3], (x, 4.1, side * (cz + .55)))
    banner = [w.mesh(f"banner {i}", [(shapes.curtain(2.2, 4.4, 3, .12), cloth[i])]) for i in (0, 2)]
    for n, (x, z, turn, kind) in enumerate(((-bx + .6, -2, 90, 0), (-bx + .6, 2, 90, 1), (bx - .6, -2, 90, 1), (bx - .6, 2, 90, 0))):
        w.node(f"banner {n}", banner[kind], (x, 5.3, z), about_y(turn))

    vase = w.mesh("vase", [(shapes.lathe(vase_profile(1.1), 24), bronze)])
    stand = w.mesh("stand", [(shapes.box((-.35, -.02, -.35), (.35, .5, .35)), pale)])
    for n, (x, z) in enumerate(((-8, -2.9), (8, -2.9), (-8, 2.9), (8, 2.9))):
        w.node(f"stand {n}", stand, (x, 0, z))
        w.node(f"vase {n}", vase, (x, .49, z))
    bowl = [(1.5, -.05), (1.6, .35), (1.65, .6), (1.65, .6), (1.4, .6), (1.4, .6), (1.3, .3), (.3, .25), (.3, .25), (.25, 1.0),
            (.25, 1.0), (.5, 1.15), (.75, 1.35), (.75, 1.35), (.62, 1.33), (.2, 1.2)]
    w.node("fountain", w.mesh("fountain", [(shapes.lathe(bowl, 40), basin)]))
    return w


ROUGHNESSES = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0)


def spheres(_):
    """Six dielectric spheres below six metal ones, roughness 0, 0.1, 0.25, 0.5, 0.75 and 1 from left to right, over a glossy
    floor whose strips have the roughness of the spheres above them. Back and side walls are Lambert, ceiling and front are
    open to the sky. spheres.hdr is the sky: a gradient with a bright patch behind the camera and a dark ground."""
    w = Writer(spheres.__doc__)
    width = 1.2
    left = -width * len(ROUGHNESSES) / 2
    floor = []
    for i, roughness in enumerate(ROUGHNESSES):
        x0, x1, y0, y1, z0, z1 = left + i * width, left + (i + 1) * width, -.3, 0.0, -2.5, 2.5
        strip = Mesh()  # strips share their edges, so that the floor welds to one solid
        for corners in (((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
                        ((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)),
                        ((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)),
                        ((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1))):
            strip.append(shapes.quad(*corners))
        if i == 0:
            strip.append(shapes.quad((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)))
        if i == len(ROUGHNESSES) - 1:
            strip.append(shapes.quad((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)))
        floor.append((strip, w.material(f"floor {roughness}", (.35, .33, .3), roughness)))
    w.node("floor", w.mesh("floor", floor))
    # Walls stand on the floor by a finger's overlap, so that no two faces lie in one plane.
    right = -left
    for name, color, low, high in (("back wall", (.6, .58, .5), (left + .02, -.1, -2.48), (right - .02, 3.2, -2.2)),
                                   ("left wall", (.63, .065, .05), (left + .04, -.12, -2.3), (left + .3, 2.5, 2.2)),
                                   ("right wall", (.12, .2, .55), (right - .3, -.12, -2.3), (right - .04, 2.5, 2.2))):
        w.node(name, w.mesh(name, [(shapes.box(low, high), w.material(name, color, lambert=True))]))
    ball = shapes.sphere(.42, 48, 24)
    for row, color, metallic, y in (("metal", (.95, .93, .88), 1.0, 1.9), ("dielectric", (.1, .3, .15), 0.0, .66)):
        for i, roughness in enumerate(ROUGHNESSES):
            name = f"{row} {roughness}"
            w.node(name, w.mesh(name, [(ball, w.material(name, color, roughness, metallic))]),
                   translation=(.9 * (left + (i + .5) * width), y, 0))
    w.files["spheres.hdr"] = rgbe(64, 32, spheres_sky)
    return w


def spheres_sky(x, y, z):
    """Radiance from direction (x, y, z)."""
    if y < 0:
        return (.10, .09, .08)
    up = 1 - (1 - y) ** 3
    sky = [a + (b - a) * up for a, b in zip((.9, .85, .8), (.25, .45, .9))]
    patch = 6 * math.exp(-12 * (1 - (.45 * x + .4 * y + .8 * z) / math.sqrt(.45 ** 2 + .4 ** 2 + .8 ** 2)))
    return [c + patch * tint for c, tint in zip(sky, (1, .9, .75))]


def rgbe(width, height, radiance):
    """An equirectangular panorama as a Radiance file without compression; the middle column lies at -z."""
    out = bytearray(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode())
    for row in range(height):
        polar = math.pi * (row + .5) / height
        for column in range(width):
            around = 2 * math.pi * ((column + .5) / width - .5)
            color = radiance(math.sin(polar) * math.sin(around), math.cos(polar), -math.sin(polar) * math.cos(around))
            exponent = math.frexp(max(color))[1]
            out += bytes([*(int(c * 256 / 2 ** exponent) for c in color), exponent + 128])
    return bytes(out)


def main():
    makers = {f.__name__: f for f in (cornell, basic, furnace, leak, atrium, hills, spheres, glass)}
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", help=f"some of {', '.join(makers)}; default all")
    parser.add_argument("--out", type=Path, default=SCENES, help="folder to write to")
    parser.add_argument("--thickness", type=float, help="wall thickness of furnace (default 0.25) and leak (0.06), metres")
    parser.add_argument("--check", action="store_true", help="compare with the committed files instead of writing them")
    options = parser.parse_args()
    unknown = [s for s in options.scenes if s not in makers]
    if unknown:
        parser.error(f"unknown scene {unknown[0]}; there are {', '.join(makers)}")

    stale = []
    for name in options.scenes or makers:
        writer = makers[name](options)
        if options.check:
            with tempfile.TemporaryDirectory() as folder:
                writer.write(Path(folder) / f"{name}.gltf")
                stale += [file.name for file in sorted(Path(folder).iterdir()) if
                          file.read_bytes() != (options.out / file.name).read_bytes()]
        else:
            writer.write(options.out / f"{name}.gltf")
            print(f"{name}: {writer.triangles()} triangles")
    if stale:
        sys.exit(f"not what generate.py writes: {', '.join(stale)}")


if __name__ == "__main__":
    main()
