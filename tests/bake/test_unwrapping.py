"""The unwrap beside other work: whose UVs are taken, and that a failure elsewhere ends it at once."""

import importlib
import time

import pytest

from surftex.bake.stages import Stages
from surftex.bake.unwrapping import Unwrapping
from surftex.charts.atlas import Atlas
from surftex.errors import InputError
from surftex.recipe.model import BakeSettings
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface


def test_a_failure_elsewhere_ends_the_unwrap(monkeypatch):
    ended = []

    def endless(surface, *, tick, **options):
        begun = time.monotonic()
        try:
            while time.monotonic() - begun < 20:
                tick(0.5)
                time.sleep(0.01)
        finally:
            ended.append(time.monotonic() - begun)

    monkeypatch.setattr(importlib.import_module("surftex.charts.unwrap"), "unwrap", endless)

    def fail_beside_it():
        with Unwrapping(sphere(subdivisions=1), BakeSettings(unwrapper="xatlas"), Stages()) as unwrapping:
            while unwrapping.future is None or not unwrapping.future.running():
                time.sleep(0.01)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail_beside_it()
    assert ended[0] < 10


def test_own_uvs_that_will_not_do_are_left_with_a_note():
    sheet = plane(10.0, cells=2)
    heap = Surface.from_arrays(
        sheet.vertices, sheet.faces, corner_uv=sheet.corner_uv * 0 + sheet.corner_uv[:1]
    )
    stages = Stages()
    with Unwrapping(heap, BakeSettings(resolution=64, unwrapper="uvunwrap"), stages) as unwrapping:
        atlas = unwrapping.atlas()
    assert isinstance(atlas, Atlas)
    assert atlas.unwrapper == "uvunwrap"
    assert unwrapping.notes[0].startswith("unwrapped anew: the UVs of surface cannot be baked on: ")
    assert [stage["name"] for stage in stages.done] == ["own uv", "unwrap"]
    with (
        pytest.raises(InputError, match="cannot be baked on"),
        Unwrapping(heap, BakeSettings(uv="keep"), Stages()),
    ):
        pass


def test_own_uvs_are_taken_where_they_will_do():
    with Unwrapping(plane(10.0), BakeSettings(resolution=64), Stages()) as unwrapping:
        assert unwrapping.atlas().unwrapper == "own"
    with Unwrapping(plane(10.0), BakeSettings(resolution=64, uv="unwrap"), Stages()) as unwrapping:
        assert unwrapping.atlas().unwrapper in ("xatlas", "uvunwrap")
