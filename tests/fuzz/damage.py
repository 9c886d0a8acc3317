"""Damage: bytes, documents and arrays with a few random edits, each known by its number."""

import copy
from typing import Any

import numpy as np

from surftex.randomness import stream

WORDS = [b"nan", b"-1", b"0", b"99999999999", b"1e400", b"//", b"\n", b" ", b"null", b"{}", b"[]", b"true", b"\xff",
         b'""', b"1.5"]  # fmt: skip

VALUES = [None, -1, 0, 1, 2, 10**12, 2**70, 1.5, 1e300, float("nan"), float("inf"), True, "", "POSITION", "MAT4",
          "x", "2 mm", "..", [], {}, [0], [[]], {"a": 0}, 5120, 5121, 5123, 5126]  # fmt: skip

NUMBERS = [0, -1, 1, 2, 127, 255, 2**31 - 1, -(2**31), 2**40, 0.5, -0.5, 1e30, -1e30, 1e-30, np.nan, np.inf]


def damaged(data: bytes, name: str, number: int) -> bytes:
    """The bytes after a few random edits."""
    bytes_ = bytearray(data)
    draws = stream(7, "fuzz", name, number).uniform(6, 4)
    for kind, place, size, value in draws[: 1 + (number // 7) % 3]:
        at = int(place * len(bytes_))
        if kind < 0.4:
            bytes_[at : at + 1] = bytes([int(value * 256)])
        elif kind < 0.6:
            bytes_[at : at + 1 + int(size * 4)] = WORDS[int(value * len(WORDS))]
        elif kind < 0.75:
            del bytes_[at : at + 1 + int(size * 30)]
        elif kind < 0.9:
            bytes_[at:at] = bytes_[int(value * len(bytes_)) :][: 1 + int(size * 30)]
        else:
            del bytes_[at:]
        bytes_ = bytes_ or bytearray(b"x")
    return bytes(bytes_)


def places_of(value: Any, above: tuple = ()) -> Any:
    """The place of every value in a JSON document."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, below in items:
        yield (*above, key)
        yield from places_of(below, (*above, key))


def changed(doc: Any, number: int) -> Any:
    """A copy of a document with one to three values replaced or gone."""
    doc = copy.deepcopy(doc)
    for at, kind in stream(7, "document", number).uniform(3, 2)[: 1 + (number // 7) % 3]:
        places = list(places_of(doc))
        if not places:
            return doc
        *above, last = places[int(at * len(places))]
        owner = doc
        for key in above:
            owner = owner[key]
        if kind < 0.15:
            del owner[last]
        else:
            owner[last] = copy.deepcopy(VALUES[int((kind - 0.15) / 0.85 * len(VALUES))])
    return doc


def altered(arrays: dict[str, np.ndarray], number: int) -> dict[str, np.ndarray]:
    """Copies of structured arrays with some numbers, rows, fields or whole arrays otherwise."""
    arrays = {name: table.copy() for name, table in arrays.items()}
    for which, kind, at, value in stream(7, "arrays", number).uniform(3, 4)[: 1 + (number // 7) % 3]:
        names = sorted(arrays)
        if not names:
            return arrays
        name = names[int(which * len(names))]
        table = arrays[name]
        if kind < 0.6 and len(table):
            fields = table.dtype.names or ("",)
            column = table[fields[int(at * len(fields))]] if table.dtype.names else table
            with np.errstate(all="ignore"):
                new = np.array(NUMBERS[int(value * len(NUMBERS))]).astype(column.dtype)
            column[int(at * 7919) % len(column)] = new
        elif kind < 0.7:
            arrays[name] = table[: int(value * len(table))]
        elif kind < 0.8:
            arrays[name] = np.concatenate([table, table])
        elif kind < 0.9 and table.dtype.names:
            kept = [
                field for k, field in enumerate(table.dtype.names) if k != int(at * len(table.dtype.names))
            ]
            slim = np.zeros(len(table), [(field, table.dtype[field]) for field in kept])
            for field in kept:
                slim[field] = table[field]
            arrays[name] = slim
        elif kind < 0.95:
            del arrays[name]
        else:
            arrays[f"other{number % 3}"] = arrays.pop(name)
    return arrays
