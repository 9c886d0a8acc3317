"""Normals come from slopes along the surface: neither unwrap, seams, threads nor facets may show in them."""

import numpy as np
import pytest

from surftex.charts.atlas import Atlas
from surftex.charts.texels import texels
from surftex.charts.unwrap import unwrap
from surftex.features.uniform import area_points
from surftex.files.meshes import load
from surftex.kernels.normals import encode_slopes
from surftex.maps.normal import height_gradient, normal_map, object_normals, surface_tangents
from surftex.maps.page import page_metric, read_only, stopped
from surftex.randomness import stream
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface
from tests.oracles import maps as oracle

WAVES = 2 * np.pi * np.array([[0.8, 0.36, 0.48], [-0.5, 0.7, 0.5]]) / [[6.0], [5.0]]


def bumps(position):
    return (np.sin(position @ WAVES.T) * [0.4, 0.3]).sum(axis=1).astype(np.float32)


def slope(position):
    return (np.cos(position @ WAVES.T) * [0.4, 0.3]) @ WAVES


def raised(normal, gradient):
    """Exact normal of a smooth surface with the unit normal given, raised by a height with that gradient."""
    result = normal - (gradient - normal * (gradient * normal).sum(axis=1, keepdims=True))
    return result / np.linalg.norm(result, axis=1, keepdims=True)


def unwrapped_plane(turn, stretch):
    flat = plane(20.0, cells=8)
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    return flat, Atlas.of(flat, (flat.corner_uv - 0.5) @ rotation * stretch + 0.5)


def angle_deg(one, other):
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(one - other, axis=1) / 2, 0, 1)))


def decoded(surface, atlas, page, encoded):
    points = page.host_points
    return object_normals(surface, surface_tangents(surface, atlas), points.face, points.barycentric, encoded)


@pytest.mark.parametrize(
    "stretch", [(0.6, 0.6), (0.6, 0.2), (-0.5, 0.5)], ids=["even", "stretched", "mirrored"]
)
@pytest.mark.parametrize("turn", [0.0, 0.6, 2.5])
def test_unwraps_do_not_change_normals(turn, stretch):
    flat, atlas = unwrapped_plane(turn, stretch)
    page = texels(flat, atlas, 512)
    place = page.points.positions(flat)
    normal = decoded(flat, atlas, page, normal_map(flat, atlas, page, bumps(place)))
    inside = page.core & (np.abs(place - 10)[:, :2].max(axis=1) < 9)
    truth = raised(np.tile([0.0, 0.0, 1.0], (inside.sum(), 1)), slope(place[inside]))
    away = angle_deg(normal[inside], truth)
    assert np.median(away) < 0.15
    assert away.max() < 0.9


def test_plane_normals_converge_at_second_order():
    step, worst = [], []
    for resolution in (128, 256, 512):
        flat, atlas = unwrapped_plane(0.6, (0.6, 0.6))
        page = texels(flat, atlas, resolution)
        place = page.points.positions(flat)
        normal = decoded(flat, atlas, page, normal_map(flat, atlas, page, bumps(place)))
        inside = page.core & (np.abs(place - 10)[:, :2].max(axis=1) < 9)
        truth = raised(np.tile([0.0, 0.0, 1.0], (inside.sum(), 1)), slope(place[inside]))
        worst.append(np.percentile(angle_deg(normal[inside], truth), 99))
        step.append(1 / resolution)
    assert np.polyfit(np.log(step), np.log(worst), 1)[0] == pytest.approx(2, abs=0.15)


