"""Pictures to files: PNG, whole or not at all."""

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError


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
        If the name does not end in .png, or is that of a folder, or nothing can be written there.
    WorkError
        If the disk is full.
    """
    from surftex.files.output import check_room

    target = Path(path)
    if target.suffix.lower() != ".png":
        raise InputError(f"{target}: pictures are PNG; let the name end in .png")
    check_room(target.parent)
    if target.is_dir():
        raise InputError(f"{target} is a folder; name a file for the picture")
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
    from surftex.files.output import write_whole

    target = check_picture(path)
    write_whole(target, png_bytes(picture), parents=True)
    return target
