"""What every material promises: nothing but surface, recipe and seed decides it, each in its own part.

One table of materials; a new one is a row of it.
"""

import dataclasses
from typing import Any

import numpy as np
import pytest

import surftex as sx
from surftex.charts.lookup import bilinear
from surftex.features.uniform import scatter
from surftex.materials import parameters
from surftex.randomness import stream
from surftex.recipe.layer import MATERIALS, material_class
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.shapes import torus
from surftex.surface.surface import Surface

RAISED = "base_color,roughness,normal,height,ambient_occlusion"


@dataclasses.dataclass(frozen=True)
class Row:
    """A small material with every kind of feature, and what is known to differ."""

    parameters: dict[str, Any]
    added: tuple[dict[str, Any], str] | None
    """Parameters that add a kind of feature, and its name; None where there is but one kind."""
    calm: dict[str, Any] | None
    """Without noise in space and without a field of directions of its own; None where those make it."""
    fixed: tuple[str, ...] = ()
    """Lengths within the tissue, that do not grow with the mesh."""


TABLE = {
    "leather": Row(
        {"cell_size": 2.5, "wrinkle_count": 2, "wrinkle_length": 12.0, "pore_density": 0.3, "pore_width": 0.5,
         "sulcus_width": 0.6, "sulcus_depth": 0.1, "pocket_width": 0.5, "pocket_depth": 0.1, "wrinkle_width": 0.9},
        ({"crown_spacing": 9.0}, "crown"),
        {"grain_height": 0.0, "mottle": 0.0, "waviness": 0.0},
    ),
    "skin": Row(
        {"freckle_count": 30, "freckle_radius": (0.8, 0.3), "cyst_count": 20, "mole_count": 3, "wrinkle_count": 3,
         "wrinkle_width": (0.5, 0.8), "pore_density": 0.05, "relief_spacing": 3.0, "relief_width": 0.8,
         "relief_depth": 0.1},
        ({"scar_count": 3}, "scar"),
        {"variation": 0, "drift": 0, "mottle": 0, "flush": 0, "tan": 0, "relief_depth": 0, "relief_secondary": 0,
         "relief_swell": 0, "freckle_irregularity": 0, "mole_irregularity": 0},
        ("stratum_corneum", "epidermis", "lips_epidermis"),
    ),
    "cells": Row(
        {"cell_size": 3.0, "generations": 60, "blob_density": 12.0},
        ({"wrinkle_count": 2}, "wrinkle"),
        None,
    ),
    "composite": Row({"model": "gravel", "pixel_size": 1.0, "relief": 1.0, "sweeps": 4}, None, None),
}  # fmt: skip

by_material = pytest.mark.parametrize("name", TABLE)


def material(name, **changes):
    return material_class(name)(**{**TABLE[name].parameters, **changes})


@pytest.fixture(scope="module")
def ring():
    return torus(7.0, 3.0, columns=48, rows=24)


@pytest.fixture(scope="module")
def baked(ring):
    """Bakes of every material, each made once."""
    made = {}

    def give(name):
        if name not in made:
            made[name] = bake(ring, name, threads=1)
        return made[name]

    return give


def bake(surface, name, **options):
    options = {"resolution": 128, "seed": 4, "maps": RAISED, "unwrapper": "uvunwrap", **options}
    return sx.bake(surface, material(name), **options)


def samples_on(surface, footprint_mm=0.05):
    points = scatter(surface, stream(1, "samples"), count=1500)
    return Samples(points, np.full(len(points), footprint_mm, np.float32))


def check_same_features(first, second, but=()):
    assert set(first) - set(but) == set(second) - set(but)
    for kind in set(first) - set(but):
        assert first[kind].tobytes() == second[kind].tobytes(), kind


def test_the_table_holds_every_material():
    assert set(TABLE) == set(MATERIALS)


@by_material
def test_threads_and_tiles_change_no_byte(baked, ring, name):
    first, second = baked(name), bake(ring, name, threads=2, tile=37)
    for each in first:
        assert first[each].tobytes() == second[each].tobytes(), each
    check_same_features(first.features, second.features)


@by_material
def test_unwrap_and_resolution_change_no_feature_and_no_height(baked, ring, name):
    first, second = baked(name), bake(ring, name, resolution=384, unwrapper="xatlas")
    check_same_features(first.features, second.features)
    places = scatter(ring, stream(1, "places"), count=3000)
    height = []
    for maps in (first, second):
        uv = np.einsum("pk,pkc->pc", places.barycentric, maps.atlas.corner_uv[places.face])
        height.append(bilinear(maps["height"], uv))
    relief = height[1].std()
    assert relief > 0.01
    assert np.corrcoef(*height)[0, 1] > 0.9  # the coarse one cannot see the finest
    assert abs(height[0].mean() - height[1].mean()) < 0.05 * relief


