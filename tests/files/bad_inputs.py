# ruff: noqa: E501 (a line for each case reads as a table)
"""Malformed and nasty mesh files, made on the spot: each with what a reader should make of it."""

import base64
import json
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

HEADER = "ply\nformat {0} 1.0\nelement vertex {1}\nproperty float x\nproperty float y\nproperty float z\n"
FACES = "element face {0}\nproperty list {1} int vertex_indices\nend_header\n"


@dataclass(frozen=True)
class Case:
    """A file and its fate: `says` is a part of the error, or of a warning where `faces` is given."""

    name: str
    data: bytes
    says: str = ""
    faces: int | None = None
    components: int | None = None
    loops: int | None = None
    check: Callable | None = None


def ball(columns=12, rows=8):
    """Vertices and faces of a closed sphere of radius 1, poles up and down."""
    tilt, turn = np.meshgrid(
        np.arange(1, rows) * np.pi / rows, np.arange(columns) * 2 * np.pi / columns, indexing="ij"
    )
    rings = np.stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)], -1).reshape(
        -1, 3
    )
    vertices = np.concatenate([[[0, 0, 1]], rings, [[0, 0, -1]]])
    faces, last = [], len(vertices) - 1
    for i in range(columns):
        j = (i + 1) % columns
        faces.append([0, 1 + i, 1 + j])
        for r in range(rows - 2):
            a, b = 1 + r * columns + i, 1 + r * columns + j
            faces += [[a, a + columns, b], [b, a + columns, b + columns]]
        faces.append([1 + (rows - 2) * columns + i, last, 1 + (rows - 2) * columns + j])
    return vertices, np.array(faces)


def sheet(cells=6):
    """Vertices and faces of a square of side 1 with `cells` squares along each side."""
    x, y = np.meshgrid(np.linspace(0, 1, cells + 1), np.linspace(0, 1, cells + 1))
    vertices = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1)
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    return vertices, np.concatenate(
        [np.stack([a, a + 1, a + cells + 2], 1), np.stack([a, a + cells + 2, a + cells + 1], 1)]
    )


def obj(vertices, faces, *, uv=None, before="", after=""):
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices]
    lines += [f"vt {u:.9g} {v:.9g}" for u, v in (uv if uv is not None else [])]
    corner = "{0}/{0}" if uv is not None else "{0}"
    lines += ["f " + " ".join(corner.format(i + 1) for i in face) for face in faces]
    return (before + "\n".join(lines) + "\n" + after).encode()


def stl(vertices, faces, *, header=b"", after=b"", count=None):
    records = np.zeros(len(faces), np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]))
    records["c"] = vertices[faces]
    return (
        header.ljust(80)
        + struct.pack("<I", len(faces) if count is None else count)
        + records.tobytes()
        + after
    )


