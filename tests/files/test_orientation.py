"""Pictures are read as viewers show them: turned as the file says, and never as inks."""

import io
import struct
import zlib

import imagecodecs
import numpy as np
import pytest
from PIL import Image, ImageOps

from surftex.errors import InputError
from surftex.files.decoding import claimed, decoded
from surftex.files.exemplars import read_exemplar
from surftex.files.images import png_bytes
from surftex.files.pictures import read_mask, read_picture
from surftex.files.scene import read_scene
from tests.files.bad_inputs import ball, document, glb_of

PIXELS = np.random.Generator(np.random.PCG64(1)).integers(0, 256, (5, 7, 3), np.uint8)

SHOWN = {
    1: lambda a: a,
    2: np.fliplr,
    3: lambda a: np.rot90(a, 2),
    4: np.flipud,
    5: lambda a: a.swapaxes(0, 1),
    6: lambda a: np.rot90(a, -1),
    7: lambda a: np.rot90(a, 2).swapaxes(0, 1),
    8: np.rot90,
}
"""How a viewer turns what is stored, by the tables of TIFF 6.0 and EXIF."""


def tagged(number, order="<", kind=3):
    """Tags as EXIF holds them: a maker's name, and the orientation."""
    value = struct.pack(order + ("HH" if kind == 3 else "I"), *([number, 0] if kind == 3 else [number]))
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "IH", 8, 2)
    return (
        head
        + struct.pack(order + "HHI4s", 271, 2, 3, b"us\0\0")
        + struct.pack(order + "HHI", 274, kind, 1)
        + value
        + bytes(4)
    )


def jpeg(exif, pixels=PIXELS):
    """A JPEG with what else stands in an APP1 first, then EXIF."""
    data = bytes(imagecodecs.jpeg_encode(pixels, level=95))
    return data[:2] + segment(b"http://ns.adobe.com/xap/1.0/\0<x/>") + segment(b"Exif\0\0" + exif) + data[2:]


def segment(content):
    return b"\xff\xe1" + struct.pack(">H", len(content) + 2) + content


def png(exif, *, behind=False):
    data = png_bytes(PIXELS)
    at = len(data) - 12 if behind else 33
    chunk = struct.pack(">I", len(exif)) + b"eXIf" + exif + struct.pack(">I", zlib.crc32(b"eXIf" + exif))
    return data[:at] + chunk + data[at:]


def tiff(number, **options):
    file = io.BytesIO()
    Image.fromarray(PIXELS).save(file, "TIFF", tiffinfo={274: number}, **options)
    return file.getvalue()


@pytest.mark.parametrize("number", SHOWN)
@pytest.mark.parametrize("order", ["<", ">"])
def test_a_jpeg_is_turned_wherever_it_is_read(number, order, tmp_path):
    (tmp_path / "a.jpg").write_bytes(jpeg(tagged(number, order)))
    shown = SHOWN[number](decoded(bytes(imagecodecs.jpeg_encode(PIXELS, level=95)), "plain"))
    np.testing.assert_array_equal(read_exemplar(tmp_path / "a.jpg"), shown)
    np.testing.assert_array_equal(read_picture(tmp_path / "a.jpg"), shown / 255)
    np.testing.assert_array_equal(read_mask(tmp_path / "a.jpg", "green"), shown[..., 1] / 255)


@pytest.mark.parametrize("number", SHOWN)
@pytest.mark.parametrize("options", [{}, {"compression": "jpeg"}])
def test_a_tiff_is_turned_once(number, options):
    """By us, also where libtiff would mirror it: what holds a JPEG."""
    stored = decoded(tiff(1, **options), "stored")
    np.testing.assert_array_equal(decoded(tiff(number, **options), "turned"), SHOWN[number](stored))


@pytest.mark.parametrize("number", SHOWN)
@pytest.mark.parametrize(("order", "behind"), [("<", False), (">", True)])
def test_a_png_is_turned_as_others_turn_it(number, order, behind):
    data = png(tagged(number, order), behind=behind)
    turned = decoded(data, "png")
    assert turned.flags.c_contiguous
    np.testing.assert_array_equal(turned, SHOWN[number](PIXELS))
    np.testing.assert_array_equal(
        ImageOps.exif_transpose(Image.open(io.BytesIO(data))), SHOWN[number](PIXELS)
    )


def test_a_grey_jpeg_is_turned():
    grey = PIXELS[..., 0].copy()
    stored = decoded(bytes(imagecodecs.jpeg_encode(grey, level=95)), "stored")
    np.testing.assert_array_equal(decoded(jpeg(tagged(6), grey), "turned"), SHOWN[6](stored))


def test_a_texture_of_a_scene_is_not_turned(tmp_path):
    """Of glTF: orientation in the metadata of an image is ignored."""
    data = png(tagged(6))
    doc, binary = document(*ball())
    doc["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
    doc["buffers"][0]["byteLength"] += len(data)
    doc["images"], doc["textures"] = [{"bufferView": 2, "mimeType": "image/png"}], [{"source": 0}]
    doc["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    doc["meshes"][0]["primitives"][0]["material"] = 0
    (tmp_path / "a.glb").write_bytes(glb_of(doc, binary + data))
    (body,) = read_scene(tmp_path / "a.glb")
    np.testing.assert_array_equal(body.pictures["base_color"], PIXELS)


@pytest.mark.parametrize(
    "exif",
    [
        b"", b"II*\0", b"XX*\0" + tagged(6)[4:], tagged(6)[:30], tagged(0), tagged(9), tagged(6, kind=2),
        tagged(2**31, kind=4), b"II*\0" + b"\xff" * 40, b"II+\0\x08\0\0\0" + b"\xff" * 40, b"MM\0*" + bytes(40),
    ],
)  # fmt: skip
def test_broken_exif_is_upright(exif):
    plain = decoded(bytes(imagecodecs.jpeg_encode(PIXELS, level=95)), "plain")
    np.testing.assert_array_equal(decoded(jpeg(exif), "broken"), plain)


def test_tags_that_are_cut_off_after_the_orientation_count():
    plain = decoded(bytes(imagecodecs.jpeg_encode(PIXELS, level=95)), "plain")
    more = tagged(6)[:8] + b"\x09\0" + tagged(6)[10:]
    np.testing.assert_array_equal(decoded(jpeg(more), "cut"), SHOWN[6](plain))


@pytest.mark.parametrize("name", ["print.jpg", "print.tif"])
def test_inks_are_refused_in_the_same_words(name, tmp_path):
    Image.new("CMYK", (64, 64), (9, 99, 30, 0)).save(tmp_path / name)
    readers = [read_mask, read_picture, read_exemplar] if name.endswith("jpg") else [read_mask, read_picture]
    for reader in readers:
        with pytest.raises(InputError, match=rf"{name}'?: is CMYK, for printers; convert it to RGB$"):
            reader(tmp_path / name)


def test_four_channels_of_a_tiff_that_are_light_are_read(tmp_path):
    pixels = np.dstack([PIXELS, PIXELS[..., 0]])
    (tmp_path / "a.tif").write_bytes(imagecodecs.tiff_encode(pixels, photometric="rgb"))
    np.testing.assert_array_equal(read_mask(tmp_path / "a.tif", "alpha"), pixels[..., 3] / 255)


def test_tags_far_beyond_the_end_are_a_line():
    with pytest.raises(InputError, match="cut off within its head, or damaged"):
        claimed(b"II+\0\x08\0\0\0" + b"\xff" * 8, "a")
