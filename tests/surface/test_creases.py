"""Hard edges by angle: truth on bodies whose faces are known, and words where they are missing."""

import numpy as np
import pytest

import surftex as sx
from surftex.errors import InputError, RecipeError
from surftex.recipe.model import MeshSettings, Recipe
from surftex.surface.creases import crease_notes, creased, edge_bend
from surftex.surface.shapes import cylinder, midpoint_subdivided, sphere, torus
from surftex.surface.surface import Surface

CUBE = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5],
        [3, 7, 5]]  # fmt: skip


def cube():
    """Twelve faces, each side of two."""
    return [[x, y, z] for z in (0, 10) for y in (0, 10) for x in (0, 10)], CUBE


def test_sides_of_a_cube_are_flat_and_apart():
    smooth, hard = sx.load(cube()), sx.load(cube(), crease=40)
    assert smooth.corner_normal is None
    flat = np.repeat(hard.frame[:, None, 2], 3, axis=1)
    np.testing.assert_allclose(hard.shading_normal, flat, atol=1e-12)
    assert np.degrees(np.arccos((smooth.shading_normal * flat).sum(axis=2))).min() > 40
    np.testing.assert_array_equal(hard.vertices, smooth.vertices)
    np.testing.assert_allclose(np.unique(np.round(np.degrees(edge_bend(hard)), 6)), [0, 90])


def test_no_crease_is_smooth_and_every_crease_is_flat():
    ball = sphere(10.0, subdivisions=2)
    np.testing.assert_allclose(creased(ball, 180).shading_normal, ball.shading_normal, atol=1e-12)
    flat = np.repeat(ball.frame[:, None, 2], 3, axis=1)
    np.testing.assert_allclose(creased(ball, 0).shading_normal, flat, atol=1e-12)
    assert np.abs(ball.shading_normal - flat).max() > 0.1


def test_a_lid_is_flat_beside_a_round_wall():
    """A prism of many sides with two lids: the wall stays round, the lids are flat."""
    turn = np.arange(48) * 2 * np.pi / 48
    ring = np.stack([10 * np.cos(turn), 10 * np.sin(turn)], axis=1)
    points = [*([x, y, 0] for x, y in ring), *([x, y, 8] for x, y in ring), [0, 0, 0], [0, 0, 8]]
    faces = []
    for i in range(48):
        j = (i + 1) % 48
        faces += [[i, j, 48 + j], [i, 48 + j, 48 + i], [96, j, i], [97, 48 + i, 48 + j]]
    shape = creased(Surface.from_arrays(points, faces), 30)
    lids = np.abs(shape.frame[:, 2, 2]) > 0.9
    np.testing.assert_allclose(np.abs(shape.shading_normal[lids][..., 2]), 1.0, atol=1e-12)
    wall, corner = shape.shading_normal[~lids], shape.vertices[shape.faces[~lids]]
    np.testing.assert_allclose(wall[..., 2], 0.0, atol=1e-12)
    np.testing.assert_allclose((wall * corner)[..., :2].sum(axis=2), 10.0, atol=1e-6)


def test_own_normals_give_way_and_a_recipe_can_ask():
    vertices, faces = (np.array(each) for each in cube())
    normal = np.tile([0.0, 0.0, 1.0], (12, 3, 1))
    own = Surface.from_arrays(vertices * 1.0, faces, corner_normal=normal)
    assert np.array_equal(own.shading_normal, normal)
    assert not np.allclose(creased(own, 40).shading_normal, normal)
    recipe = Recipe.of(sx.Leather.preset("calf", cell_size=4.0))
    asked = recipe.model_copy(update={"mesh": MeshSettings(crease=40)})
    maps = [sx.bake(cube(), each, resolution=64, maps=("normal",)) for each in (recipe, asked)]
    tilt = [np.degrees(np.arccos(np.clip((baked.surface.shading_normal * baked.surface.frame[:, None, 2]).sum(axis=2), -1, 1)))
            for baked in maps]  # fmt: skip
    assert tilt[0].max() > 40
    assert tilt[1].max() < 1e-3
    assert any("; crease = 40 (--crease 40) makes" in each for each in maps[0].report["warnings"])
    assert not any("--crease" in each for each in maps[1].report["warnings"])


def test_round_bodies_are_not_spoken_of():
    points, faces = midpoint_subdivided(*(np.array(each) for each in cube()))
    assert "bend by more than 60 degrees" in crease_notes(Surface.from_arrays(points * 1.0, faces))[0]
    assert crease_notes(creased(Surface.from_arrays(points * 1.0, faces), 40)) == ()
    for shape in (torus(), sphere(10.0, subdivisions=2), cylinder()):
        assert crease_notes(shape) == ()


@pytest.mark.parametrize("degrees", [-1.0, 180.5, float("nan")])
def test_angles_that_are_none_are_refused(degrees):
    with pytest.raises(InputError, match="crease is"):
        creased(torus(), degrees)
    with pytest.raises((RecipeError, ValueError), match="crease"):
        MeshSettings(crease=degrees)
