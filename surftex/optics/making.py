"""Filling a table: walk, absorb, sample the BRDF, match a render model; in pieces that can be kept and gone on from."""

import hashlib
import json
from collections.abc import Iterator, MutableMapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import checked_number, checked_whole
from surftex.errors import InputError
from surftex.kernels.pool import Tick
from surftex.optics.brdf import Absorbers, Bins, sorted_into, surface_lobe
from surftex.optics.matching import match
from surftex.optics.nodes import nodes
from surftex.optics.paths import MOST_PATHS, Paths, check_engine, crossing_paths, volume_paths
from surftex.optics.shaders import shader_named
from surftex.optics.spectra import rgb_weights
from surftex.optics.subsurface import EDGES_MM, fit_width, rings
from surftex.optics.table import COLUMNS, MOST_REFLECTANCE, SkinTable
from surftex.optics.tissue import (
    PARAMETERS,
    Tissue,
    check_names,
    corneum_absorption,
    dermis_absorption,
    epidermis_absorption,
)

NODES = {
    "pheomelanin": 3,
    "melanin": 8,
    "epidermis_cm": 4,
    "stratum_corneum_cm": 2,
    "blood": 6,
    "oxygenation": 3,
}
"""Nodes of the shipped table."""


@dataclass(frozen=True)
class Making:
    """How to fill a table.

    Attributes
    ----------
    shader : str
        Render model to match.
    engine : str
        ``"volume"``, or ``"biospec"`` as in the thesis.
    seed : int
        Of everything random.
    paths : int
        Photons for colour and BRDF, for each wavelength; and for each thickness of the upper layers in ``volume``.
    beam_paths : int
        Photons of the thin beam that tells how far light wanders; always by ``volume``. 0 leaves it out.
    nodes : dict of str to int
        How many of each parameter.
    crowded : bool
        Chebyshev's nodes; else even steps.
    first_nm, last_nm, step_nm : float
        Wavelengths.
    fit_reflectance : bool
        Whether the reflectance at normal incidence is matched too, as in the thesis. It then makes up for what a
        diffuse lobe cannot do, and without a bound a wide lobe would stand for the diffuse light itself (0.9 with
        Ashikhmin and Shirley's); so it ends where principled shaders end, at 0.08. Usually it is that of the
        tissue's index, and colour and roughness are matched.
    facing : float
        Power of both cosines that weighs the bins of the match. 0 counts all alike, as the thesis does; then grazing
        light, which hardly enters and stays pale, makes dark skin gray from the front as well.
    lock_surface : bool
        Whether the roughness is the surface's own as well, and only the colour is matched.
    tissue : Tissue
        What stays fixed.
    bins : Bins
        Of the BRDF.
    """

    shader: str = "ggx-lambert"
    engine: str = "volume"
    seed: int = 0
    paths: int = 20_000
    beam_paths: int = 10_000
    nodes: dict[str, int] = field(default_factory=lambda: dict(NODES))
    crowded: bool = True
    first_nm: float = 400.0
    last_nm: float = 700.0
    step_nm: float = 10.0
    fit_reflectance: bool = False
    facing: float = 4.0
    lock_surface: bool = False
    tissue: Tissue = field(default_factory=Tissue)
    bins: Bins = field(default_factory=Bins)

    def __post_init__(self) -> None:
        check_engine(self.engine)
        shader_named(self.shader)
        check_names(self.nodes)
        object.__setattr__(self, "nodes", {name: self.nodes.get(name, NODES[name]) for name in PARAMETERS})
        for name, count in self.nodes.items():
            checked_whole(count, f"number of {name} nodes", 1, 33)
        checked_number(self.step_nm, "step_nm", 1, 50)
        checked_number(self.facing, "facing", 0, 10)
        checked_whole(self.seed, "seed", 0)
        checked_whole(self.paths, "paths", 100, MOST_PATHS)
        checked_whole(self.beam_paths, "beam_paths", 0, MOST_PATHS)
        if self.lock_surface and self.fit_reflectance:
            raise InputError(
                "lock_surface keeps the reflectance of the surface and fit_reflectance matches it; choose one of the two"
            )

    def settings(self) -> dict[str, Any]:
        """Write everything out.

        Returns
        -------
        settings : dict
            Plain values, for JSON.
        """
        return json.loads(json.dumps(asdict(self)))

    @property
    def key(self) -> str:
        """A short name that changes with any of the settings."""
        return hashlib.sha256(json.dumps(self.settings(), sort_keys=True).encode()).hexdigest()[:16]

    @property
    def nm(self) -> NDArray[np.float64]:
        """Wavelengths."""
        return np.arange(self.first_nm, self.last_nm + self.step_nm / 2, self.step_nm)


