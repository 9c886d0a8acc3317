"""Pictures to files: PNG, whole or not at all."""

import os
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError, WorkError


def check_picture(path: str | os.PathLike[str]) -> Path:
    """Check before any work what a picture is to be called, and that there is room for it.

    Parameters
    ----------
    path : path
        Of the file.

    Returns
    -------
    path : Path
        The same.

    Raises
    ------
    InputError
        If the name does not end in .png, or is that of a folder.
    WorkError
        If nothing can be written there.
    """
    from surftex.files.output import check_room

    target = Path(path)
    if target.suffix.lower() != ".png":
        raise InputError(f"{target}: pictures are PNG; let the name end in .png")
    if target.is_dir():
        raise InputError(f"{target} is a folder; name a file for the picture")
    check_room(target.parent)
    return target


def save_picture(path: str | os.PathLike[str], picture: NDArray[np.uint8]) -> Path:
    """Write a picture.

    Parameters
    ----------
    path : path
        Of the file; one that is there is replaced, whole. Its folder is made where there is none.
    picture : (height, width, 3) uint8
        sRGB codes.

    Returns
    -------
    path : Path
        Of the picture.

    Raises
    ------
    InputError
        As `check_picture`.
    WorkError
        If it cannot be written.
    """
    from surftex.files.images import png_bytes

    target = check_picture(path)
    data = png_bytes(picture)
    draft = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        draft.write_bytes(data)
        draft.replace(target)
    except OSError as problem:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
        raise WorkError(f"{target}: cannot write: {problem.strerror or problem}") from None
    return target
