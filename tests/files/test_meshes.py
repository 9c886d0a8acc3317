"""Each format says the same of one mesh; parts, units, UV sets and transforms come out as written."""

import json
import signal
import struct
from contextlib import suppress

import numpy as np
import pytest

import surftex
from surftex.errors import InputError, MeshFileError, RecipeError
from surftex.fields.sources import part_field
from surftex.files.meshes import load
from surftex.files.meshout import write_mesh
from surftex.files.scaling import named_unit
from surftex.surface.bodies import Bodies
from tests.files.bad_inputs import ball, document, glb, glb_of, gltf, obj, off, ply, sheet, stl, stl_text


def saved(folder, name, data):
    path = folder / name
    path.write_bytes(data)
    return path


def test_every_format_gives_the_same_surface(tmp_path):
    v, f = ball()
    data = {
        "a.obj": obj(v, f),
        "b.stl": stl(v, f),
        "c.stl": stl_text(v, f),
        "a.ply": ply(v, f),
        "a.off": off(v, f),
        "a.glb": glb(v, f),
        "a.gltf": gltf(v, f),
    }
    areas = []
    for name, content in data.items():
        surface = load(saved(tmp_path, name, content), size="2 m")
        assert (len(surface.vertices), len(surface.faces)) == (86, 168)
        assert surface.border_loops == 0
        areas.append(surface.area_mm2)
    assert np.ptp(areas) < 1e-5 * areas[0]


def test_gltf_is_metres_and_the_origin_comes_back(tmp_path):
    v, f = sheet()
    surface = load(saved(tmp_path, "a.glb", glb(v, f, nodes=[{"mesh": 0, "translation": [10, 0, 0]}])))
    assert surface.mm_per_unit == 1000
    assert surface.area_mm2 == pytest.approx(1e6)
    assert surface.origin_mm == pytest.approx([10500, 500, 0])
    assert (surface.vertices + surface.origin_mm).min(0) == pytest.approx([10000, 0, 0])


@pytest.mark.parametrize(
    ("side", "unit"),
    [
        (0.03, "m"),
        (0.4, "m"),
        (2.99, "m"),
        (3, "m"),  # 3 m and 3 cm are as far from 300 mm
        (3.01, "cm"),
        (34, "cm"),
        (94, "cm"),
        (96, "mm"),
        (300, "mm"),
        (4999, "mm"),
    ],
)
def test_units_are_guessed_by_size(tmp_path, side, unit):
    v, f = sheet()
    surface = load(saved(tmp_path, "a.obj", obj(v * side, f)))
    assert surface.mm_per_unit == {"m": 1000, "cm": 10, "mm": 1}[unit]
    assert any(f"taken as {unit}, " in line for line in surface.warnings)
    assert any("(units or size overrules this; --units, --size)" in line for line in surface.warnings)


@pytest.mark.parametrize(
    ("side", "taken", "other"),
    [
        (94.8, ("cm", "948"), ("mm", "94.8")),
        (95, ("mm", "95"), ("cm", "950")),
        (68, ("cm", "680"), ("mm", "68")),
        (133, ("mm", "133"), ("cm", "1330")),
        (2.99, ("m", "2990"), ("cm", "29.9")),
        (3.01, ("cm", "30.1"), ("m", "3010")),
        (66, ("cm", "660"), None),  # more than twice as far from 300 mm by ratio
        (135, ("mm", "135"), None),
        (30, ("cm", "300"), None),
        (4500, ("mm", "4500"), None),
    ],
)
def test_two_units_that_are_almost_as_likely_are_both_named(tmp_path, side, taken, other):
    v, f = sheet()
    warnings = load(saved(tmp_path, "a.obj", obj(v * side, f))).warnings
    (said,) = [line for line in warnings if "names no unit" in line]
    unit, length = taken
    assert f"taken as {unit}, its longest side is {length} mm" in said
    assert ("may as well" in said) == (other is not None)
    if other is not None:
        second, length = other
        assert (
            f"it may as well be {second} ({length} mm): --units {second} or --units {unit} settles it" in said
        )


