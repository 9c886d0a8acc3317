"""Millimetres in a unit of a file: said by the user, by the format or a comment, or guessed from the size."""

import re
from math import log

from surftex.errors import MeshFileError, RecipeError
from surftex.units import MM_PER_UNIT, length_mm
from surftex.words import sort_of

SMALLEST_MM, LARGEST_MM = 20.0, 5000.0
"""A guess must put the longest side between these."""

LIKELY_MM = 300.0
"""Where several units do, the one that comes nearest to this by ratio is taken."""

NEAR_TIE = 2.0
"""Up to how many times as far from `LIKELY_MM`, by ratio, a second unit is named beside the one that is taken."""

_OVERRULE = "(units or size overrules this; --units, --size)"

_WORDS = {"mm": rb"millimet(er|re)s", "cm": rb"centimet(er|re)s", "m": rb"met(er|re)s", "in": rb"inches"}


OWN_COMMENT = "surftex, millimetres"
"""What surftex writes at the head of an OBJ, PLY or STL file of its own."""


def is_own(data: bytes) -> bool:
    """Tell whether surftex has written a mesh file, in millimetres.

    Parameters
    ----------
    data : bytes
        Of an OBJ, PLY, OFF or STL file.

    Returns
    -------
    own : bool
        Whether a comment at its head, or the header of a binary STL, is `OWN_COMMENT`.
    """
    own, said = OWN_COMMENT.encode(), {line.strip() for line in data[:2048].splitlines()}
    return data[:80].rstrip() == own or not said.isdisjoint((b"# " + own, b"comment " + own))


def named_unit(data: bytes) -> str | None:
    """Look for a unit in the comments at the head of an OBJ, PLY or OFF file, as Maya writes it.

    Parameters
    ----------
    data : bytes
        Of the file.

    Returns
    -------
    unit : str or None
        One of `MM_PER_UNIT`, if the comments name one in full and no other; numbers of it, such as 10 metres, are no name.
    """
    lines = [line for line in data[:2048].splitlines() if line.lstrip().startswith((b"#", b"comment "))]
    text = b"\n".join(lines)
    found = [unit for unit, words in _WORDS.items() if re.search(rb"(?<!\d )\b" + words + rb"\b", text, re.I)]
    return found[0] if len(found) == 1 else None


def mm_per_unit(
    longest_side: float,
    where: str,
    *,
    own: float | None,
    named: str | None,
    units: str | None,
    size: str | float | None,
) -> tuple[float, list[str]]:
    """Settle the scale of a file.

    Parameters
    ----------
    longest_side : float
        Of the bounding box, in the file's unit.
    where : str
        File name for messages.
    own : float or None
        Millimetres in a unit, where the format fixes it.
    named : str or None
        What comments say a unit is; taken where that is plausible.
    units : str or None
        What the user says a unit is: "mm", "cm", "m", "in".
    size : str, float or None
        Length that the longest side shall have; a bare number is millimetres.

    Returns
    -------
    mm_per_unit : float
        The scale.
    warnings : list of str
        A guess, and how to overrule it.

    Raises
    ------
    MeshFileError
        If no guess is plausible.
    RecipeError
        If `units` or `size` does not read.
    """
    if units is not None and not (isinstance(units, str) and units in MM_PER_UNIT):
        shown = repr(units) if isinstance(units, str) else sort_of(units)
        raise RecipeError(f"unknown unit {shown}; known are {', '.join(MM_PER_UNIT)}")
    if size is not None:
        length = length_mm(size)
        if not 1e-3 <= length <= 1e7:
            raise RecipeError(
                f"size {size!r} is not between 0.001 mm and 10 km; give the length of the longest side, "
                "such as '300 mm'"
            )
        return length / longest_side, []
    if units is not None:
        return MM_PER_UNIT[units], []
    if own is not None:
        return own, []
    if named is not None and SMALLEST_MM <= longest_side * MM_PER_UNIT[named] <= LARGEST_MM:
        length = longest_side * MM_PER_UNIT[named]
        said = (
            f"a comment of the file names the unit {named}; its longest side is {length:.4g} mm {_OVERRULE}"
        )
        return MM_PER_UNIT[named], [said]
    lengths = {name: longest_side * MM_PER_UNIT[name] for name in ("m", "cm", "mm")}
    plausible = [name for name, length in lengths.items() if SMALLEST_MM <= length <= LARGEST_MM]
    if plausible:
        far = {name: round(abs(log(lengths[name] / LIKELY_MM)), 9) for name in plausible}
        unit, *others = sorted(plausible, key=far.__getitem__)
        said = f"the file names no unit; taken as {unit}, its longest side is {lengths[unit]:.4g} mm"
        if others and far[others[0]] <= far[unit] + log(NEAR_TIE):
            other = others[0]
            said += f"; it may as well be {other} ({lengths[other]:.4g} mm): --units {other} or --units {unit} settles it"
        return MM_PER_UNIT[unit], [f"{said} {_OVERRULE}"]
    raise MeshFileError(
        f"{where}: names no unit, and as metres, centimetres or millimetres its longest side "
        f"of {longest_side:.4g} is not between 20 mm and 5 m; give units or size (--units, --size)"
    )