def test_equals_the_twin():
    ball = sphere(20.0, subdivisions=1)
    uv = unwrap(ball, method="uvunwrap", resolution=64).corner_uv * [-1, 0.8]
    uv = np.where((np.arange(len(uv)) % 5 == 0)[:, None, None], uv[:, :1], np.abs(uv - [-1, 0.1]))
    atlas = Atlas.of(ball, uv)
    metric, corner = page_metric(ball, atlas, 64, 48), atlas.corner_px(64, 48)
    stretch = metric.stretch[:, [0, 1, 1, 2]].reshape(-1, 2, 2)
    np.testing.assert_allclose(metric.axes @ stretch, atlas.jacobian_mm(ball, 64, 48), atol=1e-9)
    for f, twin in enumerate(map(oracle.page_metric, corner, ball.flat)):
        for own, expected in zip((stretch[f], metric.axes[f], metric.weight[f]), twin, strict=True):
            np.testing.assert_allclose(own, expected, atol=1e-9)
    flat, own = unwrapped_plane(0.6, (-0.6, 0.3))
    page = texels(flat, own, 48, gutter_px=0)
    height = bumps(page.points.positions(flat))
    tangents = surface_tangents(flat, own)
    expected = oracle.normals(flat, own, page, height, tangents)
    np.testing.assert_allclose(normal_map(flat, own, page, height, tangents=tangents), expected, atol=2e-5)


def test_gradients_of_the_gutter_continue_the_chart():
    """A gutter texel's slope is told in the frame of its host face, although the point lies beyond the seam."""
    ball = sphere(20.0, subdivisions=4)
    atlas = unwrap(ball, method="uvunwrap", resolution=512)
    page = texels(ball, atlas, 512)
    place = page.points.positions(ball)
    gradient = height_gradient(ball, atlas, page, bumps(place))
    gutter = ~page.core
    assert (page.host != page.points.face)[gutter].any()
    up = place / np.linalg.norm(place, axis=1, keepdims=True)
    along = slope(place) - up * (slope(place) * up).sum(axis=1, keepdims=True)
    truth = np.einsum("pki,pi->pk", ball.frame[page.host][:, :2], along)
    for part in (page.core, gutter):
        away = np.linalg.norm(gradient[part] - truth[part], axis=1)
        assert np.median(away) < 0.03
        assert np.percentile(away, 95) < 0.12


def bilinear(image, uv):
    height, width = image.shape[:2]
    x, y = uv[:, 0] * width - 0.5, (1 - uv[:, 1]) * height - 0.5
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    x, y = (x - column)[:, None], (y - row)[:, None]
    return (image[row, column] * (1 - x) + image[row, column + 1] * x) * (1 - y) + (
        image[row + 1, column] * (1 - x) + image[row + 1, column + 1] * x
    ) * y


def seen(surface, atlas, tangents, image, face, weight):
    """What a shader shows: the map filtered, decoded in the frame of the face that it draws."""
    uv = np.einsum("pk,pki->pi", weight, atlas.corner_uv[face])
    return object_normals(surface, tangents, face, weight, bilinear(image, uv))


def test_decoding_weighs_the_frames_of_the_corners():
    ball = sphere(5.0, subdivisions=1)
    atlas = Atlas.of(ball, np.abs(unwrap(ball, method="uvunwrap", resolution=64).corner_uv - [0.5, 0]))
    tangents = surface_tangents(ball, atlas)
    assert set(np.unique(tangents[..., 3])) == {-1, 1}
    points = area_points(ball, stream(0, "places").uniform(500, 3))
    encoded = (stream(0, "codes").uniform(500, 3) * 2 - 1).astype(np.float32)
    asked = (ball, tangents, points.face, points.barycentric, encoded)
    np.testing.assert_allclose(object_normals(*asked), oracle.object_normals(*asked), atol=1e-12)
    np.testing.assert_array_equal(object_normals(*asked[:4], 0 * encoded), 0)


def seam_points(surface, atlas, per_edge=8):
    """Places on seams, as seen from both sides."""
    face, edge = np.nonzero(atlas.seam & (surface.neighbor >= 0))
    other, other_edge = surface.neighbor[face, edge], surface.neighbor_edge[face, edge]
    along = np.tile((np.arange(per_edge) + 0.5) / per_edge, len(face))
    face, edge, other, other_edge = (np.repeat(part, per_edge) for part in (face, edge, other, other_edge))
    row = np.arange(len(face))
    here, there = np.zeros((len(face), 3)), np.zeros((len(face), 3))
    here[row, edge], here[row, (edge + 1) % 3] = 1 - along, along
    there[row, other_edge], there[row, (other_edge + 1) % 3] = along, 1 - along
    return face, here, other, there