def make_table(
    making: Making,
    *,
    kept: MutableMapping[str, NDArray[np.float64]] | None = None,
    threads: int | None = None,
    tick: Tick | None = None,
) -> SkinTable:
    """Fill a table.

    Parameters
    ----------
    making : Making
        How.
    kept : mapping, optional
        Finished pieces by name: those in it are not done again, and new ones go into it.
    threads : int, optional
        None means every core; it changes no number.
    tick : callable, optional
        Told the finished share; may raise to stop.

    Returns
    -------
    table : SkinTable
        With all settings.
    """
    kept = {} if kept is None else kept
    maker = _Maker(making, threads)
    pieces, rows = maker.pieces(), []
    across = len({corneum.start for _, corneum in pieces})
    for done, (epidermis, corneum) in enumerate(pieces):
        name = f"{making.key}-{epidermis.start}-{epidermis.stop}-{corneum.start}"
        if name not in kept:
            for share in maker.fill(epidermis, corneum, kept, name):
                if tick:
                    tick((done + share) / len(pieces))
        rows.append(kept[name])
        if tick:
            tick((done + 1) / len(pieces))
    columns = [np.concatenate(rows[i : i + across], axis=3) for i in range(0, len(rows), across)]
    return SkinTable(np.concatenate(columns, axis=2), making.settings())


_MOST_ENTRIES = 2000
"""Entries of a piece: their BRDFs take 60 MB."""

_Sorted = tuple[Paths, NDArray[np.float64], tuple[NDArray[np.int64], NDArray[np.int64]]]


