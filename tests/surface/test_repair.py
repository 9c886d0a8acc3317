"""What repair promises: a walkable surface, nothing moved, everything counted, for any order of faces."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from surftex.errors import SurfaceError
from surftex.randomness import stream
from surftex.surface.inspect import describe
from surftex.surface.repair import repair
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface


def surface_of(vertices, faces, **more):
    mended = repair(vertices, faces, **more)
    surface = Surface.from_arrays(mended.vertices, mended.faces, warnings=mended.warnings)
    assert len(surface.fans[1]) == 3 * len(surface.faces)
    return surface


def outward(surface):
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    return np.einsum("fi,fi->", a, np.cross(b, c)) > 0


def soup(surface):
    """Loose triangles, as an STL holds them."""
    return surface.vertices[surface.faces].reshape(-1, 3), np.arange(3 * len(surface.faces)).reshape(-1, 3)


@pytest.mark.parametrize(
    "shape", [sphere(subdivisions=2), torus(), cylinder(), plane()], ids=lambda s: s.name
)
def test_a_sound_surface_comes_back_as_it_was(shape):
    mended = repair(shape.vertices, shape.faces)
    assert mended.warnings == ()
    assert np.array_equal(mended.vertices[mended.faces], shape.vertices[shape.faces])
    assert len(mended.vertices) == len(shape.vertices)


@pytest.mark.parametrize(
    "shape", [sphere(subdivisions=2), torus(), cylinder(), plane()], ids=lambda s: s.name
)
def test_loose_triangles_with_noise_weld_to_the_same_topology(shape):
    vertices, faces = soup(shape)
    noise = stream(1, "noise").uniform(len(vertices), 3) - 0.5
    surface = surface_of(vertices + noise * 2e-7 * np.linalg.norm(np.ptp(vertices, axis=0)), faces)
    before, after = describe(shape), describe(surface)
    assert (after.vertices, after.euler_characteristic, after.border_loops) == (
        before.vertices,
        before.euler_characteristic,
        before.border_loops,
    )


def test_vertices_beyond_the_tolerance_stay_apart():
    flat = plane(10)
    lower = np.concatenate([flat.vertices, flat.vertices - [0, 0, 1e-3]])
    faces = np.concatenate([flat.faces, flat.faces[:, ::-1] + len(flat.vertices)])
    surface = surface_of(lower, faces)
    assert surface.component.max() == 1
    assert surface.warnings == ()


@given(st.integers(0, 2**30), st.sampled_from([sphere(subdivisions=1), torus(columns=12, rows=8)]))
def test_any_windings_in_any_order_face_outward(seed, shape):
    draws = stream(seed, "shuffle").uniform(len(shape.faces), 2)
    faces = np.array(shape.faces)[np.argsort(draws[:, 0])]
    flip = draws[:, 1] < 0.5
    faces[flip] = faces[flip][:, ::-1]
    surface = surface_of(shape.vertices, faces)
    assert outward(surface)
    assert surface.border_loops == 0
    assert surface.component.max() == 0


def test_each_closed_component_faces_outward_by_its_own_volume():
    one, two = sphere(subdivisions=1), sphere(subdivisions=1)
    vertices = np.concatenate([one.vertices, two.vertices + np.array([500, 0, 0])])
    faces = np.concatenate([one.faces, two.faces[:, ::-1] + len(one.vertices)])
    surface = surface_of(vertices, faces)
    assert any("1 closed component was inside out" in line for line in surface.warnings)
    for k in (0, 1):
        part = surface.faces[surface.component == k]
        a, b, c = (surface.vertices[part[:, i]] for i in range(3))
        assert np.einsum("fi,fi->", a, np.cross(b, c)) > 0


def test_an_open_sheet_keeps_the_winding_of_its_greater_part():
    flat = plane(10, cells=4)
    faces = np.array(flat.faces)
    faces[:5] = faces[:5, ::-1]
    surface = surface_of(flat.vertices, faces)
    assert (surface.frame[:, 2, 2] > 0.99).all()
    assert any("5 faces were wound against" in line for line in surface.warnings)


def test_uv_normals_and_parts_travel_with_their_corners():
    flat = plane(10, cells=4)
    faces = np.array(flat.faces)
    faces[3] = faces[3, [1, 0, 2]]
    uv = flat.vertices[faces][..., :2] / 10
    normal = np.tile([0.0, 0.0, 2.0], (len(faces), 3, 1))
    part = np.arange(len(faces))
    faces = np.concatenate([faces[:7], [[0, 0, 1]], faces[7:]])
    mended = repair(
        flat.vertices,
        faces,
        part=np.insert(part, 7, 99),
        corner_uv=np.insert(uv, 7, 9.0, axis=0),
        corner_normal=np.insert(normal, 7, 1.0, axis=0),
    )
    assert mended.corner_uv == pytest.approx(mended.vertices[mended.faces][..., :2] / 10)
    assert mended.corner_normal == pytest.approx(normal / 2)
    assert np.array_equal(mended.part, part)
    assert np.array_equal(mended.source_face, np.delete(np.arange(len(faces)), 7))


def test_normals_that_are_missing_or_contradict_are_left_out():
    ball = sphere(subdivisions=2)
    smooth = np.array(ball.vertex_normal[ball.faces])
    assert repair(ball.vertices, ball.faces, corner_normal=smooth).corner_normal == pytest.approx(smooth)
    assert repair(ball.vertices, ball.faces, corner_normal=-smooth).corner_normal is None
    assert repair(ball.vertices, ball.faces, corner_normal=smooth * 0).corner_normal is None
    missing = smooth.copy()
    missing[4] = np.nan
    mended = repair(ball.vertices, ball.faces, corner_normal=missing)
    assert mended.corner_normal is None
    assert any("1 face lacks shading normals" in line for line in mended.warnings)


def test_two_boxes_that_share_an_edge_come_apart_or_join_but_stay_closed():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    box = np.array(
        [
            [0, 1, 3],
            [0, 3, 2],
            [4, 6, 7],
            [4, 7, 5],
            [0, 4, 5],
            [0, 5, 1],
            [2, 3, 7],
            [2, 7, 6],
            [0, 2, 6],
            [0, 6, 4],
            [1, 5, 7],
            [1, 7, 3],
        ]
    )
    surface = surface_of(
        np.concatenate([corners, corners + np.array([1, 1, 0])]), np.concatenate([box, box + 8])
    )
    assert len(surface.faces) == 24
    assert surface.border_loops == 0
    assert outward(surface)
    assert any("1 edge with more than two faces" in line for line in surface.warnings)


def test_a_fan_of_a_thousand_faces_at_one_edge_is_split_into_sheets():
    turn = np.arange(1000) * 2 * np.pi / 1000
    rim = np.stack([np.cos(turn), np.sin(turn), 0 * turn + 0.5], 1)
    faces = np.stack([np.zeros(1000, int), np.ones(1000, int), np.arange(2, 1002)], 1)
    surface = surface_of(np.concatenate([[[0, 0, 0], [0, 0, 1]], rim]), faces)
    assert len(surface.faces) == 1000
    assert (np.bincount(surface.component) <= 2).all()


def test_a_moebius_strip_is_cut_and_nothing_is_lost():
    columns = 30
    turn = np.arange(columns) * 2 * np.pi / columns
    rims = [
        np.stack(
            [
                (1 + w * np.cos(turn / 2)) * np.cos(turn),
                (1 + w * np.cos(turn / 2)) * np.sin(turn),
                w * np.sin(turn / 2),
            ],
            1,
        )
        for w in (-0.3, 0.3)
    ]
    a = np.arange(columns)
    b, c = a + 1, a + columns + 1
    b[-1], c[-1] = columns, 0
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, a + columns], 1)])
    surface = surface_of(np.concatenate(rims), faces)
    assert len(surface.faces) == 60
    assert surface.component.max() == 0
    assert surface.border_loops == 1
    assert any("one side only" in line and "1 edge was cut" in line for line in surface.warnings)


def test_many_one_sided_strips_take_no_longer_than_one():
    columns = 9
    turn = np.arange(columns) * 2 * np.pi / columns
    rims = [
        np.stack(
            [
                (1 + w * np.cos(turn / 2)) * np.cos(turn),
                (1 + w * np.cos(turn / 2)) * np.sin(turn),
                w * np.sin(turn / 2),
            ],
            1,
        )
        for w in (-0.3, 0.3)
    ]
    a = np.arange(columns)
    b, c = a + 1, a + columns + 1
    b[-1], c[-1] = columns, 0
    strip = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, a + columns], 1)])
    vertices = np.concatenate([np.concatenate(rims) + np.array([4.0 * k, 0, 0]) for k in range(500)])
    faces = np.concatenate([strip + 18 * k for k in range(500)])
    surface = surface_of(vertices, faces)
    assert surface.component.max() == 499
    assert any("500 components have one side only" in line for line in surface.warnings)


def test_needles_survive_and_rounding_does_not():
    needle = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-7, 0], [0.5, 1, 0]])
    surface = surface_of(needle, [[0, 1, 2], [0, 2, 3]])
    assert len(surface.faces) == 2
    flat = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-14, 0], [0.5, 1, 0]])
    assert len(surface_of(flat, [[0, 1, 2], [0, 2, 3]]).faces) == 1


@pytest.mark.parametrize("scale", [1e-30, 1e-9, 1e9, 1e30])
def test_scale_changes_nothing(scale):
    vertices, faces = soup(torus(columns=16, rows=9))
    one, other = repair(vertices, faces), repair(vertices * scale, faces)
    assert np.array_equal(one.faces, other.faces)
    assert one.warnings == other.warnings


@pytest.mark.parametrize(
    ("vertices", "faces", "says"),
    [
        (np.eye(3), np.zeros((0, 3), int), "no faces"),
        (np.eye(3), [[0, 1, 3]], "there are 3"),
        (np.eye(3), [[0, 1, -1]], "there are 3"),
        (np.eye(3), [[0, 1, 1]], "no area"),
        (np.ones((3, 3)), [[0, 1, 2]], "no area"),
        (np.eye(3) * 1e200, [[0, 1, 2]], "overflows"),
        (np.eye(3) * np.nan, [[0, 1, 2]], "not finite"),
    ],
)
def test_what_is_no_surface_is_refused(vertices, faces, says):
    with pytest.raises(SurfaceError, match=says):
        repair(vertices, faces)


@given(st.integers(0, 2**30), st.integers(4, 9), st.integers(1, 40))
def test_random_triangles_always_become_a_surface(seed, places, count):
    draws = stream(seed, "random").uniform(count, 3)
    corners = stream(seed, "corners").uniform(places, 3)
    faces = (draws * places).astype(int)
    try:
        surface = surface_of(corners, faces)
    except SurfaceError as problem:
        assert "no area" in str(problem)  # noqa: PT017
        return
    distinct = {tuple(sorted(f)) for f in faces.tolist() if len(set(f)) == 3}
    assert len(surface.faces) == len(distinct)


def test_faces_of_one_sense_at_a_crowded_edge_are_not_glued():
    fin = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0.5], [-1, 0.1, 0.5], [0, 1, 0.5], [0.1, -1, 0.5]], float)
    surface = surface_of(*soup_of(fin, [[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 5]]), part=[0, 0, 1, 2])
    assert surface.component.max() == 3
    assert not any("wound against" in line for line in surface.warnings)


def soup_of(vertices, faces):
    return vertices[np.asarray(faces)].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)
