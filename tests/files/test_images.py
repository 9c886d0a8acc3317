"""Pictures come back as they were written; codes round, and the same pixels give the same bytes."""

import numpy as np
import pytest

from surftex.errors import InputError, WorkError
from surftex.files.images import (
    normal_codes,
    png_bytes,
    read_exr,
    read_png,
    srgb_codes,
    unit_codes,
    write_exr,
)


@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 3)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_png_round_trip(tmp_path, dtype, shape):
    pixels = np.random.RandomState(0).randint(0, np.iinfo(dtype).max + 1, shape).astype(dtype)
    (tmp_path / "a.png").write_bytes(png_bytes(pixels))
    read = read_png(tmp_path / "a.png")
    assert read.dtype == dtype
    np.testing.assert_array_equal(read, pixels)


def test_png_is_read_alike_by_another_library(tmp_path):
    from PIL import Image

    pixels = np.random.RandomState(0).randint(0, 65536, (5, 7)).astype(np.uint16)
    (tmp_path / "a.png").write_bytes(png_bytes(pixels))
    with Image.open(tmp_path / "a.png") as image:
        np.testing.assert_array_equal(np.asarray(image), pixels)
    (tmp_path / "b.png").write_bytes(png_bytes(pixels.view(np.uint8).reshape(5, 7, 2)[..., 0]))
    with Image.open(tmp_path / "b.png") as image:
        np.testing.assert_array_equal(np.asarray(image), pixels & 255)


def test_png_refuses_other_arrays():
    for wrong in (np.zeros((4, 4)), np.zeros((4, 4, 2), np.uint8), np.zeros(4, np.uint8)):
        with pytest.raises(InputError, match="PNG takes"):
            png_bytes(wrong)


@pytest.mark.parametrize("shape", [(6, 9), (6, 9, 3)])
def test_exr_round_trip_is_exact(tmp_path, shape):
    image = np.random.RandomState(0).randn(*shape).astype(np.float32) * 1e-3
    write_exr(tmp_path / "a.exr", image)
    (name, read), *others = read_exr(tmp_path / "a.exr").items()
    assert (name, others) == ("Y" if len(shape) == 2 else "RGB", [])
    assert read.dtype == np.float32
    np.testing.assert_array_equal(read, image)
    write_exr(tmp_path / "b.exr", image)
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()


def test_unreadable_files_are_told_in_a_line(tmp_path):
    (tmp_path / "a.png").write_text("no picture")
    (tmp_path / "b.exr").touch()
    for read, name, said in (
        (read_png, "a.png", "no readable"), (read_exr, "a.png", "is no EXR file"), (read_exr, "b.exr", "is empty")
    ):  # fmt: skip
        with pytest.raises(InputError, match=rf"{name}: {said}") as caught:
            read(tmp_path / name)
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="no such file"):
        read_exr(tmp_path / "missing.exr")
    with pytest.raises(WorkError, match="cannot write"):
        write_exr(tmp_path / "missing" / "a.exr", np.zeros((2, 2)))


def test_codes_round_to_the_nearest():
    values = np.random.RandomState(0).rand(100, 9).astype(np.float32)
    np.testing.assert_array_equal(unit_codes(values), np.rint(values * 255))
    exact = 255 * np.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - 0.055)
    assert np.abs(srgb_codes(values) - exact).max() < 0.54
    np.testing.assert_array_equal(unit_codes(np.array([[-1.0, 2.0]])), [[0, 255]])
    np.testing.assert_array_equal(
        srgb_codes(np.array([[-1.0, 0.0, 0.0031308, 1.0, 2.0]])), [[0, 0, 10, 255, 255]]
    )


def test_normal_codes_are_even():
    normal = np.array([[[-1.0, 0.0, 1.0], [0.5, -0.5, 0.25]]])
    codes = normal_codes(normal)
    assert codes.dtype == np.uint16
    np.testing.assert_allclose(codes / 32767.5 - 1, normal, atol=0.51 / 32767.5)