@pytest.mark.parametrize(
    ("comment", "side", "unit"),
    [
        ("# ball, millimetres, y up", 75, "mm"),
        ("# This file uses centimeters as units for non-parametric coordinates.", 3, "cm"),
        ("#\n#Units: Meters", 4, "m"),
        ("# inches", 10, "in"),
        ("# millimetres", 3, "m"),  # 3 mm: nobody's mesh
        ("# metres, not millimetres", 75, "cm"),  # two names say nothing
        ("# a hall of 10 metres", 4, "cm"),
        ("# the Millimetresque; parameters", 75, "cm"),
        ("usemtl metres", 4, "cm"),
        ("vn 0 0 1\n" * 300 + "# millimetres", 75, "cm"),  # not at the head
    ],
)
def test_a_unit_that_comments_name_is_taken_where_it_is_plausible(tmp_path, comment, side, unit):
    v, f = sheet()
    path = saved(tmp_path, "a.obj", obj(v * side, f) + b"\n")
    path.write_bytes(comment.encode() + b"\n" + path.read_bytes())
    surface = load(path)
    assert surface.mm_per_unit == {"m": 1000, "cm": 10, "mm": 1, "in": 25.4}[unit]
    assert any("(units or size overrules this; --units, --size)" in line for line in surface.warnings)
    assert load(path, units="m").mm_per_unit == 1000


def test_comments_of_ply_name_units_too():
    assert named_unit(b"ply\nformat ascii 1.0\ncomment in inches\nelement vertex 3\n") == "in"


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl"])
@pytest.mark.parametrize("side", [0.3, 3, 60, 9000])
def test_what_surftex_has_written_is_in_millimetres_at_any_size(tmp_path, suffix, side):
    path = tmp_path / f"a.{suffix}"
    v, f = sheet()
    write_mesh(path, v * side, f)
    surface = load(path)
    assert surface.longest_side_mm == pytest.approx(side)
    assert not any("unit" in line for line in surface.warnings)
    assert load(path, units="cm").longest_side_mm == pytest.approx(10 * side)


@pytest.mark.parametrize(
    ("suffix", "head"),
    [
        ("obj", b"# made from surftex, millimetres\n"),
        ("obj", b"o surftex, millimetres\n"),
        ("obj", b"vn 0 0 1\n" * 300 + b"# surftex, millimetres\n"),
        ("stl", b"surftex, millimetres, scaled".ljust(80)),
    ],
)
def test_what_others_have_written_is_not_taken_for_its_own(tmp_path, suffix, head):
    path = tmp_path / f"a.{suffix}"
    v, f = sheet()
    write_mesh(path, v * 3, f)
    data = path.read_bytes()
    path.write_bytes(head + (data[80:] if suffix == "stl" else data.split(b"\n", 1)[1]))
    assert load(path).mm_per_unit == 1000


@pytest.mark.parametrize("side", [0.001, 6000])
def test_an_implausible_size_asks_for_a_unit(tmp_path, side):
    v, f = sheet()
    path = saved(tmp_path, "a.obj", obj(v * side, f))
    with pytest.raises(MeshFileError, match=r"give units or size \(--units, --size\)$"):
        load(path)
    assert load(path, units="in").mm_per_unit == 25.4
    assert not load(path, units="in").warnings


@pytest.mark.parametrize(
    "wrong", [{"units": "feet"}, {"size": "big"}, {"size": 0}, {"size": "-3 mm"}, {"size": "1e300 m"}]
)
def test_wrong_units_and_sizes_are_refused(tmp_path, wrong):
    path = saved(tmp_path, "a.obj", obj(*sheet()))
    with pytest.raises(RecipeError):
        load(path, **wrong)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"units": np.zeros(2)}, "unknown unit an array; known are"),
        ({"size": [1]}, "a list is not a length"),
        ({"part": 3}, r"part is an int; it takes a name$"),
        ({"crease": "sharp"}, "crease is 'sharp'; it takes one number"),
    ],
)
def test_arguments_of_other_types_are_told(tmp_path, wrong, says):
    path = saved(tmp_path, "a.obj", obj(*sheet()))
    with pytest.raises(InputError, match=says):
        surftex.load(path, **wrong)


