"""Numbers of a glTF file: accessors, checked against the bytes that are there before any array is made."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError
from surftex.files.reading import printable

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_MOST_WITHOUT_BYTES = 16_000_000


class Document:
    """The JSON of a glTF file and its buffers, behind getters that trust neither.

    Parameters
    ----------
    json : dict
        The document.
    buffers : list of bytes
        Contents of each buffer.
    where : str
        File name for messages.
    """

    def __init__(self, json: dict[str, Any], buffers: list[bytes], where: str) -> None:
        self.json, self.buffers, self.where = json, buffers, where

    def fail(self, reason: str) -> MeshFileError:
        """Make an error that names the file.

        Parameters
        ----------
        reason : str
            What is wrong.

        Returns
        -------
        error : MeshFileError
            To be raised.
        """
        return MeshFileError(f"{self.where}: {reason}")

    def listed(self, key: str) -> list[Any]:
        """Take a top-level list.

        Parameters
        ----------
        key : str
            Such as "nodes".

        Returns
        -------
        items : list
            Empty if the document has none.
        """
        items = self.json.get(key, [])
        if not isinstance(items, list):
            raise self.fail(f"{key!r} is not a list")
        return items

    def item(self, key: str, index: Any) -> dict[str, Any]:
        """Take one entry of a top-level list.

        Parameters
        ----------
        key : str
            Such as "nodes".
        index : int
            Which.

        Returns
        -------
        entry : dict
            The entry.
        """
        items = self.listed(key)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(items):
            raise self.fail(
                f"refers to {key}[{printable(str(index), longest=20)}], but there are {len(items)}"
            )
        if not isinstance(items[index], dict):
            raise self.fail(f"{key}[{index}] is not an object")
        return items[index]

    def whole(self, owner: dict[str, Any], key: str, default: int | None, what: str) -> int:
        """Take a whole number of at least 0.

        Parameters
        ----------
        owner : dict
            Where it stands.
        key : str
            Its name.
        default : int or None
            None if it must be there.
        what : str
            Name of the owner, for messages.

        Returns
        -------
        number : int
            The number.
        """
        value = owner.get(key, default)
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if not isinstance(value, int) or isinstance(value, bool) or value < 0:
            raise self.fail(f"{what} has no whole number {key!r}")
        return value

    def numbers(self, values: Any, length: int, what: str) -> list[float]:
        """Take a list of finite numbers.

        Parameters
        ----------
        values : object
            What the JSON holds.
        length : int
            How many there must be.
        what : str
            Its name.

        Returns
        -------
        numbers : list of float
            The numbers.
        """
        good = isinstance(values, list) and len(values) == length
        good = good and all(
            isinstance(v, (int, float)) and not isinstance(v, bool) and abs(v) < 1e100 for v in values
        )
        if not good:
            raise self.fail(f"{what} is not {length} finite numbers")
        return [float(v) for v in values]

    def view(self, index: Any) -> tuple[memoryview, int | None]:
        """Take the bytes of a buffer view.

        Parameters
        ----------
        index : int
            Which.

        Returns
        -------
        data : memoryview
            Its bytes.
        stride : int or None
            Bytes from one element to the next, where it says so.
        """
        view, what = self.item("bufferViews", index), f"bufferViews[{index}]"
        extensions = view.get("extensions")
        if isinstance(extensions, dict) and any("meshopt" in str(name) for name in extensions):
            raise self.fail(f"{what} is packed with meshopt; export it without compression")
        which = self.whole(view, "buffer", None, what)
        if which >= len(self.buffers):
            raise self.fail(f"{what} refers to buffer {which} of {len(self.buffers)}")
        offset, length = self.whole(view, "byteOffset", 0, what), self.whole(view, "byteLength", None, what)
        if offset + length > len(self.buffers[which]):
            raise self.fail(f"{what} needs {offset + length} bytes of a buffer of {len(self.buffers[which])}")
        stride = self.whole(view, "byteStride", 0, what)
        return memoryview(self.buffers[which])[offset : offset + length], stride or None

    def accessor(self, index: Any, kinds: tuple[str, ...]) -> NDArray[Any]:
        """Read an accessor.

        Parameters
        ----------
        index : int
            Which.
        kinds : tuple of str
            Element types that fit its use, such as ("VEC3",).

        Returns
        -------
        values : (count, width) ndarray
            Normalised integers as float64, all else in the file's type.
        """
        accessor, what = self.item("accessors", index), f"accessors[{index}]"
        kind, component = accessor.get("type"), accessor.get("componentType")
        if kind not in kinds or not isinstance(kind, str):
            raise self.fail(
                f"{what} is of type {printable(str(kind), longest=20)}; its use takes {' or '.join(kinds)}"
            )
        if not isinstance(component, int) or component not in _COMPONENTS:
            raise self.fail(f"{what} has the unknown component type {printable(str(component), longest=20)}")
        dtype, width = np.dtype(_COMPONENTS[component]), _WIDTHS[kind]
        count = self.whole(accessor, "count", None, what)
        if accessor.get("bufferView") is None:
            if count > _MOST_WITHOUT_BYTES:
                raise self.fail(f"{what} claims {count} elements without any bytes")
            values = np.zeros((count, width), dtype)
        else:
            values = self._packed(accessor, dtype, width, count, what)
        if "sparse" in accessor:
            values = self._sparse(accessor["sparse"], values, what)
        if accessor.get("normalized") and dtype.kind in "iu":
            return np.maximum(values / float(np.iinfo(dtype).max), -1.0)
        return values

    def _packed(
        self, owner: dict[str, Any], dtype: np.dtype[Any], width: int, count: int, what: str
    ) -> NDArray[Any]:
        data, stride = self.view(owner.get("bufferView"))
        size = dtype.itemsize * width
        offset, stride = self.whole(owner, "byteOffset", 0, what), stride or size
        if stride < size:
            raise self.fail(f"{what} steps by {stride} bytes over elements of {size}")
        needed = offset + stride * (count - 1) + size if count else 0
        if needed > len(data):
            raise self.fail(
                f"{what} claims {count} elements, {needed} bytes, but its buffer view has {len(data)}"
            )
        if count == 0:
            return np.zeros((0, width), dtype)
        return np.ndarray((count, width), dtype, data, offset, (stride, dtype.itemsize))

    def _sparse(self, sparse: Any, values: NDArray[Any], what: str) -> NDArray[Any]:
        if not (
            isinstance(sparse, dict) and all(isinstance(sparse.get(k), dict) for k in ("indices", "values"))
        ):
            raise self.fail(f"{what} has a sparse part without indices or values")
        count = self.whole(sparse, "count", None, f"{what}.sparse")
        component = sparse["indices"].get("componentType")
        if not isinstance(component, int) or component not in (5121, 5123, 5125):
            raise self.fail(f"{what}.sparse has indices of an unknown type")
        index = self._packed(
            sparse["indices"], np.dtype(_COMPONENTS[component]), 1, count, f"{what}.sparse.indices"
        )[:, 0]
        put = self._packed(sparse["values"], values.dtype, values.shape[1], count, f"{what}.sparse.values")
        if count and int(index.max()) >= len(values):
            raise self.fail(f"{what}.sparse writes element {int(index.max())} of {len(values)}")
        values = np.array(values)
        values[index] = put
        return values
