"""The head of a PLY file: its elements and their properties."""

from dataclasses import dataclass, field

from surftex.errors import MeshFileError
from surftex.files.reading import printable

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
"""numpy's name for each of PLY's types."""

FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
"""Byte order of each format; none for text."""


@dataclass
class Element:
    """One kind of record.

    Attributes
    ----------
    name : str
        Such as "vertex".
    count : int
        Records, as the head claims.
    properties : list of (name, type, count type or None)
        In order; a list has a type for its count.
    """

    name: str
    count: int
    properties: list[tuple[str, str, str | None]] = field(default_factory=list)


def read_header(data: bytes, where: str) -> tuple[str, list[Element], int]:
    """Read the head.

    Parameters
    ----------
    data : bytes
        The file.
    where : str
        Its name for messages.

    Returns
    -------
    order : str
        Byte order, empty for text.
    elements : list of Element
        In the order of the file.
    offset : int
        Where the body begins.

    Raises
    ------
    MeshFileError
        Naming the line that is wrong.
    """
    if data[:3] != b"ply":
        raise MeshFileError(f"{where}: is no PLY file (it does not begin with 'ply')")
    end = data.find(b"end_header", 0, 2**20)
    if end < 0:
        raise MeshFileError(f"{where}: has no 'end_header' line")
    offset = end + len(b"end_header")
    while offset < len(data) and data[offset : offset + 1] in (b" ", b"\t"):
        offset += 1
    offset += 2 if data[offset : offset + 2] == b"\r\n" else 1
    order, elements = None, []
    for number, line in enumerate(data[:end].decode("latin-1").splitlines(), start=1):
        words = line.split()
        if number == 1 or not words or words[0] in ("comment", "obj_info"):
            continue
        wrong = MeshFileError(
            f"{where}: line {number} of the header is not understood: {printable(line, longest=60)!r}"
        )
        if words[0] == "format" and len(words) >= 2:
            if words[1] not in FORMATS:
                raise wrong
            order = FORMATS[words[1]]
        elif (
            words[0] == "element"
            and len(words) == 3
            and words[2].isdigit()
            and words[2].isascii()
            and len(words[2]) < 19
        ):
            elements.append(Element(words[1], int(words[2])))
        elif words[0] == "property" and elements and len(words) == 3 and words[1] in TYPES:
            elements[-1].properties.append((words[2], TYPES[words[1]], None))
        elif (
            words[0] == "property" and elements and len(words) == 5 and words[1] == "list"
            and words[2] in TYPES and words[3] in TYPES and TYPES[words[2]][0] != "f"
        ):  # fmt: skip
            elements[-1].properties.append((words[4], TYPES[words[3]], TYPES[words[2]]))
        else:
            raise wrong
    if order is None:
        raise MeshFileError(
            f"{where}: its header names no format (ascii, binary_little_endian or binary_big_endian)"
        )
    for element in elements:
        names = [name for name, _, _ in element.properties]
        if len(set(names)) < len(names):
            raise MeshFileError(
                f"{where}: its header repeats a property of {printable(element.name, longest=40)!r}"
            )
    return order, elements, offset