def test_no_step_along_seams():
    ball = sphere(20.0, subdivisions=4)
    atlas = unwrap(ball, method="uvunwrap", resolution=1024)
    page = texels(ball, atlas, 1024)
    tangents = surface_tangents(ball, atlas)
    image = page.image(normal_map(ball, atlas, page, bumps(page.points.positions(ball)), tangents=tangents))
    face, here, other, there = seam_points(ball, atlas)
    step = angle_deg(
        seen(ball, atlas, tangents, image, face, here), seen(ball, atlas, tangents, image, other, there)
    )
    random = np.random.RandomState(0)
    inner = random.randint(0, len(ball.faces), len(face))
    weight = random.dirichlet([1, 1, 1], len(face))
    place = np.einsum("pk,pki->pi", weight, ball.vertices[ball.faces[inner]])
    up = np.einsum("pk,pki->pi", weight, ball.shading_normal[inner])
    truth = raised(up / np.linalg.norm(up, axis=1, keepdims=True), slope(place))
    inside = angle_deg(seen(ball, atlas, tangents, image, inner, weight), truth)
    rms = np.sqrt((step**2).mean()), np.sqrt((inside**2).mean())
    assert rms[0] < 1.2 * rms[1], rms
    assert step.max() < 2.0


def test_facets_do_not_show_in_the_relief():
    """One slope, carried over an edge of a coarse ball, bends the normals on both sides alike."""
    ball = sphere(20.0, subdivisions=1)
    corner = np.array([[0.2, 0.2], [0.8, 0.2], [0.5, 0.8]])
    face, edge = np.nonzero(ball.neighbor >= 0)
    other, other_edge = ball.neighbor[face, edge], ball.neighbor_edge[face, edge]
    count, row = len(face), np.arange(len(face))
    here, there = np.zeros((count, 3)), np.zeros((count, 3))
    here[row, edge], here[row, (edge + 1) % 3] = 0.7, 0.3
    there[row, (other_edge + 1) % 3], there[row, other_edge] = 0.7, 0.3
    angle = row * 2.4
    left = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    c, s = ball.transport[face, edge, :2].T
    right = np.stack([c * left[:, 0] - s * left[:, 1], s * left[:, 0] + c * left[:, 1]], axis=1)
    atlas = Atlas.of(ball, np.tile(corner, (len(ball.faces), 1, 1)))
    tangents, size = surface_tangents(ball, atlas), 1 << 12
    metric, bent = page_metric(ball, atlas, size), []
    for gradient, host, weight in ((left, face, here), (right, other, there)):
        column, line = (weight @ corner * [size, -size] + [0, size]).astype(np.int64).T
        encoded = np.zeros((count, 3), np.float32)
        encode_slopes(
            0,
            count,
            size,
            read_only(line * size + column),
            read_only(gradient.astype(np.float32)),
            read_only(host.astype(np.int32)),
            metric.weight,
            ball.frame,
            read_only(ball.shading_normal),
            tangents,
            encoded,
        )
        bent.append(object_normals(ball, tangents, host, weight, encoded))
    dihedral = angle_deg(ball.frame[face, 2], ball.frame[other, 2])
    assert dihedral.min() > 15
    assert angle_deg(*bent).max() < 1.0


def hard_cube():
    """A box whose sides shade flat, each side a chart of its own."""
    u, v = np.array([0, 1, 1, 0]), np.array([0, 0, 1, 1])
    vertices, normals, faces, uv = [], [], [], []
    for side in range(6):
        axis, sign = side % 3, 1 if side < 3 else -1
        quad = np.zeros((4, 3))
        quad[:, axis] = 0.5 + 0.5 * sign
        quad[:, (axis + 1) % 3], quad[:, (axis + 2) % 3] = (u, v) if sign > 0 else (v, u)
        vertices.append(20 * quad)
        normals.append(np.tile(sign * np.eye(3)[axis], (4, 1)))
        faces += [[4 * side, 4 * side + 1, 4 * side + 2], [4 * side, 4 * side + 2, 4 * side + 3]]
        place = np.stack([0.04 + 0.25 * u + 0.32 * axis, 0.1 + 0.25 * v + (0.5 if sign < 0 else 0)], axis=1)
        uv.append(place)
    faces = np.array(faces)
    corner_uv = np.concatenate(uv)[faces]
    corner_normal = np.concatenate(normals)[faces]
    position, weld = np.unique(np.concatenate(vertices), axis=0, return_inverse=True)
    box = Surface.from_arrays(position, weld.reshape(-1)[faces], corner_normal=corner_normal)
    return box, Atlas.of(box, corner_uv)