def test_obj_corners_carry_their_own_uv_and_normals(tmp_path):
    text = (
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt .1 .2\nvt .3 .2\nvt .3 .4\nvt .5 .5 0\nvn 0 0 2\nvn 0 0.6 0.8\n"
        "f 1/1/1 2/2/1 3/3/1\nf 1/4/2 3/3/-1 4/-4/2\n"
    )
    surface = load(saved(tmp_path, "a.obj", text.encode()), units="m")
    assert len(surface.vertices) == 4
    assert surface.corner_uv == pytest.approx(
        np.array([[[0.1, 0.2], [0.3, 0.2], [0.3, 0.4]], [[0.5, 0.5], [0.3, 0.4], [0.1, 0.2]]])
    )
    assert surface.corner_normal == pytest.approx(np.array([[[0, 0, 1]] * 3, [[0, 0.6, 0.8]] * 3]))


def test_turned_faces_keep_uv_with_their_corners(tmp_path):
    v, f = sheet()
    mixed = f.copy()
    mixed[::3] = mixed[::3, ::-1]
    surface = load(saved(tmp_path, "a.obj", obj(v, mixed, uv=v[:, :2])), units="m")
    there = surface.vertices[surface.faces][..., :2] / 1000 + 0.5
    assert surface.corner_uv == pytest.approx(there)


def test_obj_parts_by_material_group_and_object(tmp_path):
    text = (
        "o Shoe\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n"
        "g sole\nusemtl Rubber Black\nf 1 2 3 4\ng upper\nusemtl Calf\nf 2 5 6 3\n"
    )
    path = saved(tmp_path, "a.obj", text.encode())
    surface = load(path, units="m")
    assert surface.part_names == ("Rubber Black", "Calf")
    assert surface.part.tolist() == [0, 0, 1, 1]
    for name in ("calf", "CALF", "upper", "cal"):
        part = load(path, units="m", part=name)
        assert len(part.faces) == 2
        assert part.part_names == ("Calf",)
        assert part.origin_mm == pytest.approx([1500, 500, 0])
    assert len(load(path, units="m", part="Shoe").faces) == 4
    with pytest.raises(MeshFileError, match="did you mean 'Calf'"):
        load(path, units="m", part="clf")


def test_the_size_is_that_of_the_whole_file_not_of_the_part(tmp_path):
    v, f = sheet()
    text = (
        obj(np.concatenate([v, v + np.array([3, 0, 0])]), f)
        + b"usemtl second\n"
        + b"".join(b"f %d %d %d\n" % tuple(t) for t in f + 50)
    )
    surface = load(saved(tmp_path, "a.obj", text), size="400 mm", part="second")
    assert (surface.vertices.max(0) - surface.vertices.min(0)).max() == pytest.approx(100)


def test_stl_solids_are_parts(tmp_path):
    v, f = sheet()
    text = stl_text(v, f).replace(b"solid ball", b"solid left") + stl_text(
        v + np.array([2, 0, 0]), f
    ).replace(b"solid ball", b"solid right")
    surface = load(saved(tmp_path, "a.stl", text), units="m", part="Right")
    assert len(surface.faces) == 72
    assert surface.origin_mm[0] == pytest.approx(2500)


@pytest.mark.parametrize("names", [("s", "t"), ("u", "v"), ("texture_u", "texture_v")])
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_uvs_and_mixed_polygons(tmp_path, names, form):
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0.5, 0]], float)
    rows = np.column_stack([points, points[:, :2] / 4])
    head = f"ply\nformat {form} 1.0\ncomment x\nelement vertex 5\nproperty double x\nproperty double y\nproperty double z\n"
    head += "".join(f"property double {n}\n" for n in names)
    head += "element face 2\nproperty uchar flags\nproperty list uchar int vertex_index\nend_header\n"
    if form == "ascii":
        body = (
            "".join(" ".join(map(repr, map(float, row))) + "\n" for row in rows).encode()
            + b"7 4 0 1 2 3\n7 3 1 4 2\n"
        )
    else:
        order = "<" if "little" in form else ">"
        body = rows.astype(order + "f8").tobytes() + struct.pack(
            order + "BB4iBB3i", 7, 4, 0, 1, 2, 3, 7, 3, 1, 4, 2
        )
    surface = load(saved(tmp_path, "a.ply", head.encode() + body), units="m")
    assert len(surface.faces) == 3
    assert surface.area_mm2 == pytest.approx(1.5e6)
    there = (surface.vertices + surface.origin_mm)[surface.faces][..., :2] / 4000
    assert surface.corner_uv == pytest.approx(there)


