"""glTF 2.0, as GLB or as .gltf with buffers beside it: what the scene shows, in metres.

Only the file itself and buffers within its folder are read; pictures are never opened, and nothing goes to
the network. Extensions that a file requires are refused by name unless they leave the geometry alone.
"""

import base64
import binascii
import json
import urllib.parse
from pathlib import Path

from surftex.errors import MeshFileError
from surftex.files.gltfaccessor import Document
from surftex.files.gltfscene import unfolded
from surftex.files.polygons import Polygons
from surftex.files.reading import printable, read_bytes

_HARMLESS = (
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture",
    "KHR_lights_",
    "KHR_xmp",
    "KHR_animation_",
)


def read_gltf(data: bytes, where: str, folder: Path) -> Polygons:
    """Read a glTF file.

    Parameters
    ----------
    data : bytes
        The file, text or GLB.
    where : str
        Its name for messages.
    folder : Path
        Where its buffers may lie.

    Returns
    -------
    polygons : Polygons
        Triangles of the scene.

    Raises
    ------
    MeshFileError
        If the file is broken, or needs what surftex does not read.
    """
    text, chunk = _parted(data, where) if data[:4] == b"glTF" else (data, None)
    if data[:4] != b"glTF" and where.lower().endswith(".glb"):
        raise MeshFileError(f"{where}: is no GLB file (it does not begin with 'glTF')")
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as problem:
        raise MeshFileError(
            f"{where}: its JSON does not parse ({printable(str(problem), longest=80)})"
        ) from None
    if not isinstance(document, dict):
        raise MeshFileError(f"{where}: its JSON is no glTF document")
    asset = document.get("asset")
    version = str(asset.get("version", "")) if isinstance(asset, dict) else ""
    if not version.startswith("2"):
        raise MeshFileError(
            f"{where}: is glTF {printable(version, longest=10) or 'without a version'}; surftex reads glTF 2"
        )
    required = document.get("extensionsRequired", [])
    for name in required if isinstance(required, list) else []:
        if name != "KHR_mesh_quantization" and not str(name).startswith(_HARMLESS):
            raise MeshFileError(
                f"{where}: needs the extension {printable(str(name), longest=60)}, which surftex "
                "does not read; export it without compression"
            )
    draft = Document(document, [], where)
    draft.buffers = [_buffer(draft, index, chunk, folder) for index in range(len(draft.listed("buffers")))]
    return unfolded(draft)


def buffer_files(data: bytes, where: str, folder: Path) -> list[Path]:
    """List the buffers that lie beside a .gltf.

    Parameters
    ----------
    data : bytes
        The file.
    where : str
        Its name for messages.
    folder : Path
        Where its buffers may lie.

    Returns
    -------
    paths : list of Path
        None that leaves the folder.

    Raises
    ------
    MeshFileError
        If the JSON does not parse, or a buffer lies elsewhere.
    """
    try:
        document = json.loads(data)
    except (ValueError, RecursionError):
        return []  # `read_gltf` says what is wrong
    if not isinstance(document, dict):
        return []
    draft = Document(document, [], where)
    buffers = [draft.item("buffers", index) for index in range(len(draft.listed("buffers")))]
    addresses = [(index, buffer.get("uri")) for index, buffer in enumerate(buffers)]
    return [
        _beside(draft, uri, f"buffers[{index}]", folder)
        for index, uri in addresses
        if isinstance(uri, str) and not uri.startswith("data:")
    ]


def _parted(data: bytes, where: str) -> tuple[bytes, bytes | None]:
    """JSON and binary chunk of a GLB."""
    if len(data) < 20:
        raise MeshFileError(f"{where}: is cut short: a GLB has at least 20 bytes, this file {len(data)}")
    version, length = (int.from_bytes(data[k : k + 4], "little") for k in (4, 8))
    if version != 2:
        raise MeshFileError(f"{where}: is GLB version {version}; surftex reads version 2")
    if length > len(data):
        raise MeshFileError(f"{where}: is cut short: it declares {length} bytes and has {len(data)}")
    at, chunks = 12, {}
    while at + 8 <= length:
        size, kind = int.from_bytes(data[at : at + 4], "little"), data[at + 4 : at + 8]
        if at + 8 + size > length:
            raise MeshFileError(
                f"{where}: its chunk {kind!r} at byte {at} claims {size} bytes, beyond the end"
            )
        chunks.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size
    if b"JSON" not in chunks:
        raise MeshFileError(f"{where}: has no JSON chunk")
    return chunks[b"JSON"], chunks.get(b"BIN\0")


def _buffer(document: Document, index: int, chunk: bytes | None, folder: Path) -> bytes:
    buffer, what = document.item("buffers", index), f"buffers[{index}]"
    length, uri = document.whole(buffer, "byteLength", None, what), buffer.get("uri")
    if uri is None:
        if index or chunk is None:
            extensions = buffer.get("extensions")
            if isinstance(extensions, dict) and any("meshopt" in str(name) for name in extensions):
                return b""
            raise document.fail(f"{what} has no data")
        found = chunk
    elif not isinstance(uri, str):
        raise document.fail(f"{what} has an address that is no text")
    elif uri.startswith("data:"):
        found = _embedded(document, uri, what)
    else:
        found = read_bytes(_beside(document, uri, what, folder), purpose="glTF buffer")
    if len(found) < length:
        raise document.fail(f"{what} declares {length} bytes and has {len(found)}")
    return found[:length]


def _embedded(document: Document, uri: str, what: str) -> bytes:
    """Decode a ``data:`` address (RFC 2397): base64 where it says so, else percent-encoded bytes."""
    head, comma, text = uri.partition(",")
    if not comma:
        raise document.fail(f"{what} has a data address without a comma")
    data = urllib.parse.unquote_to_bytes(text)
    if not head.lower().endswith(";base64"):
        return data
    try:
        return base64.b64decode(data, validate=False)
    except (binascii.Error, ValueError):
        raise document.fail(f"{what} has base64 data that does not decode") from None


def _beside(document: Document, uri: str, what: str, folder: Path) -> Path:
    """Turn a relative address into a path within the folder."""
    try:
        parsed = urllib.parse.urlsplit(uri)
    except ValueError:
        raise document.fail(f"{what} has an address that does not read") from None
    if parsed.scheme or parsed.netloc:
        place = "a file elsewhere" if parsed.scheme == "file" else "the network"
        raise document.fail(f"{what} lies on {place}; surftex reads only buffers in the file's own folder")
    name = urllib.parse.unquote(uri)
    try:
        path = (folder / name).resolve()
        inside = path.is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):
        inside, path = False, folder
    if not inside or not name or "\0" in name:
        raise document.fail(f"{what} leaves the file's folder; surftex reads only buffers within it")
    return path
