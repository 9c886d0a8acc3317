"""Skin: placement, blending of all that reaches, and what comes out."""

import numpy as np
import pytest

from surftex.bake.bake import bake
from surftex.errors import RecipeError
from surftex.fields.fieldset import FieldSet
from surftex.fields.vectors import VectorField
from surftex.materials.layers import RAW
from surftex.materials.skin.kinds import KINDS, STATE
from surftex.materials.skin.model import Skin
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.shapes import plane, sphere

CALM = {
    "variation": 0, "drift": 0, "mottle": 0, "flush": 0, "tan": 0, "pore_density": 0, "relief_depth": 0, "relief_secondary": 0,
    "relief_swell": 0,
}  # fmt: skip


def samples_on(surface, count=4000, footprint_mm=0.01):
    from surftex.features.uniform import scatter
    from surftex.randomness import stream

    points = scatter(surface, stream(3, "samples"), count=count)
    return Samples(points, np.full(count, footprint_mm, np.float32))


def one_feature(kind, face, barycentric, **columns):
    names = [("face", "i4"), ("barycentric", "f8", 3), *[(name, "f4") for name in columns]]
    table = np.zeros(1, names)
    table["face"], table["barycentric"] = face, barycentric
    for name, value in columns.items():
        table[name] = value
    return {kind: table}


def test_two_freckles_that_overlap_add_up():
    sheet = plane(20.0)
    skin = Skin(**CALM, freckle_irregularity=0.0)
    table = np.concatenate(
        [
            one_feature("freckle", 0, (1 / 3, 1 / 3, 1 / 3), radius_mm=r, melanin=m, pheomelanin=0.1)[
                "freckle"
            ]
            for r, m in ((3.0, 0.05), (2.0, 0.03))
        ]
    )
    samples = samples_on(sheet)
    middle = SurfacePoints([0], [[1 / 3, 1 / 3, 1 / 3]]).positions(sheet)[0]
    distance = np.linalg.norm(samples.points.positions(sheet) - middle, axis=1)
    pattern = skin.place(sheet, features={"freckle": table})
    melanin = pattern.at(samples)["melanin"]
    wanted = skin.melanin + sum(
        m * np.clip(1 - 1.2 * distance / r, 0, 1) for r, m in ((3.0, 0.05), (2.0, 0.03))
    )
    assert np.abs(melanin - wanted).max() < 2e-3 * 0.05 + 1e-4
    assert (melanin > skin.melanin + 0.03).any()


def test_a_follicle_covers_the_skin_and_takes_the_room_of_blood():
    sheet = plane(4.0)
    skin = Skin(**CALM, follicle_lean=1.0, follicle_shaft=0.2, follicle_radius=0.6, follicle_blood=0.5)
    pattern = skin.place(sheet, features=one_feature("follicle", 0, (1 / 3, 1 / 3, 1 / 3), radius_mm=0.6))
    at_shaft = Samples(SurfacePoints([0], [[1 / 3, 1 / 3, 1 / 3]]), np.full(1, 0.001, np.float32))
    layers = pattern.at(at_shaft)
    assert layers["hair"][0] == pytest.approx(skin.follicle_cover, abs=0.01)
    assert layers["blood"][0] == pytest.approx(skin.blood * 0.5, rel=1e-3)
    assert layers["height_mm"][0] == pytest.approx(skin.follicle_height, rel=1e-3)


def test_the_mean_of_hair_stays_where_single_hairs_cannot_be_seen():
    sheet = plane(30.0)
    skin = Skin(**CALM, follicle_density=3.0, follicle_lean=1.0)
    pattern = skin.place(sheet, 4)
    fine = pattern.at(samples_on(sheet, 40000, 0.005))["hair"].mean()
    coarse = pattern.at(samples_on(sheet, 2000, 2.0))["hair"].mean()
    assert fine > 0.02
    assert coarse == pytest.approx(fine, rel=0.08)


def test_features_come_back_from_their_table():
    ball = sphere(8.0, subdivisions=3)
    skin = Skin.preset(
        "thesis", follicle_count=300, cyst_count=5, mole_count=4, freckle_count=6, wrinkle_count=3
    )
    first = skin.place(ball, 5)
    again = skin.place(ball, 5, features=first.features)
    samples = samples_on(ball, 500)
    a, b = first.at(samples), again.at(samples)
    assert all(np.array_equal(a[name], b[name]) for name in first.channels)
    assert len(first.features["follicle"]) == 300


