"""Kinds of point features: what is drawn for each, and what it changes where."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.fields.splines import SIGMOID_REACH, Profile, profile_table
from surftex.materials.skin.model import Skin
from surftex.randomness import Stream

STATE = (
    "pheomelanin", "blood", "melanin", "oxygenation", "stratum_corneum_mm", "epidermis_mm", "height_mm", "hair", "sebum",
    "relief",
)  # fmt: skip
"""What is known of a point: biology first, height, how far hair covers it, its oil, and how much of the furrows is left."""

Columns = dict[str, NDArray[np.float64]]
Rule = str
"""``add``, ``lessen`` (takes a share off) or ``cover`` (fills up to 1)."""


@dataclass(frozen=True)
class Change:
    """What a kind does to one entry of the state.

    Attributes
    ----------
    channel : str
        One of `STATE`.
    rule : str
        ``add``, ``lessen`` or ``cover``.
    amount : str or float
        A column of the features, or a number for all.
    table : (p,) float32
        Profile from the middle to the radius.
    """

    channel: str
    rule: Rule
    amount: str | float
    table: NDArray[np.float32]


@dataclass(frozen=True)
class Kind:
    """One kind of point features.

    Attributes
    ----------
    columns : callable
        ``columns(skin, stream, count)`` draws the parameters of features; `radius_mm` is among them.
    changes : callable
        ``changes(skin)`` tells what they do.
    lean : callable
        Length over width.
    irregularity : callable
        Of the outline, 0 to 1.
    """

    columns: Callable[[Skin, Stream, int], Columns]
    changes: Callable[[Skin], list[Change]]
    lean: Callable[[Skin], float] = lambda skin: 1.0
    irregularity: Callable[[Skin], float] = lambda skin: 0.0


def normal(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn uniform numbers into normal ones.

    Parameters
    ----------
    numbers : (n,) float64
        In [0, 1).

    Returns
    -------
    normal : (n,) float64
        With mean 0 and standard deviation 1.
    """
    from scipy.special import ndtri

    return ndtri(np.clip(numbers, 1e-12, 1 - 1e-12))


def _radius(
    given: tuple[float, float], numbers: NDArray[np.float64], profile: Profile = "dome"
) -> NDArray[np.float64]:
    reach = SIGMOID_REACH if profile == "sigmoid" else 1.0
    return np.maximum(np.abs(given[0] + given[1] * normal(numbers)) * reach, 1e-3)