def test_ply_uvs_by_face(tmp_path):
    text = (
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 .1 .2 .3 .2 .1 .5\n"
    )
    surface = load(saved(tmp_path, "a.ply", text.encode()), units="m")
    assert surface.corner_uv == pytest.approx(np.array([[[0.1, 0.2], [0.3, 0.2], [0.1, 0.5]]]))


def test_off_with_normals_and_face_colours(tmp_path):
    text = "NOFF # head\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n# between\n0 1 0 0 0 1\n3 0 1 2 255 0 0\n"
    surface = load(saved(tmp_path, "a.off", text.encode()), units="m")
    assert surface.area_mm2 == pytest.approx(5e5)
    assert surface.corner_normal == pytest.approx(np.array([[[0, 0, 1]] * 3]))


def _with_uv(*sets):
    """A sheet as glTF, with texture coordinate sets."""
    v, f = sheet()
    doc, binary = document(v, f)
    for number, uv in enumerate(sets):
        doc["meshes"][0]["primitives"][0]["attributes"][f"TEXCOORD_{number}"] = len(doc["accessors"])
        doc["accessors"].append(
            {"bufferView": len(doc["bufferViews"]), "componentType": 5126, "count": len(uv), "type": "VEC2"}
        )
        doc["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": 8 * len(uv)})
        binary += np.asarray(uv, "<f4").tobytes()
    doc["buffers"][0]["byteLength"] = len(binary)
    return glb_of(doc, binary)


def test_gltf_uv_points_up_and_the_first_set_inside_the_page_is_taken(tmp_path):
    v, _ = sheet()
    down = np.column_stack([v[:, 0], 1 - v[:, 1]])
    surface = load(saved(tmp_path, "a.glb", _with_uv(down)))
    there = surface.vertices[surface.faces][..., :2] / 1000 + 0.5
    assert surface.corner_uv == pytest.approx(there, abs=1e-6)
    assert not surface.warnings
    surface = load(saved(tmp_path, "b.glb", _with_uv(down * 3, down)))
    assert surface.corner_uv == pytest.approx(there, abs=1e-6)
    assert any("UV set 1 is used" in line for line in surface.warnings)


def test_gltf_quantised_positions(tmp_path):
    v, f = sheet()
    doc, _ = document(v, f)
    whole = np.zeros((len(v), 4), "<i2")
    whole[:, :3] = np.round(v * 32767)
    binary = whole.tobytes() + f.astype("<u2").tobytes()
    doc["bufferViews"] = [
        {"buffer": 0, "byteLength": whole.nbytes, "byteStride": 8},
        {"buffer": 0, "byteOffset": whole.nbytes, "byteLength": 6 * len(f)},
    ]
    doc["accessors"][0].update(componentType=5122, normalized=True)
    doc["accessors"][1].update(componentType=5123)
    doc["extensionsRequired"] = ["KHR_mesh_quantization"]
    doc["buffers"][0]["byteLength"] = len(binary)
    surface = load(saved(tmp_path, "a.glb", glb_of(doc, binary)))
    assert surface.area_mm2 == pytest.approx(1e6)


def test_gltf_sparse_accessor_moves_vertices(tmp_path):
    v, f = sheet()
    doc, binary = document(v, f)
    indices, values = np.array([48], "<u2").tobytes() + b"\0\0", np.array([[1, 1, 5]], "<f4").tobytes()
    doc["bufferViews"] += [
        {"buffer": 0, "byteOffset": len(binary), "byteLength": 4},
        {"buffer": 0, "byteOffset": len(binary) + 4, "byteLength": 12},
    ]
    doc["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": 2, "componentType": 5123},
        "values": {"bufferView": 3},
    }
    binary += indices + values
    doc["buffers"][0]["byteLength"] = len(binary)
    surface = load(saved(tmp_path, "a.glb", glb_of(doc, binary)))
    assert np.ptp(surface.vertices[:, 2]) == pytest.approx(5000)
    doc["accessors"][0]["sparse"]["count"] = 2
    with pytest.raises(MeshFileError, match="sparse"):
        load(saved(tmp_path, "b.glb", glb_of(doc, binary)))


