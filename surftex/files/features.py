"""Everything that was placed on a surface, in one file: a bake can start from it and give the same bytes.

An npz of one structured array per kind, each with `face`, `barycentric`, and the kind's own parameters.
Reading trusts nothing: no pickled objects, no array larger than the limit, no field that is not plain
numbers.
"""

import io
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError

MAX_BYTES = 2 << 30
"""Most bytes that the arrays of a file may have together."""

MAX_KINDS = 64
"""Most kinds of features in a file."""

_MAX_HEADER = 10_000


def save_features(
    path: str | Path | BinaryIO, features: Mapping[str, NDArray[Any]], told: Mapping[str, Any] | None = None
) -> None:
    """Write features; the same arrays always give the same bytes.

    Parameters
    ----------
    path : path or file
        Of the file; replaced if it is there. `surftex.files.output` makes that safe.
    features : mapping of str to structured array
        By kind: ``face`` (int), ``barycentric`` (3 floats), then any numbers.
    told : mapping, optional
        What placed them, in JSON types: kept as the comment of the archive, where it has room (64 KiB).

    Raises
    ------
    InputError
        If an array would be refused on reading.
    """
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=4) as archive:
        for kind in sorted(features):
            array = np.ascontiguousarray(features[kind])
            _check(f"features[{kind!r}]", kind, array)
            memory = io.BytesIO()
            np.lib.format.write_array(memory, array, version=(1, 0), allow_pickle=False)
            entry = zipfile.ZipInfo(f"{kind}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            entry.create_system = 3
            archive.writestr(entry, memory.getvalue())
        comment = b"" if told is None else json.dumps(told, sort_keys=True).encode()
        archive.comment = comment if len(comment) <= zipfile.ZIP_MAX_COMMENT else b""


def features_told(path: str | Path) -> dict[str, Any] | None:
    """Read what placed the features of a file.

    Parameters
    ----------
    path : path
        A file that `load_features` reads.

    Returns
    -------
    told : dict or None
        As `save_features` was told; None where the file does not say.
    """
    with zipfile.ZipFile(path) as archive:
        try:
            told = json.loads(archive.comment)
        except (ValueError, RecursionError):
            return None
    return told if isinstance(told, dict) else None


def load_features(path: str | Path, *, max_bytes: int = MAX_BYTES) -> dict[str, NDArray[Any]]:
    """Read features.

    Parameters
    ----------
    path : path
        A file that `save_features` wrote.
    max_bytes : int
        Most bytes of all arrays together.

    Returns
    -------
    features : dict of str to structured array
        By kind, in order of names; read-only.

    Raises
    ------
    InputError
        If the file is missing, is something else, or holds what could not be features: in one line.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            if len(entries) > MAX_KINDS:
                raise InputError(f"{path}: {len(entries)} entries; features have at most {MAX_KINDS} kinds")
            total = sum(entry.file_size for entry in entries)
            if total > max_bytes:
                raise InputError(f"{path}: {total} bytes of arrays; the limit is {max_bytes}")
            result: dict[str, NDArray[Any]] = {}
            for entry in sorted(entries, key=lambda entry: entry.filename):
                kind = entry.filename.removesuffix(".npy")
                if kind in result:
                    raise InputError(f"{path}: two entries are called {entry.filename}")
                result[kind] = _read(f"{path}: {entry.filename}", kind, archive, entry)
            return result
    except (zipfile.BadZipFile, OSError, EOFError, RuntimeError, NotImplementedError) as problem:
        raise InputError(
            f"{path}: is no features file, such as features.npz of a bake: {_line(problem)}"
        ) from None


def _read(where: str, kind: str, archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray[Any]:
    """Read one array; its header must agree with its size before memory is given to it."""
    import zlib
    from tokenize import TokenError

    try:
        with archive.open(entry) as stream:
            if np.lib.format.read_magic(stream) != (1, 0):
                raise InputError(f"{where}: unknown version of the npy format")
            shape, fortran, dtype = np.lib.format.read_array_header_1_0(stream, max_header_size=_MAX_HEADER)
            start = stream.tell()
            size = entry.file_size - start
            if dtype.hasobject or dtype.itemsize == 0 or len(shape) != 1 or fortran:
                raise InputError(f"{where}: shape {shape} of {str(dtype)[:80]} is no list of features")
            if shape[0] < 0 or shape[0] * dtype.itemsize != size:
                raise InputError(
                    f"{where}: says {shape[0]} rows of {dtype.itemsize} bytes, holds {size} bytes"
                )
            data = stream.read(size + 1)
    except (ValueError, SyntaxError, TypeError, TokenError, zlib.error, MemoryError) as problem:
        raise InputError(f"{where}: no readable array: {_line(problem)}") from None
    if len(data) != size:
        raise InputError(f"{where}: says {size} bytes, holds {len(data)}")
    array = np.frombuffer(data, dtype)
    _check(where, kind, array)
    return array


def _check(where: str, kind: str, array: NDArray[Any]) -> None:
    """Refuse arrays that are no features."""
    if not kind.isidentifier():
        raise InputError(f"{where}: {kind[:80]!r} is no name of a kind, made of letters and digits")
    fields = array.dtype.fields
    if array.ndim != 1 or fields is None or "face" not in fields or "barycentric" not in fields:
        raise InputError(f"{where}: takes one row per feature, with at least the fields face and barycentric")
    for name, field in fields.items():
        if field[0].base.kind not in "biuf":
            raise InputError(f"{where}: field {name!r} holds {field[0]}, not numbers")
        values = array[name]
        if field[0].base.kind == "f" and not np.isfinite(values).all():
            row = int(np.argwhere(~np.isfinite(values))[0][0])
            raise InputError(f"{where}: {name} of feature {row} is not finite")
    if fields["face"][0].kind not in "iu" or fields["barycentric"][0].shape != (3,):
        raise InputError(f"{where}: takes face as whole numbers and barycentric as three numbers")
    wrong = np.flatnonzero((array["face"] < 0) | (np.abs(array["barycentric"].sum(axis=1) - 1) > 1e-4))
    if len(wrong):
        raise InputError(
            f"{where}: {len(wrong)} features lie on no face or have weights whose sum is not 1; "
            f"the first is {int(wrong[0])}"
        )


def _line(problem: BaseException) -> str:
    """Shorten a message of a library to a line."""
    return (str(problem).splitlines() or [type(problem).__name__])[0][:200]