def _between(given: tuple[float, float], numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    return given[0] + (given[1] - given[0]) * numbers


def _cyst(skin: Skin, stream: Stream, count: int) -> Columns:
    u = stream.uniform(count, 2)
    return {
        "radius_mm": _radius(skin.cyst_radius, u[:, 0], skin.cyst_profile),
        "height_mm": _between(skin.cyst_height, u[:, 1]),
    }


def _mole(skin: Skin, stream: Stream, count: int) -> Columns:
    u = stream.uniform(count, 3)
    melanin = _between(skin.mole_melanin, u[:, 1])
    return {
        "radius_mm": _radius(skin.mole_radius, u[:, 0], skin.mole_profile),
        "melanin": melanin,
        "height_mm": _between(skin.mole_height, u[:, 2]) * melanin,
    }


def _freckle(skin: Skin, stream: Stream, count: int) -> Columns:
    u = stream.uniform(count, 3)
    melanin = _between(skin.freckle_melanin, u[:, 1])
    return {
        "radius_mm": _radius(skin.freckle_radius, u[:, 0], skin.freckle_profile),
        "melanin": melanin,
        "pheomelanin": skin.freckle_pheomelanin * (melanin + u[:, 2]),
    }


def _follicle(skin: Skin, stream: Stream, count: int) -> Columns:
    return {"radius_mm": np.full(count, max(skin.follicle_radius, skin.follicle_shaft, 1e-3))}


def _pit(which: str) -> Callable[[Skin, Stream, int], Columns]:
    def columns(skin: Skin, stream: Stream, count: int) -> Columns:
        u = stream.uniform(count, 2)
        profile = getattr(skin, f"{which}_profile")
        return {
            "radius_mm": _radius(getattr(skin, f"{which}_radius"), u[:, 0], profile),
            "height_mm": -_between(getattr(skin, f"{which}_depth"), u[:, 1]),
        }

    return columns


def _goose(skin: Skin, stream: Stream, count: int) -> Columns:
    u = stream.uniform(count, 2)
    return {
        "radius_mm": _radius(skin.goose_radius, u[:, 0], skin.goose_profile),
        "height_mm": _between(skin.goose_height, u[:, 1]),
    }


def _hair_changes(skin: Skin) -> list[Change]:
    """Cover the shaft's disc; below the skin it shows ever less: 1 - 2 (sig(5 x) - 1/2) between both radii."""
    x = np.linspace(0, 1, len(profile_table("disc")))
    inner = min(skin.follicle_shaft / max(skin.follicle_radius, 1e-9), 1.0)
    share = np.clip((x - inner) / max(1 - inner, 1e-9), 0, 1)
    seen = 2 - 2 / (1 + np.exp(-5 * share))
    shaft = np.clip((inner - x) * len(x) / 8 + 1, 0, 1)
    return [
        Change("blood", "lessen", skin.follicle_blood, profile_table("dome")),
        Change("hair", "cover", skin.follicle_cover, ((seen - seen[-1]) / (1 - seen[-1])).astype(np.float32)),
        Change("height_mm", "add", skin.follicle_height, shaft.astype(np.float32)),
    ]


def _scar_changes(skin: Skin) -> list[Change]:
    shape, flat = profile_table(skin.scar_profile), profile_table("plateau")
    return [
        Change("height_mm", "add", "height_mm", shape),
        Change("melanin", "lessen", skin.scar_pallor, flat),
        Change("blood", "lessen", skin.scar_pallor, flat),
        Change("relief", "lessen", 1.0, flat),
    ]


def _pore_changes(skin: Skin) -> list[Change]:
    shape = profile_table(skin.pore_profile)
    return [
        Change("height_mm", "add", "height_mm", shape),
        Change("melanin", "add", skin.pore_shade, shape),
        Change("sebum", "cover", skin.pore_sebum, profile_table("dome")),
    ]


def _one(channel: str, profile: str) -> Callable[[Skin], list[Change]]:
    return lambda skin: [Change(channel, "add", channel, profile_table(getattr(skin, profile)))]


def _two(first: str, second: str, profile: str) -> Callable[[Skin], list[Change]]:
    def changes(skin: Skin) -> list[Change]:
        table = profile_table(getattr(skin, profile))
        return [Change(name, "add", name, table) for name in (first, second)]

    return changes


KINDS: dict[str, Kind] = {
    "scar": Kind(_pit("scar"), _scar_changes, lambda s: s.scar_lean, lambda s: s.scar_irregularity),
    "cyst": Kind(_cyst, _one("height_mm", "cyst_profile")),
    "goose": Kind(_goose, _one("height_mm", "goose_profile")),
    "pock": Kind(_pit("pock"), _one("height_mm", "pock_profile"), irregularity=lambda s: s.pock_irregularity),
    "mole": Kind(
        _mole, _two("melanin", "height_mm", "mole_profile"), irregularity=lambda s: s.mole_irregularity
    ),
    "freckle": Kind(
        _freckle,
        _two("melanin", "pheomelanin", "freckle_profile"),
        irregularity=lambda s: s.freckle_irregularity,
    ),
    "pore": Kind(_pit("pore"), _pore_changes, lambda s: s.pore_lean),
    "follicle": Kind(_follicle, _hair_changes, lambda s: s.follicle_lean),
}
"""Every kind of point features; `Skin.order` says which come first."""


def setting(skin: Skin, kind: str, key: str) -> Any:
    """Look up a parameter of a kind.

    Parameters
    ----------
    skin : Skin
        The parameters.
    kind : str
        One of `KINDS`.
    key : str
        Such as ``count``.

    Returns
    -------
    value : object
        Of ``<kind>_<key>``.
    """
    return getattr(skin, f"{kind}_{key}")
