"""Parts of a mesh by name: material slots, groups, nodes, whichever kinds of names its faces have."""

import difflib
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError

Labels = Mapping[str, tuple[NDArray[np.int32], tuple[str, ...]]]
"""For "material", "group", "node" and the like: an index for each face, and the names that it points to."""


def chosen_faces(labels: Labels, part: str, subject: str, *, error: type[InputError]) -> NDArray[np.bool_]:
    """Find the faces of a part.

    Whole names go first, then names that begin with `part`, then names that hold it, as long as only one does;
    materials go before groups, and groups before nodes. Case matters only between names that differ in nothing else.

    Parameters
    ----------
    labels : mapping of str to ((m,) int32, tuple of str)
        Names by kind; at least one kind.
    part : str
        What to look for.
    subject : str
        What has the parts, for messages.
    error : type
        What to raise.

    Returns
    -------
    chosen : (m,) bool
        The part's faces.

    Raises
    ------
    InputError
        Listing the names that there are, the nearest first.
    """
    wanted = part.strip().casefold()
    tests = (lambda name: name == wanted, lambda name: name.startswith(wanted), lambda name: wanted in name)
    for number, test in enumerate(tests if wanted else ()):
        several: list[str] = []
        for index, names in labels.values():
            match = [k for k, name in enumerate(names) if test(name.casefold())]
            if number == 0:
                match = [k for k in match if names[k] == part.strip()] or match
            if match and (number == 0 or len(match) == 1):
                return np.isin(index, match)
            several = several or [names[k] for k in match]
        if several:
            raise error(
                f"{subject} has several parts that {_shown(part)} fits: {_listed(several, 6)}; write one in full"
            )
    known = list(dict.fromkeys(name for _, names in labels.values() for name in names))
    folded = {name.casefold(): name for name in known}
    near = [folded[name] for name in difflib.get_close_matches(wanted, folded, n=1, cutoff=0.4)]
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise error(f"{subject} has no part {_shown(part)}; it has {_listed(known, 12)}{hint}")


def in_use(index: NDArray[np.int32], names: tuple[str, ...]) -> tuple[NDArray[np.int32], tuple[str, ...]]:
    """Leave out the names that no face has.

    Parameters
    ----------
    index : (m,) int32
        Of each face's name.
    names : tuple of str
        In the order of the file.

    Returns
    -------
    index : (m,) int32
        Into the names that are left.
    names : tuple of str
        In the same order.
    """
    used, compact = np.unique(index, return_inverse=True)
    return compact.astype(np.int32).reshape(-1), tuple(names[k] for k in used)


def naming_kind(labels: Labels) -> str:
    """Choose which kind of label names the parts: the first kind that tells faces apart, or else the first.

    Parameters
    ----------
    labels : mapping of str to ((m,) int32, tuple of str)
        Names by kind; at least one kind.

    Returns
    -------
    kind : str
        One of the keys.
    """
    apart = (kind for kind, (index, _) in labels.items() if (index != index[:1]).any())
    return next(apart, next(iter(labels)))


def _shown(part: str) -> str:
    return repr(part if len(part) <= 60 else f"{part[:29]}...{part[-28:]}")


def _listed(names: list[str], most: int) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(map(repr, names[:most])) + more
