"""Pictures and archives that claim to unfold to more than there is memory: refused from their heads, at once."""

import io
import json
import resource
import struct
import zipfile

import numpy as np
import pytest
from PIL import Image

from surftex.errors import InputError
from surftex.files.decoding import MOST_NUMBERS, claimed, decoded, kind_of
from surftex.files.exemplars import read_exemplar
from surftex.files.images import png_bytes, read_exr, read_png, write_exr
from surftex.files.pictures import read_picture
from surftex.files.scene import read_scene
from surftex.optics.table import SkinTable
from tests.files.bad_inputs import ball, document, glb_of
from tests.fuzz.targets import with_sums

PIXELS = np.arange(5 * 7 * 3, dtype=np.uint8).reshape(5, 7, 3)


def packed(kind):
    import imagecodecs

    return {"PNG": png_bytes, "JPEG": imagecodecs.jpeg_encode, "TIFF": imagecodecs.tiff_encode}[kind](PIXELS)


def exr(tmp_path):
    write_exr(tmp_path / "a.exr", PIXELS / np.float32(9))
    return (tmp_path / "a.exr").read_bytes()


def swollen(data, side=60000):
    """The picture with another size in its head."""
    if kind_of(data) == "PNG":
        return data[:16] + struct.pack(">II", side, side) + data[24:]
    if kind_of(data) == "JPEG":
        at = data.index(b"\xff\xc0") + 5
        return data[:at] + struct.pack(">HH", side, side) + data[at + 4 :]
    if kind_of(data) == "EXR":
        for name in (b"dataWindow\0box2i\0", b"displayWindow\0box2i\0"):
            at = data.index(name) + len(name) + 4
            data = data[:at] + struct.pack("<4i", 0, 0, side - 1, side - 1) + data[at + 16 :]
        return data
    (first,) = struct.unpack_from("<I", data, 4)
    for at in range(first + 2, first + 2 + 12 * struct.unpack_from("<H", data, first)[0], 12):
        if struct.unpack_from("<H", data, at)[0] in (256, 257):
            data = data[: at + 2] + struct.pack("<HII", 4, 1, side) + data[at + 12 :]
    return data


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF"])
def test_a_head_is_read_and_a_bomb_refused(kind, tmp_path):
    data = bytes(packed(kind))
    assert claimed(data, "a") == (7, 5, 3)
    assert decoded(data, "a").shape == (5, 7, 3)
    (tmp_path / "bomb").write_bytes(swollen(data))
    check_refused(read_picture, tmp_path / "bomb", "claims 60000 x 60000")
    if kind != "TIFF":
        check_refused(read_exemplar, tmp_path / "bomb", "60000 x 60000")
    if kind == "PNG":
        check_refused(read_png, tmp_path / "bomb", "60000 x 60000")


def test_an_exr_bomb_is_refused(tmp_path):
    data = exr(tmp_path)
    assert claimed(data, "a") == (7, 5, 3)
    assert read_exr(tmp_path / "a.exr")["RGB"].shape == (5, 7, 3)
    (tmp_path / "bomb.exr").write_bytes(swollen(data))
    check_refused(read_picture, tmp_path / "bomb.exr", "claims 60000 x 60000")
    check_refused(read_exr, tmp_path / "bomb.exr", "claims 60000 x 60000")


@pytest.mark.parametrize("keep", [4, 9, 17, 25, 40])
@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF", "EXR"])
def test_a_head_that_is_cut_off_is_a_line(kind, keep, tmp_path):
    data = exr(tmp_path) if kind == "EXR" else bytes(packed(kind))
    (tmp_path / "cut").write_bytes(data[:keep])
    check_refused(read_picture, tmp_path / "cut", "")


