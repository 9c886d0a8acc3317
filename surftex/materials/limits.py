"""How many features a material lays, told before any is: what `--max-features` bounds and `inspect` prints."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from surftex.errors import RecipeError
from surftex.words import plain

_ROOM = 0.5
"""Share of what is allowed that what is not changed may take; beyond it further parameters are to be changed too."""

_SURE = 0.98
"""Kept of what is allowed by the values that are advised, as sizes vary over a surface."""

_UNIT = "scale a mesh whose unit is wrong (units, size; --units, --size)"


@dataclass(frozen=True)
class Expected:
    """Features of one kind that are to be expected.

    Attributes
    ----------
    kind : str
        As in ``features.npz``.
    count : float
        How many, within a few percent; where a mask thins them, what it cannot exceed.
    key : str
        The parameter that decides it.
    value : float or str
        What that is.
    power : int
        Of the parameter that the count grows by: 1 for numbers and densities, -2 for lengths.
    most : float
        Of this kind, whatever is allowed of all.
    effort : float
        Of laying one, against one that is round: cells twice as long as wide lie in the reach of four times as many.
    """

    kind: str
    count: float
    key: str
    value: float | str
    power: int = 1
    most: float = math.inf
    effort: float = 1.0


def refuse_more(material: str, expected: Iterable[Expected], area_mm2: float, most: int) -> None:
    """Refuse work beyond a number of features.

    Parameters
    ----------
    material : str
        Its name, for the message.
    expected : iterable of Expected
        All that it would lay.
    area_mm2 : float
        Where.
    most : int
        Allowed, of all kinds together.

    Raises
    ------
    RecipeError
        If more are to be expected; the message says how many of what, and what to change.
    """
    found = [each for each in expected if each.count >= 0.5]
    for each in found:
        if each.count > each.most:
            raise RecipeError(
                f"{material}.{each.key}: {plain(area_mm2)} mm^2 would hold about {each.count:,.0f} {each.kind}s, more than the "
                f"{each.most:,} that there is room for; {_mended([each], each.most / each.count)}, or {_UNIT}"
            )
    total = sum(each.count for each in found)
    if total <= most:
        return
    by_key: dict[str, list[Expected]] = {}
    for each in found:
        by_key.setdefault(each.key, []).append(each)
    keys = sorted(by_key, key=lambda key: -_sum(by_key[key]))
    changed, rest = [keys[0]], total - _sum(by_key[keys[0]])
    while rest >= most * _ROOM and len(changed) < len(keys):
        changed.append(keys[len(changed)])
        rest = _sum(each for key in keys[len(changed) :] for each in by_key[key])
    mended = _mended([by_key[key][0] for key in changed], (most - rest) / (total - rest))
    largest = max(by_key[keys[0]], key=lambda each: each.count)
    what = f"{total:,.0f} {largest.kind}s"
    if len(found) > 1:
        listed = ", ".join(f"{each.count:,.0f} {each.kind}s" for each in found)
        what = f"{total:,.0f} features, most of them {largest.kind}s ({listed})"
    raise RecipeError(
        f"{material}.{keys[0]}: {plain(area_mm2)} mm^2 would hold about {what}, more than the {most:,} allowed; {mended}, "
        f"{_UNIT}, or raise max_features (--max-features)"
    )


def _sum(expected: Iterable[Expected]) -> float:
    return sum(each.count for each in expected)


def _mended(expected: Iterable[Expected], share: float) -> str:
    """Say which values would leave a share of the counts; of expressions only whether to raise or to lower them."""
    changes = []
    for each in expected:
        change = f"{'raise' if each.power < 0 else 'lower'} {each.key}"
        if not isinstance(each.value, str) and 0 < share < 1:
            value = each.value * (_SURE * share) ** (1 / each.power)
            step = 10.0 ** (math.floor(math.log10(value)) - 2)
            value = step * (math.ceil(value / step) if each.power < 0 else math.floor(value / step))
            change += f" to {value:.10g}{' mm' if each.power < 0 else ''}"
        changes.append(change)
    return " and ".join(changes)
