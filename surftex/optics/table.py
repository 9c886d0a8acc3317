"""The look of skin by its biology: render parameters at nodes, read through a dense grid.

Nodes are few and a polynomial through them is accurate; a grid that the polynomial fills is fast. Both are one
table: it keeps the nodes, with the settings that made them, and spreads them out when first asked.
"""

import io
import json
import zipfile
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import frozen
from surftex.errors import InputError
from surftex.optics.nodes import nodes, polynomial, straightened
from surftex.optics.subsurface import mean_free_path
from surftex.optics.tissue import PARAMETERS

COLUMNS = ("red", "green", "blue", "reflectance", "roughness", "wide_red", "wide_green", "wide_blue")
"""At a node: diffuse colour, reflectance at normal incidence, roughness, width of Burley's profile in mm."""

MOST_REFLECTANCE = 0.08
"""At normal incidence, where the specular level of principled shaders is 1."""

_LOGARITHMIC = np.array([True, True, True, False, False, True, True, True])
_LEAST = 1e-4
_MOST_BYTES = 2**28
_DENSE = {
    "pheomelanin": 5,
    "melanin": 15,
    "epidermis_cm": 5,
    "stratum_corneum_cm": 2,
    "blood": 9,
    "oxygenation": 3,
}


@dataclass(frozen=True, eq=False)
class SkinTable:
    """Render parameters of skin over the ranges of `PARAMETERS`.

    Attributes
    ----------
    values : (p, m, e, s, b, o, 8) float64
        `COLUMNS` at the nodes.
    settings : dict
        What made it; its ``nodes`` and ``crowded`` say where the nodes are.
    """

    values: NDArray[np.float64]
    settings: dict[str, Any]

    @cached_property
    def axes(self) -> dict[str, NDArray[np.float64]]:
        """Nodes of each parameter."""
        counts, crowded = self.settings["nodes"], self.settings["crowded"]
        return {name: nodes(name, counts[name], crowded=crowded) for name in PARAMETERS}

    def at(self, axes: dict[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        """Read the table through its polynomials, on a grid.

        Parameters
        ----------
        axes : dict of str to (n,) float64
            Values of each parameter, within its range.

        Returns
        -------
        values : (n0, ..., n5, 8) float64
            `COLUMNS`.
        """
        spread = np.where(_LOGARITHMIC, np.log(np.maximum(self.values, _LEAST)), self.values)
        for i, (name, known) in enumerate(self.axes.items()):
            weights = polynomial(straightened(name, known), straightened(name, axes[name]))
            spread = np.moveaxis(np.tensordot(weights, spread, axes=(1, i)), 0, i)
        return np.where(_LOGARITHMIC, np.exp(np.where(_LOGARITHMIC, spread, 0.0)), spread)

    @cached_property
    def grid(self) -> NDArray[np.float32]:
        """What a look-up reads, (n0, ..., n5, 8): colour, roughness, specular, mean free paths.

        Colour and paths, in mm, are logarithms: these are nearly linear, and so few steps do.
        """
        counts = {name: 1 if len(known) == 1 else _DENSE[name] for name, known in self.axes.items()}
        values = self.at({name: nodes(name, count, crowded=False) for name, count in counts.items()})
        color = np.clip(values[..., :3], _LEAST, 1)
        paths = np.maximum(mean_free_path(values[..., 5:], color), _LEAST)
        rough, specular = np.clip(values[..., 4:5], 0, 1), np.clip(values[..., 3:4] / MOST_REFLECTANCE, 0, 1)
        return frozen(
            np.concatenate([np.log(color), rough, specular, np.log(paths)], axis=-1).astype(np.float32)
        )

    @cached_property
    def bounds(self) -> NDArray[np.float32]:
        """First node, last node, and whether even, of each parameter: (6, 3)."""
        rows = [(known[0], known[-1], float(PARAMETERS[name].even)) for name, known in self.axes.items()]
        return frozen(np.array(rows, np.float32))

    def outside(self, name: str, value: ArrayLike) -> NDArray[np.bool_]:
        """Tell which values of a parameter the table does not cover; a look-up moves them to its nearest node.

        Parameters
        ----------
        name : str
            One of `PARAMETERS`.
        value : (...) float
            In the parameter's unit.

        Returns
        -------
        outside : (...) bool
            Whether it leaves the table's range by more than the rounding of float32.
        """
        value, known = np.asarray(value), self.axes[name]
        return (value < known[0] * (1 - 1e-6)) | (value > known[-1] * (1 + 1e-6))

    def to_bytes(self) -> bytes:
        """Write the table.

        Returns
        -------
        data : bytes
            An ``.npz`` archive: values as float32, settings as JSON.
        """
        target = io.BytesIO()
        settings = np.frombuffer(json.dumps(self.settings).encode(), np.uint8)
        np.savez_compressed(target, values=self.values.astype(np.float32), settings=settings)
        return target.getvalue()

    @staticmethod
    def from_bytes(data: bytes, name: str = "table") -> "SkinTable":
        """Read a table.

        Parameters
        ----------
        data : bytes
            From `to_bytes`.
        name : str
            What a message calls it.

        Returns
        -------
        table : SkinTable
            Checked against its own settings.

        Raises
        ------
        InputError
            If it is something else, or damaged.
        """
        try:
            with zipfile.ZipFile(io.BytesIO(data)) as archive:
                if sum(entry.file_size for entry in archive.infolist()) > _MOST_BYTES:
                    raise ValueError("it unfolds to too much")
            with np.load(io.BytesIO(data), allow_pickle=False) as archive:
                values = archive["values"].astype(np.float64)
                settings = json.loads(archive["settings"].tobytes())
            shape = tuple(int(settings["nodes"][each]) for each in PARAMETERS)
            known = isinstance(settings["crowded"], bool)
        except Exception as problem:  # noqa: BLE001  (whatever a damaged archive raises)
            raise InputError(
                f"{name} is no table of skin ({type(problem).__name__}); make one with: surftex match"
            ) from None
        wanted = (*shape, len(COLUMNS))
        if not known or values.shape != wanted or min(wanted) < 1:
            raise InputError(
                f"{name} is damaged: it holds {values.shape} numbers, and its settings say {wanted}"
            )
        wrong = int(values.size - np.isfinite(values).sum())
        if wrong:
            raise InputError(f"{name} is damaged: {wrong} of its {values.size} numbers are not finite")
        return SkinTable(values, settings)


@cache
def shipped_table() -> SkinTable:
    """Open the table of the package.

    Returns
    -------
    table : SkinTable
        Read once.
    """
    return SkinTable.from_bytes(files("surftex.optics").joinpath("data", "skin.npz").read_bytes(), "skin.npz")