@pytest.mark.parametrize("kind", ["PNG", "EXR"])
def test_data_that_is_damaged_within_is_refused_and_nothing_is_printed(kind, tmp_path, capfd):
    """Libraries print a warning here, and go on with pixels that are none."""
    if kind == "EXR":
        write_exr(tmp_path / "a", np.random.Generator(np.random.PCG64(1)).random((20, 100)).repeat(10, 0))
    else:
        noise = np.random.Generator(np.random.PCG64(1)).integers(0, 255, (90, 90), np.uint8)
        (tmp_path / "a").write_bytes(png_bytes(noise))
    data = bytearray((tmp_path / "a").read_bytes())
    middle = len(data) // 2
    data[middle : middle + 40] = bytes(40)
    (tmp_path / "a").write_bytes(with_sums(bytes(data)) if kind == "PNG" else data)
    check_refused(read_picture, tmp_path / "a", f"is a damaged {kind}")
    assert capfd.readouterr() == ("", "")


def test_a_bomb_within_a_scene_is_refused(tmp_path):
    v, f = ball()
    doc, binary = document(v, f)
    bomb = swollen(bytes(packed("PNG")))
    doc["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(bomb)})
    doc["buffers"][0]["byteLength"] += len(bomb)
    doc["images"], doc["textures"] = [{"bufferView": 2, "mimeType": "image/png"}], [{"source": 0}]
    doc["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    doc["meshes"][0]["primitives"][0]["material"] = 0
    (tmp_path / "a.glb").write_bytes(glb_of(doc, binary + bomb))
    check_refused(read_scene, tmp_path / "a.glb", "claims 60000 x 60000")
    doc["materials"] = [{"pbrMetallicRoughness": [1]}]
    (tmp_path / "a.glb").write_bytes(glb_of(doc, binary))
    check_refused(read_scene, tmp_path / "a.glb", "")


def test_an_archive_bomb_is_no_table_of_skin(monkeypatch):
    monkeypatch.setattr("surftex.optics.table._MOST_BYTES", 2**24)
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open("values.npy", "w", force_zip64=True) as entry:
            np.lib.format.write_array_header_1_0(
                entry, {"descr": "<f4", "fortran_order": False, "shape": (2**23,)}
            )
            for _ in range(2**5):
                entry.write(bytes(2**20))
        archive.writestr("settings.npy", npy(np.frombuffer(json.dumps({}).encode(), np.uint8)))
    assert len(target.getvalue()) < 2**20
    check_refused(lambda path: SkinTable.from_bytes(target.getvalue()), "", "no table of skin (ValueError)")


def npy(array):
    memory = io.BytesIO()
    np.save(memory, array)
    return memory.getvalue()


def check_refused(reader, path, says):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(InputError) as caught:
        reader(path)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < MOST_NUMBERS / 1024


def test_a_jpeg_that_is_cut_off_is_refused_wherever_it_ends(tmp_path):
    import imagecodecs

    random = np.random.Generator(np.random.PCG64(1))
    for pixels in (
        random.integers(0, 256, (96, 96), np.uint8),
        random.integers(0, 256, (64, 64, 3), np.uint8),
    ):
        data = bytes(imagecodecs.jpeg_encode(pixels, level=95))
        assert decoded(data, "whole").shape == pixels.shape
        assert decoded(data + b"\0\0 more", "followed").shape == pixels.shape
        for share in (0.4, 0.75, 0.99):
            with pytest.raises(InputError, match=r"half: is a damaged JPEG \(it is cut off before its end\)"):
                decoded(data[: int(share * len(data))], "half")


def test_whole_numbers_of_32_bits_are_refused(tmp_path):
    import imagecodecs

    (tmp_path / "wide.tif").write_bytes(imagecodecs.tiff_encode(np.arange(12, dtype=np.uint32).reshape(3, 4)))
    check_refused(read_picture, tmp_path / "wide.tif", "holds whole numbers of 32 bits")
    (tmp_path / "well.tif").write_bytes(imagecodecs.tiff_encode(np.full((3, 4), 65535, np.uint16)))
    assert (read_picture(tmp_path / "well.tif") == 1).all()


@pytest.mark.parametrize("kind", ["WEBP", "BMP", "GIF"])
def test_other_kinds_of_pictures_are_to_be_saved_as_png(kind, tmp_path):
    Image.fromarray(PIXELS).save(tmp_path / "mask", kind)
    for reader in (read_picture, read_exemplar):
        with pytest.raises(InputError, match=r"mask'?:? is (none of|neither) PNG.*; save it as PNG$"):
            reader(tmp_path / "mask")