def stl_text(vertices, faces):
    lines = ["solid ball"]
    for face in vertices[faces]:
        lines += [" facet normal 0 0 0", "  outer loop"]
        lines += [f"   vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in face]
        lines += ["  endloop", " endfacet"]
    return "\n".join([*lines, "endsolid ball", ""]).encode()


def ply(vertices, faces):
    head = HEADER.format("binary_little_endian", len(vertices)) + FACES.format(len(faces), "uchar")
    rows = np.zeros(len(faces), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
    rows["n"], rows["i"] = 3, faces
    return head.encode() + vertices.astype("<f4").tobytes() + rows.tobytes()


def off(vertices, faces):
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [f"{x} {y} {z}" for x, y, z in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    return "\n".join(lines).encode()


def document(vertices, faces, *, uv=None, **changes):
    """A glTF document and its binary chunk; `changes` maps dotted places of the document to values."""
    binary = vertices.astype("<f4").tobytes() + faces.astype("<u4").tobytes()
    doc = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 12 * len(vertices)},
            {"buffer": 0, "byteOffset": 12 * len(vertices), "byteLength": 12 * len(faces)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"},
        ],
    }  # fmt: skip
    for place, value in changes.items():
        at, *rest = [int(word) if word.isdigit() else word for word in place.split("__")][::-1]
        target = doc
        for word in rest[::-1]:
            target = target[word]
        target[at] = value
    return doc, binary


def glb(vertices, faces, **changes):
    doc, binary = document(vertices, faces, **changes)
    return glb_of(doc, binary)


def glb_of(doc, binary):
    text = json.dumps(doc).encode() if isinstance(doc, dict) else doc
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    body = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def gltf(vertices, faces, uri=None, **changes):
    doc, binary = document(vertices, faces, **changes)
    doc["buffers"][0]["uri"] = (
        uri or "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    )
    return json.dumps(doc).encode()


def _outward(surface):
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    return np.einsum("fi,fi->", a, np.cross(b, c)) > 0


def _area(expected):
    return lambda surface: abs(surface.area_mm2 - expected) < 1e-6 * expected


def cases() -> list[Case]:
    """All of them; sizes are for a longest side of 300 mm."""
    v, f = ball()
    flat, quads = sheet()
    three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    half = len(f) // 3
    ring, strip = _moebius()
    whole = {"faces": 168, "components": 1, "loops": 0, "check": _outward}
    ascii_ply = HEADER.format("ascii", 3) + FACES.format(1, "int") + "0 0 0\n1 0 0\n0 1 0\n"
    return [
        Case("empty.obj", b"", "is empty"),
        Case("empty.ply", b"", "is empty"),
        Case("text.stl", b"Dear reader, this is a letter and no mesh at all. " * 3, "is no STL file"),
        Case("short text.stl", b"hello", "is no STL file"),
        Case("truncated.glb", glb(v, f)[:1500], "cut short: it declares"),
        Case("magic.glb", b"glTX" + glb(v, f)[4:], "does not begin with 'glTF'"),
        Case("json.glb", glb_of(b'{"asset": nonsense', b""), "JSON does not parse"),
        Case("deep.gltf", b"[" * 100000, "JSON"),
        Case("list.gltf", b"[1, 2]", "no glTF document"),
        Case("version.glb", glb(v, f, asset__version="1.0"), "reads glTF 2"),
        Case("nan.obj", b"v 0 0 0\nv nan 0 0\nv 0 1 0\nv 1 1 inf\nf 1 2 3\nf 2 4 3\n", "vertex 2, line 2"),
        Case("unused nan.obj", (three + "v nan 0 0\nf 1 2 3\n").encode(), "1 vertex that no face uses", 1),
        Case("outside.obj", (three + "f 1 2 7\n").encode(), "line 4: a face refers to vertex 7 of 3"),
        Case("relative.obj", (three + "f -3 -2 -1\nv 1 1 0\nf -3 -1 -2\n").encode(), "", 2, 1, 1),
        Case("relative outside.obj", (three + "f -9 -2 -1\n").encode(), "line 4: relative index -9"),
        Case("zero.obj", (three + "f 0 1 2\n").encode(), "line 4: a face uses index 0"),
        Case("points.obj", three.encode(), "no faces"),
        Case("word.obj", b"v 0 0 zero\n" + (three + "f 1 2 3\n").encode(), "line 1: 'zero' is not a number"),
        Case("short vertex.obj", b"v 0 0\n" + (three + "f 1 2 3\n").encode(), "line 1 has 2 numbers"),
        Case("odd corner.obj", (three + "f 1 2 3x\n").encode(), "line 4: '3x'"),
        Case("four indices.obj", (three + "f 1/1/1/1 2 3\n").encode(), "line 4: '1/1/1/1'"),
        Case("huge index.obj", (three + "f 1 2 99999999999999999999\n").encode(), "line 4"),
        Case("two.obj", (three + "f 1 2\nf 1 2 3\n").encode(), "1 face of fewer than 3 corners", 1),
        Case("tabs.obj", b"# c\r\nv\t0 0  0\r\n v 1 0 0 # x\r\nv 0 1 0\r\n\r\nf 1//  2 3\r\n", "", 1, 1, 1),
        Case("joined.obj", (three + "v 1 1 0\nf 1 2 \\\n4 3\n").encode(), "", 2, 1, 1),
        Case("mac.obj", (three + "f 1 2 3\n").replace("\n", "\r").encode(), "", 1, 1, 1),
        Case("utf16.obj", (three + "f 1 2 3\n").encode("utf-16"), "UTF-16"),
        Case("long.obj", obj(flat, [np.arange(60000) % 49]), "concave and has 60000 corners"),
        Case("no records.obj", ascii_ply.encode() + b"3 0 1 2\n", "looks like a PLY"),
        Case("ascii.stl", stl_text(v, f), **whole),
        Case("odd vertices.stl", stl_text(v, f).replace(b"vertex", b"vortex", 1), "no whole number of triangles"),
        Case("billions.stl", stl(v, f[:2], count=2**32 - 1), "claims 4294967295 triangles"),
        Case("solid.stl", stl(v, f, header=b"solid but binary"), **whole),
        Case("trailing.stl", stl(v, f, after=b"x" * 37), "37 bytes after the last triangle", **whole),
        Case("nan.stl", stl(np.where(v > 0.99, np.nan, v), f), "not finite"),
        Case("no triangles.stl", stl(v, f[:0]), "no triangles"),
        Case("billions.ply", (HEADER.format("binary_little_endian", 10**9) + FACES.format(10**6, "uchar")).encode() + b"\0" * 120,
             "claims 1000000000 records"),
        Case("lying list.ply", (HEADER.format("binary_little_endian", 3) + FACES.format(1, "int")).encode()
             + np.eye(3, dtype="<f4").tobytes() + struct.pack("<4i", 2 * 10**9, 0, 1, 2), "list of 2000000000"),
        Case("negative list.ply", (ascii_ply + "-3 0 1 2\n").encode(), "list of -3"),
        Case("index.ply", (ascii_ply + "3 0 1 9\n").encode(), "refers to vertex 9 of 3"),
        Case("word.ply", (ascii_ply + "3 0 1 two\n").encode(), "not numbers"),
        Case("head.ply", b"ply\nformat ascii 1.0\nelement vertex -3\nend_header\n", "line 3 of the header"),
        Case("no end.ply", b"ply\nformat ascii 1.0\n", "end_header"),
        Case("whole.ply", ply(v, f), **whole),
        Case("counts.off", b"OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n", "only 3 lines follow"),
        Case("bare.off", b"3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "does not begin with 'OFF'"),
        Case("size.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n9 0 1 2\n", "line 6: a face of 9 corners"),
        Case("index.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "line 6: a face refers to vertex 7"),
        Case("whole.off", off(v, f), **whole),
        Case("points.xyz", b"0 0 0\n1 0 0\n", "known are .obj"),
        Case("pläce 革.obj", obj(v, f), **whole),
        Case("esc\x1b[31m.obj", obj(v, f), **whole),
        Case("esc\x1b[31m empty.obj", b"", "\\x1b[31m empty.obj: is empty"),
        Case("line\nbreak.obj", b"", "line\\nbreak.obj: is empty"),
        Case("library.obj", obj(v, f, before="mtllib ../../etc/passwd\nmtllib /etc/hostname\n"), "2 'mtllib' lines", **whole),
        Case("network.gltf", gltf(v, f, "http://example.invalid/mesh.bin"), "network"),
        Case("file.gltf", gltf(v, f, "file:///etc/passwd"), "elsewhere"),
        Case("outside.gltf", gltf(v, f, "../../../etc/passwd"), "leaves the file's folder"),
        Case("escaped.gltf", gltf(v, f, "%2e%2e/%2e%2e/etc/passwd"), "leaves the file's folder"),
        Case("absolute.gltf", gltf(v, f, "/etc/passwd"), "leaves the file's folder"),
        Case("absent.gltf", gltf(v, f, "absent.bin"), "no such glTF buffer"),
        Case("bad address.gltf", gltf(v, f, "http://[/mesh.bin"), "buffers[0]"),
        Case("whole.gltf", gltf(v, f, images=[{"uri": "file:///etc/passwd"}]), **whole),
        Case("overrun.glb", glb(v, f, accessors__1__count=10**9), "claims 1000000000 elements"),
        Case("bytes of nothing.glb", glb(v, f, accessors__0={"componentType": 5126, "count": 10**9, "type": "VEC3"}), "without any bytes"),
        Case("far index.glb", glb(v, np.where(f == 5, 5000, f)), "refers to vertex 5000 of 86"),
        Case("cycle.glb", glb(v, f, nodes=[{"mesh": 0, "children": [0]}]), "cycle"),
        Case("rootless.glb", glb(v, f, scenes=[], nodes=[{"mesh": 0, "children": [0]}]), "cycle"),
        Case("flat scale.glb", glb(v, f, nodes=[{"mesh": 0, "scale": [0, 1, 1]}]), "scale of 0"),
        Case("mirror.glb", glb(v, f, nodes=[{"mesh": 0, "scale": [-1, 1, 1]}]), **whole),
        Case("mirror matrix.glb", glb(v, f, nodes=[{"mesh": 0, "matrix": [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 3, 4, 5, 1]}]), **whole),
        Case("nan scale.glb", glb(v, f, nodes=[{"mesh": 0, "scale": [float("nan"), 1, 1]}]), "finite numbers"),
        Case("draco.glb", glb(v, f, extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression"),
        Case("meshopt.glb", glb(v, f, extensionsRequired=["EXT_meshopt_compression"]), "EXT_meshopt_compression"),
        Case("harmless.glb", glb(v, f, extensionsRequired=["KHR_materials_unlit"]), **whole),
        Case("lines.glb", glb(v, f, meshes__0__primitives__0__mode=1), "only 1 of LINES"),
        Case("single.obj", (three + "f 1 2 3\n").encode(), "", 1, 1, 1),
        Case("zero area.obj", obj(flat, [*quads, [0, 0, 1], [3, 3, 3], [0, 1, 2]]), "3 degenerate faces", 72, 1, 1, _area(9e4)),
        Case("all degenerate.obj", obj(flat, [[0, 1, 2], [2, 3, 4]]), "no area"),
        Case("one place.obj", b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "no area"),
        Case("duplicates.obj", obj(v, [*f, *f[:25]]), "25 duplicate faces", **whole),
        Case("three at an edge.obj", b"v 0 0 0\nv 1 0 0\nv .5 1 0\nv .5 -1 0\nv .5 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n", "1 edge with more than two faces", 3, 2),
        Case("bow tie.obj", b"v 0 0 0\nv 1 1 0\nv 1 -1 0\nv -1 1 0\nv -1 -1 0\nf 1 3 2\nf 1 4 5\n", "1 vertex where sheets touch", 2, 2, 2),
        Case("winding.obj", obj(v, [*f[:half, ::-1], *f[half:]]), "56 faces were wound against", **whole),
        Case("inside out.obj", obj(v, f[:, ::-1]), "inside out", **whole),
        Case("unused.obj", obj(np.concatenate([[[1e9, 0, 0]], v]), f + 1), "1 vertex that no face uses", **whole),
        Case("shells.obj", obj(np.concatenate([v + np.array([3 * k, 0, 0]) for k in range(40)]), np.concatenate([f + 86 * k for k in range(40)])), "", 6720, 40, 0),
        Case("huge.obj", obj(v * 1e8, f), check=lambda s: np.isclose(s.area_mm2, 150**2 * 12, rtol=0.1), faces=168),
        Case("tiny.obj", obj(v * 1e-8, f), check=lambda s: np.isclose(s.area_mm2, 150**2 * 12, rtol=0.1), faces=168),
        Case("far.obj", obj(v + 1e7, f), check=lambda s: np.isclose(s.area_mm2, 150**2 * 12, rtol=0.1), faces=168),
        Case("overflow.obj", b"v 0 0 0\nv 1e308 0 0\nv 0 1e308 0\nf 1 2 3\n", "overflows"),
        Case("beyond doubles.obj", b"v 0 0 0\nv 1e999 0 0\nv 0 1e308 0\nf 1 2 3\n", "not finite"),
        Case("polygons.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nv 2.5 .5 0\nv .5 2 0\nf 1 2 3 4\nf 2 5 7 6 3\nf 4 3 8\n", "", 6, 1, 1),
        Case("concave.obj", b"v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 1 2 3 4 5\n", "", 3, 1, 1, _area(10 * 75**2)),
        Case("bent quad.obj", b"v 0 0 0\nv 1 0 1\nv 1 1 0\nv 0 1 1\nf 1 2 3 4\n", "", 2, 1, 1),
        Case("uv outside.obj", obj(flat, quads, uv=flat[:, :2] * 3 - 1), "UVs leave 0..1", 72, check=lambda s: s.corner_uv is not None),
        Case("uv flat.obj", obj(flat, quads, uv=flat[:, :2] * 0), "UV set 0 has no area", 72, check=lambda s: s.corner_uv is None),
        Case("uv nan.obj", obj(flat, quads, uv=np.where(np.arange(49)[:, None] == 3, np.nan, flat[:, :2])), "have no usable UVs", 72, check=lambda s: s.corner_uv is None),
        Case("uv in part.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 2 4 3\n", "1 of 2 faces have no usable UVs", 2, check=lambda s: s.corner_uv is None),
        Case("moebius.obj", obj(ring, strip), "one side only", len(strip), 1, 1),
        Case("crossing.obj", obj(np.concatenate([v, v + np.array([0.7, 0, 0])]), np.concatenate([f, f + 86])), "", 336, 2, 0),
        Case("needle.obj", b"v 0 0 0\nv 1 0 0\nv 0.5 1e-07 0\nv 0.5 1 0\nv 0.5 -1 0\nf 1 3 4\nf 3 2 4\nf 1 2 3\nf 2 1 5\n", "", 4, 1, 1),
        Case("t-junction.stl", stl(np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 0, 0], [0.2, -1, 0], [0.8, -1, 0]]), np.array([[0, 1, 2], [3, 0, 4], [3, 5, 1]])), "where sheets touch only at a point", 3, 3),
        Case("near duplicates.stl", stl(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1 + 4e-7, 0, 0], [1, 1, 0], [-3e-7, 1, 0]]), np.array([[0, 1, 2], [3, 4, 5]])), "", 2, 1, 1),
        Case("two-sided.obj", obj(flat, np.concatenate([quads, quads[:, ::-1]])), "72 duplicate faces", 72, 1, 1),
        Case("valence.obj", obj(*_umbrella(500)), "", 500, 1, 1),
    ]  # fmt: skip


def _moebius(columns=40):
    turn = np.arange(columns) * 2 * np.pi / columns
    rows = [(1 + w * np.cos(turn / 2), w * np.sin(turn / 2)) for w in (-0.3, 0.0, 0.3)]
    vertices = np.concatenate([np.stack([r * np.cos(turn), r * np.sin(turn), z], 1) for r, z in rows])
    faces = []
    for i in range(columns):
        for row in range(2):
            a, d = row * columns + i, (row + 1) * columns + i
            last = i + 1 == columns
            b = (2 - row) * columns if last else a + 1
            c = (1 - row) * columns if last else d + 1
            faces += [[a, b, c], [a, c, d]]
    return vertices, np.array(faces)


def _umbrella(count):
    turn = np.arange(count) * 2 * np.pi / count
    rim = np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1)
    ring = np.arange(count)
    return np.concatenate([rim, [[0, 0, 0.2]]]), np.stack(
        [ring, (ring + 1) % count, np.full(count, count)], 1
    )


def write(case: Case, folder: Path) -> Path:
    path = folder / case.name
    path.write_bytes(case.data)
    return path