def test_gltf_nodes_are_placed_and_named(tmp_path):
    v, f = sheet()
    half_turn = [0, 0, 1, 0]
    data = glb(
        v,
        f,
        scenes=[{"nodes": [2]}],
        nodes=[
            {"mesh": 0, "name": "near"},
            {"mesh": 0, "name": "far", "translation": [0, 0, 3], "rotation": half_turn, "scale": [2, 2, 2]},
            {"children": [0, 1], "translation": [5, 0, 0]},
        ],
    )
    path = saved(tmp_path, "a.glb", data)
    surface = load(path)
    assert surface.part_names == ("near", "far")
    assert surface.area_mm2 == pytest.approx(5e6)
    far = load(path, part="far")
    assert (far.vertices + far.origin_mm).min(0) == pytest.approx([3000, -2000, 3000])
    assert (far.vertices + far.origin_mm).max(0) == pytest.approx([5000, 0, 3000])


def _stool():
    """Three nodes of two materials, of which one is called as a node of the other is."""
    v, f = sheet()
    doc, binary = document(v, f)
    attributes = doc["meshes"][0]["primitives"][0]
    doc["meshes"] = [{"primitives": [attributes | {"material": k}]} for k in (0, 1)]
    doc["materials"] = [{"name": "Leder braun"}, {"name": "back"}]
    names = (("Seat pad", 0), ("back", 0), ("leg", 1))
    doc["nodes"] = [{"mesh": k, "name": name, "translation": [0, 0, i]} for i, (name, k) in enumerate(names)]
    doc["scenes"] = [{"nodes": [0, 1, 2]}]
    return glb_of(doc, binary)


def test_a_chosen_part_keeps_the_names_that_the_whole_file_has(tmp_path):
    path = saved(tmp_path, "stool.glb", _stool())
    whole = load(path)
    assert whole.part_names == ("Leder braun", "back")
    assert whole.slot_names("stem") == {0: "Leder braun", 1: "back"}
    for part in ("Leder braun", "Seat pad"):
        chosen = load(path, part=part)
        assert chosen.part_names == ("Leder braun",)
        assert chosen.slot_names("stem") == {0: "Leder braun"}
    one = load(saved(tmp_path, "one.glb", glb(*sheet(), materials=[{"name": "calf"}])))
    assert one.slot_names("stem") == {0: "stem"}


def test_fields_find_parts_as_loading_does(tmp_path):
    path = saved(tmp_path, "stool.glb", _stool())
    whole = load(path)
    for name in ("Leder braun", "leder BRAUN", "leder", "Seat pad", "pad", "back", "leg"):
        chosen = part_field(whole, name).span()[0]
        part = load(path, part=name)
        place = whole.vertices[whole.faces[chosen > 0]] + whole.origin_mm
        np.testing.assert_allclose(np.unique(place), np.unique(part.vertices + part.origin_mm), atol=1e-9)
    assert (
        part_field(whole, "back").span()[0].tolist() == (whole.part == 1).tolist()
    )  # the material, not the node
    leather = load(path, part="Leder braun")
    assert part_field(leather, "Leder braun").span()[0].all()
    assert part_field(leather, "Seat pad").span()[0].mean() == 0.5
    with pytest.raises(
        RecipeError, match="the mesh has no part 'leg'; it has 'Leder braun', 'Seat pad', 'back'"
    ):
        part_field(leather, "leg")
    body = Bodies.of(whole, np.arange(3) == whole.component[part_field(whole, "Seat pad").span()[0] > 0][0])
    assert part_field(body.surface, "Seat pad").span()[0].all()
    assert not part_field(body.surface, "leg").span()[0].any()
    with pytest.raises(RecipeError, match="has several parts that 'a' fits: 'Leder braun', 'back'; write"):
        part_field(whole, "a")


@pytest.mark.parametrize("mode", [5, 6])
def test_gltf_strips_and_fans(tmp_path, mode):
    v = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], float)
    order = np.array([[0, 1, 2, 3] if mode == 5 else [0, 1, 3, 2]])
    doc, binary = document(v, order)
    doc["accessors"][1]["count"] = 4
    doc["bufferViews"][1]["byteLength"] = 16
    doc["meshes"][0]["primitives"][0]["mode"] = mode
    surface = load(saved(tmp_path, "a.glb", glb_of(doc, binary)))
    assert surface.area_mm2 == pytest.approx(1e6)
    assert (surface.frame[:, 2, 2] > 0.99).all()
    assert not surface.warnings


