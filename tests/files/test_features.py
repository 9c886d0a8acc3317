"""Features come back as they were; files made to harm are refused in a line."""

import io
import pickle
import zipfile

import numpy as np
import pytest

from surftex.errors import InputError
from surftex.files.features import load_features, save_features

PORE = np.dtype([("face", np.int32), ("barycentric", np.float64, 3), ("radius_mm", np.float32)])


def pores(count=100):
    random = np.random.RandomState(0)
    array = np.zeros(count, PORE)
    array["face"] = random.randint(0, 1000, count)
    array["barycentric"] = random.dirichlet([1, 1, 1], count)
    array["radius_mm"] = random.rand(count)
    return array


def test_round_trip_keeps_every_bit(tmp_path):
    sites = pores(7)[["face", "barycentric"]].astype(PORE.descr[:2])
    save_features(tmp_path / "f.npz", {"pores": pores(), "sites": sites, "none": pores(0)})
    loaded = load_features(tmp_path / "f.npz")
    assert list(loaded) == ["none", "pores", "sites"]
    assert loaded["pores"].dtype == PORE
    assert loaded["pores"].tobytes() == pores().tobytes()
    assert loaded["sites"].tobytes() == sites.tobytes()
    assert not loaded["pores"].flags.writeable


def test_same_features_same_bytes(tmp_path):
    save_features(tmp_path / "a.npz", {"b": pores(), "a": pores(3)})
    save_features(tmp_path / "b.npz", {"a": pores(3), "b": pores()})
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert zipfile.ZipFile(tmp_path / "a.npz").infolist()[0].date_time == (1980, 1, 1, 0, 0, 0)


def npy(array, header=None):
    memory = io.BytesIO()
    if header is None:
        np.lib.format.write_array(memory, array, version=(1, 0))
        return memory.getvalue()
    text = (repr(header) if not isinstance(header, str) else header).encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + array


def packed(path, **entries):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            archive.writestr(name.replace("__", "/") + ".npy", data)


def bad_weights():
    array = pores()
    array["barycentric"][4] = [1, 1, 1]
    return array


def not_finite():
    array = pores()
    array["radius_mm"][3] = np.nan
    return array


DESCR = PORE.descr
BAD = {
    "pickle": npy(pickle.dumps([print]), {"descr": "|O", "fortran_order": False, "shape": (1,)}),
    "object field": npy(b"x" * 8, {"descr": [("face", "|O")], "fortran_order": False, "shape": (1,)}),
    "header that does not end": npy(b"x" * 32, "{'descr': '<i4', 'shape': (1,"),
    "huge count": npy(b"x" * 32, {"descr": DESCR, "fortran_order": False, "shape": (10**15,)}),
    "negative count": npy(b"x" * 32, {"descr": DESCR, "fortran_order": False, "shape": (-1,)}),
    "huge header": npy(
        b"", {"descr": [(f"f{i}", "<f8") for i in range(2000)], "fortran_order": False, "shape": (1,)}
    ),
    "code in header": npy(b"", "__import__('os').system('true')"),
    "no numbers": npy(np.zeros(3, [("face", "<i4"), ("barycentric", "<f8", 3), ("name", "S9")])),
    "no barycentric": npy(np.zeros(3, [("face", "<i4")])),
    "plain numbers": npy(np.zeros(3)),
    "two axes": npy(pores(4).reshape(2, 2)),
    "weights": npy(bad_weights()),
    "not finite": npy(not_finite()),
    "truncated": npy(pores())[:-10],
    "empty": b"",
}


@pytest.mark.parametrize("name", BAD)
def test_bad_arrays_are_refused_in_a_line(name, tmp_path):
    packed(tmp_path / "f.npz", pores=BAD[name])
    with pytest.raises(InputError, match=r"f\.npz: pores\.npy: ") as caught:
        load_features(tmp_path / "f.npz")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400 + len(str(tmp_path))


def test_bad_files_are_refused_in_a_line(tmp_path):
    path = tmp_path / "f.npz"
    for data in (b"", b"PK\x03\x04 no zip", pickle.dumps({"a": 1})):
        path.write_bytes(data)
        with pytest.raises(InputError, match="no features file"):
            load_features(path)
    with pytest.raises(InputError, match="no such file"):
        load_features(tmp_path / "missing.npz")
    packed(path, **{f"k{i}": b"" for i in range(100)})
    with pytest.raises(InputError, match="100 entries"):
        load_features(path)
    packed(path, **{"..__..__escape": npy(pores())})
    with pytest.raises(InputError, match="no name of a kind"):
        load_features(path)


def test_zip_bombs_are_refused_before_they_unfold(tmp_path):
    path = tmp_path / "f.npz"
    packed(path, pores=b"\0" * 50_000_000)
    assert path.stat().st_size < 100_000
    with pytest.raises(InputError, match="limit is 1000000"):
        load_features(path, max_bytes=1_000_000)
    data = bytearray(path.read_bytes())
    for signature, offset in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        place = data.index(signature) + offset
        data[place : place + 4] = (100).to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"f\.npz"):
        load_features(path, max_bytes=1_000_000)


def test_saving_refuses_what_loading_would(tmp_path):
    with pytest.raises(InputError, match="sum is not 1; the first is 4"):
        save_features(tmp_path / "f.npz", {"pores": bad_weights()})