@by_material
def test_another_seed_is_another_pattern(baked, ring, name):
    first, second = baked(name), bake(ring, name, seed=5, resolution=64)
    kind = next(iter(first.features))
    assert first.features[kind].tobytes() != second.features[kind].tobytes()


@pytest.mark.parametrize("name", [name for name in TABLE if TABLE[name].added])
def test_a_further_kind_leaves_the_others_in_place(ring, name):
    changes, kind = TABLE[name].added
    without = material(name).place(ring, 4).features
    beside = material(name, **changes).place(ring, 4).features
    assert kind in beside
    assert len(beside[kind]) > len(without.get(kind, ()))
    check_same_features(without, beside, but=(kind,))


@by_material
def test_surface_and_recipe_scaled_together_change_nothing(ring, name):
    """By 2, which rounds nothing: lengths of features and heights double, all else stays."""
    twice = Surface.from_arrays(2 * ring.vertices, ring.faces)
    small, large = material(name), doubled(name)
    first, second = small.place(ring, 4), large.place(twice, 4)
    assert set(first.features) == set(second.features)
    for kind, table in first.features.items():
        np.testing.assert_array_equal(table["face"], second.features[kind]["face"])
        np.testing.assert_array_equal(table["barycentric"], second.features[kind]["barycentric"])
    layers, larger = first.at(samples_on(ring)), second.at(samples_on(twice, 0.1))
    assert np.ptp(layers["height_mm"]) > 0.01
    np.testing.assert_array_equal(2 * layers["height_mm"], larger["height_mm"])
    for channel in ("base_color", "roughness", "specular"):
        np.testing.assert_array_equal(layers[channel], larger[channel])


def doubled(name):
    """The material with every length twice as long, and as many features."""
    changes = {}
    for key, field in material_class(name).model_fields.items():
        value = getattr(material(name), key)
        if value is None or isinstance(value, str) or key in TABLE[name].fixed:
            continue
        if is_length(field):
            changes[key] = tuple(2 * each for each in value) if isinstance(value, tuple) else 2 * value
        elif field.description and ("per mm^2" in field.description or "per 1000 mm^2" in field.description):
            changes[key] = value / 4
    return material(name, **changes)


def is_length(field):
    if field.annotation in (parameters.LengthDraw, parameters.LengthField.__origin__):
        return True
    return any(
        getattr(mark, "func", None) is parameters.Length.__metadata__[0].func for mark in field.metadata
    )


@pytest.mark.parametrize("name", [name for name in TABLE if TABLE[name].calm])
def test_rotation_and_renumbering_leave_placed_features_alone(ring, name):
    turned, face = renumbered(ring)
    calm = material(name, **TABLE[name].calm)
    first = calm.place(ring, 4)
    moved = {}
    for kind, table in first.features.items():
        moved[kind] = table.copy()
        moved[kind]["face"] = face[table["face"]]
    second = calm.place(turned, 4, features=moved)
    here = samples_on(ring)
    there = Samples(SurfacePoints(face[here.points.face], here.points.barycentric), here.footprint_mm)
    one, other = first.at(here)["height_mm"], second.at(there)["height_mm"]
    assert np.ptp(one) > 0.01
    np.testing.assert_allclose(one, other, atol=1e-4)


@pytest.mark.parametrize("radius", [None, 6.0])
def test_rotation_and_renumbering_leave_distances_alone(ring, radius):
    turned, face = renumbered(ring)
    sources, at = scatter(ring, stream(2, "sources"), count=3), samples_on(ring).points
    there = [SurfacePoints(face[each.face], each.barycentric) for each in (sources, at)]
    first = sx.geodesic_distance(ring, sources, at, radius=radius)
    second = sx.geodesic_distance(turned, *there, radius=radius)
    np.testing.assert_allclose(first, second, rtol=1e-9, atol=1e-9)


def renumbered(surface):
    """A turned copy with faces and vertices in another order, and the new number of each face."""
    axis = np.linalg.qr(np.array([[1.0, 2, 3], [0, 1, 4], [5, 6, 0]]))[0]
    axis *= np.linalg.det(axis)
    vertex = np.argsort(stream(3, "vertices").uniform(len(surface.vertices), 1)[:, 0])
    order = np.argsort(stream(3, "faces").uniform(len(surface.faces), 1)[:, 0])
    vertices = np.zeros_like(surface.vertices)
    vertices[vertex] = surface.vertices @ axis.T + [5.0, -7.0, 3.0]
    return Surface.from_arrays(vertices, vertex[surface.faces][order]), np.argsort(order)