def test_a_gltf_buffer_beside_the_file(tmp_path):
    v, f = ball()
    doc, binary = document(v, f)
    (tmp_path / "mesh data.bin").write_bytes(binary)
    doc["buffers"][0]["uri"] = "mesh%20data.bin"
    surface = load(saved(tmp_path, "a.gltf", json.dumps(doc).encode()))
    assert len(surface.faces) == 168


def test_the_same_file_gives_the_same_surface(tmp_path):
    path = saved(tmp_path, "a.obj", obj(*ball()))
    one, two = load(path, size=100), load(path, size=100)
    assert one.sha256 == two.sha256
    assert np.array_equal(one.vertices, two.vertices)
    assert np.array_equal(one.faces, two.faces)
    assert one.name == "a"


REAL = {
    "bottle_water.stl": (4510, 3, 260.4, False),
    "bust_demosthenes.off": (16719, 1, 2693.6, False),
    "camera_antique.glb": (20058, None, 7208.9, True),
    "chair_sheen.glb": (39936, None, 826.6, True),
    "face_ict_neutral.obj": (52216, None, 338.1, True),
    "face_mediapipe_canonical.obj": (898, 1, 176.7, True),
    "head_lee_perry_smith.ply": (17680, 1, 453.3, True),
    "helmet_flight_leather.glb": (94722, None, 716.0, True),
    "shoe_variants.glb": (22700, 25, 297.9, True),
    "spot_quads.obj": (372, 1, 1774.0, True),
    "suzanne_monkey.gltf": (3936, 3, 2673.8, True),
}


@pytest.mark.parametrize("name", REAL)
def test_real_meshes(shared, name):
    faces, components, longest, has_uv = REAL[name]
    surface = load(shared / "meshes" / name)
    assert len(surface.faces) == faces
    assert components is None or surface.component.max() + 1 == components
    assert (surface.vertices.max(0) - surface.vertices.min(0)).max() == pytest.approx(longest, abs=0.1)
    assert (surface.corner_uv is not None) == has_uv
    assert len(surface.fans[1]) == 3 * faces


def test_the_real_leather_part(shared):
    surface = load(shared / "meshes" / "helmet_flight_leather.glb", part="LeatherParts")
    assert surface.part_names == ("LeatherPartsMat",)
    assert len(surface.faces) == 21896


def test_sheets_that_meet_only_after_welding_keep_their_winding(shared):
    surface = load(shared / "meshes" / "face_ict_neutral.obj")
    assert any("edges with more than two faces" in line for line in surface.warnings)
    assert not any("wound against" in line or "one side only" in line for line in surface.warnings)


def test_a_part_that_is_lost_beside_the_whole_is_named(tmp_path):
    v, f = ball()
    text, first = "", 1
    for name, scale, x in (("large", 1000.0, 0.0), ("speck", 1e-5, 4000.0), ("mote", 1e-5, 5000.0)):
        text += f"g {name}\n" + "".join(
            f"v {scale * a + x:.9g} {scale * b:.9g} {scale * c:.9g}\n" for a, b, c in v
        )
        text += "".join(f"f {a + first} {b + first} {c + first}\n" for a, b, c in f)
        first += len(v)
    whole = load(saved(tmp_path, "both.obj", text.encode()), units="mm")
    assert [text for text in whole.warnings if "nothing is left of part 'speck' and 1 more" in text]
    alone = load(tmp_path / "both.obj", units="mm", part="speck")
    assert len(alone.faces) > 0.9 * len(f)
    assert not any("nothing is left" in text for text in alone.warnings)


def test_an_interrupt_of_an_export_is_not_lost(tmp_path, monkeypatch):
    """Whatever trimesh does with it: it takes one in its sums for a failure of scipy, and adds up face by face."""
    from trimesh import geometry

    plain = geometry.weighted_vertex_normals

    def cut_short(*arguments, **options):
        with suppress(BaseException):
            signal.raise_signal(signal.SIGINT)
        return plain(*arguments, **options)

    monkeypatch.setattr(geometry, "weighted_vertex_normals", cut_short)
    vertices, faces = ball()
    with pytest.raises(KeyboardInterrupt):
        write_mesh(tmp_path / "ball.glb", np.array(vertices), np.array(faces))