def test_hard_edges_keep_each_side_to_itself():
    box, atlas = hard_cube()
    assert (box.neighbor >= 0).all()
    page, tangents = texels(box, atlas, 256, gutter_px=8), surface_tangents(box, atlas)
    place = page.points.positions(box)
    assert (page.points.face[~page.core] // 2 != page.host[~page.core] // 2).any()
    image = page.image(normal_map(box, atlas, page, (0.3 * place.sum(axis=1)).astype(np.float32)))
    face, here, _, _ = seam_points(box, atlas)
    up = box.frame[face, 2]
    gradient = np.full((len(face), 3), 0.3)
    away = angle_deg(seen(box, atlas, tangents, image, face, here), raised(up, gradient))
    assert (
        away.max() < np.degrees(np.arctan(0.3)) + 1
    )  # the slope across turns over at the edge: none is left of it
    flat = page.image(normal_map(box, atlas, page, np.zeros(len(page), np.float32)))
    np.testing.assert_allclose(seen(box, atlas, tangents, flat, face, here), up, atol=1e-6)


@pytest.mark.parametrize(
    "name", ["ball", "box", "shoe_variants.glb", "camera_antique.glb", "suzanne_monkey.gltf"]
)
def test_no_height_is_flat_everywhere(name, request):
    if name == "ball":
        surface = sphere(20.0, subdivisions=3)
        atlas = unwrap(surface, method="uvunwrap", resolution=256)
    elif name == "box":
        surface, atlas = hard_cube()
    else:
        surface = load(request.getfixturevalue("shared") / "meshes" / name)
        atlas = Atlas.of(surface, surface.corner_uv)
    page = texels(surface, atlas, 256)
    assert (~page.core).any()
    codes = page.image(normal_map(surface, atlas, page, np.full(len(page), 0.7, np.float32)))
    assert np.unique(codes.reshape(-1, 3), axis=0).tolist() == [[0, 0, 1]]


def test_borders_of_the_mesh_keep_their_slope():
    flat, atlas = unwrapped_plane(0.0, (0.8, 0.8))
    page = texels(flat, atlas, 256)
    place = page.points.positions(flat)
    height = (0.5 * place[:, 0]).astype(np.float32)
    beyond = stopped(flat, page)
    assert (beyond == ~page.core).all()
    normal = decoded(flat, atlas, page, normal_map(flat, atlas, page, height))
    expected = np.tile(np.array([-0.5, 0, 1]) / np.sqrt(1.25), (len(page), 1))
    np.testing.assert_allclose(normal, expected, atol=2e-3)


def test_same_bytes_for_threads_and_bands():
    ball = sphere(20.0, subdivisions=3)
    atlas = unwrap(ball, method="uvunwrap", resolution=512)
    page = texels(ball, atlas, 512)
    height = bumps(page.points.positions(ball))
    whole = normal_map(ball, atlas, page, height, threads=1)
    assert whole.tobytes() == normal_map(ball, atlas, page, height, threads=2).tobytes()
    first, last = 100, 200
    band = texels(ball, atlas, 512, rows=(first - 1, last + 1))
    part = normal_map(ball, atlas, band, bumps(band.points.positions(ball)))
    kept = (band.texel >= first * 512) & (band.texel < last * 512)
    same = (page.texel >= first * 512) & (page.texel < last * 512)
    assert part[kept].tobytes() == whole[same].tobytes()
