"""Parts of a mesh by name: material slots, groups, nodes."""

import difflib

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError
from surftex.files.polygons import Polygons
from surftex.files.reading import printable
from surftex.words import sort_of


def chosen_faces(polygons: Polygons, part: str, where: str) -> NDArray[np.bool_]:
    """Find the polygons of a part.

    Case does not matter. Whole names go first, then names that begin with `part`, then names that hold it, as
    long as only one does; materials go before groups, and groups before nodes.

    Parameters
    ----------
    polygons : Polygons
        Of a file.
    part : str
        What to look for.
    where : str
        File name for messages.

    Returns
    -------
    chosen : (p,) bool
        The part's polygons.

    Raises
    ------
    MeshFileError
        Listing the names that there are, the nearest first.
    """
    if not isinstance(part, str):
        raise MeshFileError(f"{where}: part is {sort_of(part)}; it takes a name")
    wanted = part.strip().casefold()
    tests = (lambda name: name == wanted, lambda name: name.startswith(wanted), lambda name: wanted in name)
    for number, test in enumerate(tests if wanted else ()):
        several: list[str] = []
        for index, names in polygons.labels.values():
            match = [k for k, name in enumerate(names) if test(name.casefold())]
            if match and (number == 0 or len(match) == 1):
                return np.isin(index, match)
            several = several or [names[k] for k in match]
        if several:
            raise MeshFileError(
                f"{where}: {printable(part, longest=60)!r} fits several parts: "
                f"{', '.join(several[:6])}; write one in full"
            )
    known = list(dict.fromkeys(name for _, names in polygons.labels.values() for name in names))
    if not known:
        raise MeshFileError(
            f"{where}: has no named parts, so there is no {printable(part, longest=60)!r}; leave the part out"
        )
    folded = {name.casefold(): name for name in known}
    near = [folded[name] for name in difflib.get_close_matches(wanted, folded, n=1, cutoff=0.4)]
    shown = ", ".join(known[:12]) + (f" and {len(known) - 12} more" if len(known) > 12 else "")
    hint = f"; did you mean {near[0]!r}?" if near else "."
    raise MeshFileError(f"{where}: has no part {printable(part, longest=60)!r}{hint} It has {shown}")


def part_labels(polygons: Polygons) -> tuple[NDArray[np.int32], tuple[str, ...]]:
    """Choose which kind of label names the parts: the first kind that tells faces apart.

    Parameters
    ----------
    polygons : Polygons
        Of a file.

    Returns
    -------
    part : (p,) int32
        Index of each polygon's part.
    names : tuple of str
        Only those in use, in the order of the file.
    """
    best: tuple[NDArray[np.int32], tuple[str, ...]] | None = None
    for index, names in polygons.labels.values():
        used, compact = np.unique(index, return_inverse=True)
        if best is None or (len(best[1]) == 1 and len(used) > 1):
            best = compact.astype(np.int32).reshape(-1), tuple(names[k] for k in used)
        if len(best[1]) > 1:
            break
    return best if best is not None else (np.zeros(len(polygons.start) - 1, np.int32), ("surface",))
