"""Writes small glTF 2.0 files (.gltf with one .bin beside it) from triangle meshes. Python standard library only.

Output depends on the input alone: coordinates are rounded to 1e-6 before they become 32-bit floats, so that the last digit
of a platform's sine does not show.
"""

import json
import struct
from pathlib import Path

FLOAT, UINT16, UINT32 = 5126, 5123, 5125


class Mesh:
    """Triangles with one normal and one texture coordinate a vertex. Counter-clockwise is the front."""

    def __init__(self):
        self.positions, self.normals, self.uvs, self.indices = [], [], [], []

    def add(self, position, normal, uv=(0.0, 0.0)):
        self.positions.append(position)
        self.normals.append(normal)
        self.uvs.append(uv)
        return len(self.positions) - 1

    def triangle(self, a, b, c):
        self.indices += [a, b, c]

    def append(self, other):
        base = len(self.positions)
        self.positions += other.positions
        self.normals += other.normals
        self.uvs += other.uvs
        self.indices += [base + i for i in other.indices]
        return self


def _rounded(values):
    # Adding 0.0 turns -0.0 into 0.0.
    return [round(v, 6) + 0.0 for v in values]


class Writer:
    def __init__(self, description):
        self.blob = bytearray()
        self.json = {
            "asset": {"version": "2.0", "generator": "voxcone assets/generate", "extras": {"description": description}},
            "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
            "accessors": [], "bufferViews": []}
        self.extensions = set()
        self.stored = {}  # id of a Mesh: it, and its accessors, written once
        self.files = {}  # name: bytes of what is written beside the scene

    def material(self, name, color, roughness=1.0, metallic=0.0, emission=None, lambert=False, double_sided=False,
                 transmission=None, volume=None, diffuse_transmission=None):
        """`color` is linear reflectance; `lambert` switches the specular lobe off (KHR_materials_specular, factor 0).
        `transmission` is a factor, `volume` (thickness, attenuation distance, attenuation colour), `diffuse_transmission`
        (factor, colour)."""
        m = {"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": [*color, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness}}
        if emission is not None:
            m["emissiveFactor"] = list(emission)
        extensions = {}
        if lambert:
            extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
        if transmission is not None:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": transmission}
        if volume is not None:
            thickness, distance, tint = volume
            extensions["KHR_materials_volume"] = {
                "thicknessFactor": thickness, "attenuationDistance": distance, "attenuationColor": list(tint)}
        if diffuse_transmission is not None:
            factor, tint = diffuse_transmission
            extensions["KHR_materials_diffuse_transmission"] = {
                "diffuseTransmissionFactor": factor, "diffuseTransmissionColorFactor": list(tint)}
        if extensions:
            m["extensions"] = extensions
            self.extensions.update(extensions)
        if double_sided:
            m["doubleSided"] = True
        self.json["materials"].append(m)
        return len(self.json["materials"]) - 1

    def _view(self, data, target):
        while len(self.blob) % 4:
            self.blob.append(0)
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data), "target": target})
        self.blob += data
        return len(self.json["bufferViews"]) - 1

    def _vectors(self, vectors, kind, bounds=False):
        width = len(vectors[0])
        flat = _rounded([c for v in vectors for c in v])
        accessor = {"bufferView": self._view(struct.pack(f"<{len(flat)}f", *flat), 34962),
                    "componentType": FLOAT, "count": len(vectors), "type": kind}
        if bounds:
            stored = struct.unpack(f"<{len(flat)}f", struct.pack(f"<{len(flat)}f", *flat))
            accessor["min"] = [min(stored[i::width]) for i in range(width)]
            accessor["max"] = [max(stored[i::width]) for i in range(width)]
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def _accessors(self, mesh):
        if id(mesh) in self.stored:
            return self.stored[id(mesh)][1]
        short = len(mesh.positions) < 65536
        data = struct.pack(f"<{len(mesh.indices)}{'H' if short else 'I'}", *mesh.indices)
        indices = {"bufferView": self._view(data, 34963), "componentType": UINT16 if short else UINT32,
                   "count": len(mesh.indices), "type": "SCALAR"}
        self.json["accessors"].append(indices)
        index = len(self.json["accessors"]) - 1
        accessors = {"attributes": {"POSITION": self._vectors(mesh.positions, "VEC3", bounds=True),
                                    "NORMAL": self._vectors(mesh.normals, "VEC3"),
                                    "TEXCOORD_0": self._vectors(mesh.uvs, "VEC2")}, "indices": index}
        self.stored[id(mesh)] = (mesh, accessors)
        return accessors

    def mesh(self, name, parts):
        """`parts` is a list of (Mesh, material index), one primitive each."""
        primitives = [{**self._accessors(mesh), "material": material} for mesh, material in parts]
        self.json["meshes"].append({"name": name, "primitives": primitives})
        return len(self.json["meshes"]) - 1

    def node(self, name, mesh, translation=None, rotation=None, scale=None):
        n = {"name": name, "mesh": mesh}
        if translation is not None:
            n["translation"] = _rounded(translation)
        if rotation is not None:
            n["rotation"] = _rounded(rotation)
        if scale is not None:
            n["scale"] = _rounded(scale)
        self.json["nodes"].append(n)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def triangles(self):
        accessors = self.json["accessors"]
        return sum(accessors[p["indices"]]["count"] // 3
                   for n in self.json["nodes"] for p in self.json["meshes"][n["mesh"]]["primitives"])

    def write(self, path):
        path = Path(path)
        if self.extensions:
            self.json["extensionsUsed"] = sorted(self.extensions)
        self.json["buffers"] = [{"uri": path.stem + ".bin", "byteLength": len(self.blob)}]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.with_suffix(".bin").write_bytes(bytes(self.blob))
        path.write_text(json.dumps(self.json, indent=1) + "\n")
        for name, content in self.files.items():
            path.with_name(name).write_bytes(content)