class _Maker:
    """What the pieces of a table share."""

    def __init__(self, making: Making, threads: int | None) -> None:
        self.making, self.threads = making, threads
        self.axes = {name: nodes(name, making.nodes[name], crowded=making.crowded) for name in PARAMETERS}
        self.weights = rgb_weights(making.nm)
        self.crossed: dict[float, _Sorted] = {}

    @cached_property
    def surface(self) -> NDArray[np.float64]:
        making = self.making
        return surface_lobe(making.tissue, making.bins, seed=making.seed, threads=self.threads)

    def pieces(self) -> list[tuple[slice, slice]]:
        """Nodes of epidermis and stratum corneum that are filled at a time.

        Paths of the thesis' walk serve all thicknesses: as many at a time as memory likes. Others serve one pair.
        """
        epidermis, corneum = (len(self.axes[name]) for name in ("epidermis_cm", "stratum_corneum_cm"))
        if self.making.engine == "biospec":
            entries = int(np.prod([len(each) for each in self.axes.values()])) // epidermis
            step = max(1, _MOST_ENTRIES // entries)
            return [
                (slice(i, min(i + step, epidermis)), slice(0, corneum)) for i in range(0, epidermis, step)
            ]
        return [(slice(i, i + 1), slice(j, j + 1)) for i in range(epidermis) for j in range(corneum)]

    def absorbers(self, nm: float, corneum_cm: NDArray, epidermis_cm: NDArray, thick: bool) -> Absorbers:
        """All combinations at a wavelength, thicknesses of the epidermis fastest; `thick`: per thickness, not per cm."""
        tissue, axes, wave = self.making.tissue, self.axes, np.array([nm])
        pheomelanin, melanin = np.meshgrid(axes["pheomelanin"], axes["melanin"], indexing="ij")
        blood, oxygen = np.meshgrid(axes["blood"], axes["oxygenation"], indexing="ij")
        pigment = epidermis_absorption(tissue, wave, melanin, pheomelanin).ravel()
        papillary = dermis_absorption(tissue, wave, blood, oxygen).ravel()
        reticular = dermis_absorption(tissue, wave, tissue.reticular_blood * blood, oxygen).ravel()
        corneum = np.repeat(corneum_absorption(tissue, wave), len(corneum_cm))
        if thick:
            return Absorbers(
                corneum * corneum_cm,
                np.outer(pigment, epidermis_cm).ravel(),
                papillary * tissue.papillary_cm,
                reticular * tissue.reticular_cm,
            )
        return Absorbers(corneum, pigment, papillary, reticular)

    def walk(self, nm: float, corneum_cm: NDArray, epidermis_cm: NDArray) -> _Sorted:
        """Paths under even light, sorted into the bins of the BRDF; no thickness changes those of the thesis' walk."""
        making = self.making
        if nm in self.crossed:
            return self.crossed[nm]
        if making.engine == "biospec":
            walked = self.sorted(
                crossing_paths(making.tissue, nm, making.paths, seed=making.seed, threads=self.threads)
            )
            if len(self.pieces()) > 1:
                self.crossed[nm] = walked
            return walked
        return self.sorted(
            self.beam(nm, making.paths, float(corneum_cm[0]), float(epidermis_cm[0]), cosine=0.0)
        )

    def sorted(self, paths: Paths) -> _Sorted:
        """Paths with their weight in the BRDF, and where they belong."""
        bins = self.making.bins
        step = bins.incident(paths.cosine)
        weight = paths.weight / np.bincount(step, minlength=bins.zenith)[step] / bins.solid_angle
        return paths, weight, sorted_into(weight, bins.of(paths.cosine, paths.leaving), bins.count)

    def beam(self, nm: float, count: int, corneum_cm: float, epidermis_cm: float, cosine: float) -> Paths:
        making = self.making
        return volume_paths(
            making.tissue, nm, count, stratum_corneum_cm=corneum_cm, epidermis_cm=epidermis_cm,
            seed=making.seed, cosine=cosine, threads=self.threads,
        )  # fmt: skip

    def fill(
        self, epidermis: slice, corneum: slice, kept: MutableMapping[str, NDArray], name: str
    ) -> Iterator[float]:
        """Do one piece, telling its finished share; it is kept when whole: (p, m, e, s, b, o, columns)."""
        making, bins, thick = self.making, self.making.bins, self.making.engine == "biospec"
        p, m, b, o = (len(self.axes[each]) for each in ("pheomelanin", "melanin", "blood", "oxygenation"))
        epidermis_cm, corneum_cm = (
            self.axes["epidermis_cm"][epidermis],
            self.axes["stratum_corneum_cm"][corneum],
        )
        e, s, d = len(epidermis_cm), len(corneum_cm), b * o
        total = np.zeros((bins.count, 3, p * m * e, s * d))
        wide = np.zeros((e, s, len(EDGES_MM) + 1, 3, p * m, d))
        for k, nm in enumerate(making.nm):
            yield 0.9 * k / len(making.nm)
            paths, weight, places = self.walk(nm, corneum_cm, epidermis_cm)
            absorbers = self.absorbers(nm, corneum_cm, epidermis_cm, thick)
            absorbers.sorted_sums(paths, weight, places, self.weights[k], total, threads=self.threads)
            if making.beam_paths:
                for i, r in np.ndindex(e, s):
                    beam = self.beam(
                        nm, making.beam_paths, float(corneum_cm[r]), float(epidermis_cm[i]), cosine=1.0
                    )
                    alone = self.absorbers(nm, corneum_cm[r : r + 1], epidermis_cm[i : i + 1], thick=False)
                    alone.sums(
                        beam, beam.weight, rings(beam.wander_cm), self.weights[k], wide[i, r],
                        threads=self.threads,
                    )  # fmt: skip
        yield 0.9
        brdf = bins.symmetric(total.reshape(bins.count, 3, -1).transpose(2, 1, 0)) + self.surface
        values = np.zeros((p, m, e, s, b, o, len(COLUMNS)))
        values[..., :5] = self.matched(brdf).reshape(p, m, e, s, b, o, 5)
        if making.beam_paths:
            light = wide.reshape(e, s, len(EDGES_MM) + 1, 3, p, m, b, o)
            values[..., 5:] = fit_width(light.transpose(4, 5, 0, 1, 6, 7, 3, 2))[0]
        kept[name] = values

    def matched(self, brdf: NDArray[np.float64]) -> NDArray[np.float64]:
        """Colour, reflectance and roughness of BRDFs (n, 3, bins): (n, 5)."""
        making = self.making
        shader, index, shape, level = shader_named(making.shader), making.tissue.index[0], None, None
        if making.lock_surface:
            shape = shader.shape_of(making.tissue.fold)
        if making.lock_surface or not making.fit_reflectance:
            level = ((index - 1) / (index + 1)) ** 2
        weight = making.bins.facing(making.facing)
        found = match(
            shader, making.bins, brdf, shape=shape, reflectance=level, most=MOST_REFLECTANCE, weight=weight
        )
        color = shader.color(found.diffuse, found.reflectance)
        return np.column_stack([color, found.reflectance, shader.roughness(found.shape)])