def test_raw_parameters_are_baked_when_asked_for():
    ball = sphere(5.0, subdivisions=2)
    plain = bake(ball, Skin(**CALM), resolution=32, unwrapper="uvunwrap")
    assert not set(plain) & set(RAW)
    assert {"subsurface", "subsurface_radius_mm", "specular"} <= set(plain)
    raw = bake(
        ball, Skin(**CALM, melanin=0.1), resolution=32, unwrapper="uvunwrap", maps="melanin,epidermis_mm"
    )
    assert np.allclose(raw["melanin"], 0.1)
    assert np.allclose(raw["epidermis_mm"], 0.08)


def test_a_darker_skin_is_darker_and_blood_makes_it_redder():
    sheet = plane(4.0)
    samples = samples_on(sheet, 4)
    light, dark, red = (
        Skin(**CALM, **more).place(sheet).at(samples)["base_color"][0]
        for more in ({}, {"melanin": 0.2}, {"blood": 0.05})
    )
    assert (dark < light).all()
    assert red[1] / red[0] < light[1] / light[0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"freckle_where": "1 - nose", "freckle_count": 3}, "skin.freckle_where.*unknown field 'nose'"),
        ({"order": ("pore",)}, "skin.order: it lists pore"),
        ({"follicle_count": 6_000_000}, "most of them follicles"),
        ({"relief_direction": "langer"}, "unknown direction 'langer'"),
    ],
)
def test_mistakes_are_told_in_a_line(changes, message):
    sheet = plane(4.0)
    with pytest.raises(RecipeError, match=message):
        Skin(**changes).place(sheet, fields=FieldSet(sheet))


def test_every_kind_has_its_parameters():
    for kind in KINDS:
        assert {f"{kind}_{key}" for key in ("count", "density", "where")} <= set(Skin.model_fields)
    assert all(change.channel in STATE for kind in KINDS.values() for change in kind.changes(Skin()))


def test_a_mask_smaller_than_a_face_keeps_its_features_and_their_mean():
    sheet = plane(20.0, cells=1)
    dot = "x > 4 and x < 5 and y > 4 and y < 4.5"
    skin = Skin(**CALM, freckle_count=12, freckle_where=dot)
    pattern = skin.place(sheet, 4)
    kind = pattern.points[0]
    assert kind.per_mm2 == pytest.approx(12 / 0.5, rel=0.1)
    for footprint in (0.01, 1.0, 30.0):
        assert np.isfinite(pattern.at(samples_on(sheet, 400, footprint))["melanin"]).all()


def test_wrinkles_are_as_long_as_their_vectors_and_none_grows_where_these_are_zero():
    sheet = plane(40.0)
    pull = np.where(sheet.vertices[:, :1] > 20, [[0.0, 6.0, 0.0]], [[0.0, 0.0, 0.0]])
    sheet = sheet.with_attributes({"pull": pull})
    fields = FieldSet(sheet, directions={"pull": lambda: VectorField.from_attribute(sheet, "pull")})
    skin = Skin(**CALM, wrinkle_count=60, wrinkle_vectors="pull", wrinkle_where="x < 38 and abs(y - 20) < 12")
    rows = skin.place(sheet, 2, fields=fields).features["wrinkle"]
    x = SurfacePoints(rows["face"], rows["barycentric"]).positions(sheet)[:, 0]
    assert x.min() > 20  # the vectors grow from there to the next vertices, at 22.5
    assert rows["length_mm"][x > 22.6] == pytest.approx(6.0, rel=1e-3)
    assert 15 < len(np.unique(rows["curve"])) < 45


def test_the_ranges_that_the_reference_prints_are_those_of_the_tables():
    import re

    from surftex.materials.skin.baseline import PLAUSIBLE
    from surftex.optics.tissue import PARAMETERS

    for name, known in PARAMETERS.items():
        scale = 10 if name.endswith("_cm") else 1
        ends = [scale * known.low, scale * known.high]
        told = Skin.model_fields[name.removesuffix("_cm")].description
        low, high = re.search(r": ([0-9.]+) to ([0-9.]+?)(?: mm)?[.]$", told).groups()
        assert [float(low), float(high)] == pytest.approx(ends), told
        low, high = PLAUSIBLE[name.replace("_cm", "_mm")]
        assert ends[0] <= low * (1 + 1e-9)
        assert high <= ends[1] * (1 + 1e-9)
