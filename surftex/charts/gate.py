"""The gate: what an unwrap must be before a bake uses it, whoever made it; and the choice of an unwrap by it.

Inside 0 to 1; every face has area; nearly all of the surface (99.9 %) stretched at most 4 times and within 4
times the mean density; no texel in two faces; free texels between charts; not next to nothing of the page.
Mirrored charts may pass: artists draw them, and the tangents' sign takes care of them. Who insists on his own UVs
(``keep``) is refused only what would spoil the bake: overlaps, UVs off the page, a tenth of the area or more
stretched, uneven or without texels; everything else becomes a warning with its figures.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from surftex.charts.atlas import Atlas, tile_origin
from surftex.charts.fill import nearest_mapped
from surftex.charts.overlap import core_faces, overlapping_faces
from surftex.charts.quality import ANISOTROPY_LIMIT, DENSITY_LIMIT, face_quality
from surftex.charts.unwrap import Method, default_gutter, unwrap
from surftex.errors import InputError
from surftex.kernels.pool import Tick
from surftex.surface.surface import Surface

AREA_SHARE = 0.999
"""Share of the area that the limits of stretch hold for."""

GROSS_SHARE = 0.1
"""Share of the area beyond the limits of stretch that nobody may insist on."""

LEAST_COVERAGE = 1e-4
"""Share of the page that charts cover at least; less is a hundredth of its side."""

GAP_PX = 3
"""Fewest free texels between charts of the file's own: bilinear lookup mixes one and a half from either side."""

MEASURED_PX = 2048
"""Largest page that gaps are measured on; wider pages scale them."""

UNWRAP = 'uv = "unwrap" (--uv unwrap)'
USE_UNWRAP = f". Use {UNWRAP}"
"""How to mend own UVs; the end of a refusal of them, which is taken off where they are unwrapped anew."""

Uv = Literal["auto", "keep", "unwrap"]


@dataclass(frozen=True)
class GateReport:
    """What the gate found.

    Attributes
    ----------
    outside_faces : int
        Faces with a corner outside 0 to 1.
    flat_faces : int
        Faces without area on the page.
    mirrored_faces : int
        Faces seen from behind on the page.
    stretched_share : float
        Share of the area stretched more than 4 times.
    uneven_share : float
        Share of the area more than 4 times denser or sparser than the mean.
    overlapping_texels : int
        Texels whose centre lies in several faces.
    gap_px : float
        Free texels between the two nearest charts, on the page asked for; inf with one chart.
    worst_anisotropy : float
        Of all faces with area on the page.
    texels_per_mm : float
        Mean density.
    coverage : float
        Share of texels whose centre lies in a chart.
    problems : tuple of str
        Why the unwrap cannot be used by anybody; empty if it can.
    flaws : tuple of str
        Why it is used only where somebody insists.
    """

    outside_faces: int
    flat_faces: int
    mirrored_faces: int
    stretched_share: float
    uneven_share: float
    overlapping_texels: int
    gap_px: float
    worst_anisotropy: float
    texels_per_mm: float
    coverage: float
    problems: tuple[str, ...]
    flaws: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether a bake may use the unwrap without being told to."""
        return not self.problems and not self.flaws

    def mirrored(self, faces: int) -> str:
        """Say what follows for mirrored faces.

        Parameters
        ----------
        faces : int
            Of the surface.

        Returns
        -------
        text : str
            How many there are, and that they come to no harm.
        """
        return (
            f"{self.mirrored_faces} of {faces} faces are mirrored in the file's own UVs; they are baked so that they look "
            "right, by the sign of their tangents"
        )


def gate(
    surface: Surface,
    atlas: Atlas,
    resolution: int,
    *,
    gap_px: float = GAP_PX,
    udim: bool = False,
    threads: int | None = None,
) -> GateReport:
    """Examine an unwrap.

    Parameters
    ----------
    surface : Surface
        What is unwrapped.
    atlas : Atlas
        The unwrap.
    resolution : int
        Side of the page in texels that a bake will use.
    gap_px : float
        Free texels that must lie between charts.
    udim : bool
        Whether the atlas may have several pages, a unit square each.
    threads : int, optional
        None means every core.

    Returns
    -------
    report : GateReport
        Measures, and why it fails if it does.
    """
    uv, area = atlas.corner_uv, surface.face_area_mm2
    total = area.sum()
    quality = face_quality(surface, uv)
    local = uv - tile_origin(atlas.tile)[:, None] if udim else uv
    outside = ((local < -1e-6) | (local > 1 + 1e-6)).any(axis=(1, 2))
    if udim:
        outside |= ((uv < -1e-6) | (uv > [10 + 1e-6, 900.0])).any(axis=(1, 2))
    flat = quality.orientation == 0
    mean = np.sqrt((area * quality.density**2).sum() / total)
    stretched = float(area[quality.anisotropy > ANISOTROPY_LIMIT].sum() / total)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = quality.density / mean
    uneven = float(area[~((ratio <= DENSITY_LIMIT) & (ratio >= 1 / DENSITY_LIMIT))].sum() / total)
    problems: list[str] = []
    flaws: list[str] = []
    faces = len(uv)
    overlapping, gap, coverage = 0, np.inf, 0.0
    if outside.any():
        several = (
            " (udim, --udim, takes tiles)"
            if not udim and (uv >= -1e-6).all() and (uv[..., 0] <= 10).all()
            else ""
        )
        off = ((uv < -1e-6) | (uv > [10 + 1e-6, 900.0])).any(axis=(1, 2))
        if udim and off.any():
            odd, left = off, "the tiles (u goes from 0 to 10, v from 0 up)"
        else:
            odd, left = outside, "their tile" if udim else f"0..1{several}"
        problems.append(f"{odd.sum()} of {faces} faces leave {left}; the first is face {int(odd.argmax())}")
    for share, text in (
        (
            float(area[flat].sum() / total),
            f"{flat.sum()} of {faces} faces have no area on the page; the first is face {int(flat.argmax())}",
        ),
        (
            stretched,
            f"{100 * stretched:.1f} % of the area is stretched more than {ANISOTROPY_LIMIT:g} times",
        ),
        (
            uneven,
            f"{100 * uneven:.1f} % of the area is over {DENSITY_LIMIT:g} times denser or sparser than the rest",
        ),
    ):
        if share > 1 - AREA_SHARE:  # whatever is without area or stretched is uneven too: one of them is told
            (problems if share > GROSS_SHARE else flaws).append(text)
            break
    if not problems:
        measured, tiles = min(resolution, MEASURED_PX), atlas.tiles if udim else (1001,)
        for tile in tiles:
            page = atlas.page(tile)
            count, pairs = overlapping_faces(page.corner_px(resolution), resolution, threads=threads)
            if count and not overlapping:
                problems.append(
                    f"{count} texels lie in several faces; the first pair is {pairs[0, 0]} and {pairs[0, 1]}"
                )
            overlapping += count
            owner = core_faces(page.corner_px(measured), measured, threads=threads)
            coverage += float((owner >= 0).mean()) / len(tiles)
            gap = min(gap, _gap(page, owner) * resolution / measured)
        if coverage < LEAST_COVERAGE:
            problems.append(
                f"charts cover {100 * coverage:.2g} % of the page at {measured} texels; a bake takes "
                f"{100 * LEAST_COVERAGE:g} % or more"
            )
        elif gap < gap_px and not overlapping:
            flaws.append(
                f"charts are only {gap:.1f} texels apart at {resolution} texels; a bake takes {gap_px:g}"
            )
    finite = quality.anisotropy[~flat]
    return GateReport(
        outside_faces=int(outside.sum()),
        flat_faces=int(flat.sum()),
        mirrored_faces=int((quality.orientation < 0).sum()),
        stretched_share=stretched,
        uneven_share=uneven,
        overlapping_texels=overlapping,
        gap_px=float(gap),
        worst_anisotropy=float(finite.max()) if len(finite) else float("inf"),
        texels_per_mm=atlas.texels_per_mm(surface, resolution),
        coverage=coverage,
        problems=tuple(problems),
        flaws=tuple(flaws),
    )


def keep_own(
    surface: Surface,
    *,
    resolution: int = 2048,
    udim: bool = False,
    insist: bool = False,
    threads: int | None = None,
) -> Atlas:
    """Use the file's own unwrap, if a bake can.

    Parameters
    ----------
    surface : Surface
        With `corner_uv`.
    resolution : int
        Side of the page in texels.
    udim : bool
        Whether it may have several pages.
    insist : bool
        Whether flaws that spoil no bake become notes.
    threads : int, optional
        None means every core.

    Returns
    -------
    atlas : Atlas
        Its gutter is as wide as the charts' gaps have room for, 16 texels at most.

    Raises
    ------
    InputError
        If there is none, or the gate refuses it, with the reason.
    """
    if surface.corner_uv is None:
        raise InputError(f"{surface.name} has no UVs of its own; use {UNWRAP}")
    atlas = Atlas.of(surface, surface.corner_uv)
    report = gate(surface, atlas, resolution, udim=udim, threads=threads)
    if report.problems or (report.flaws and not insist):
        what = "cannot be baked on" if report.problems else 'are kept only with uv = "keep" (--uv keep)'
        raise InputError(
            f"the UVs of {surface.name} {what}: {'; '.join((*report.problems, *report.flaws))}{USE_UNWRAP}"
        )
    notes = [f"the file's own UVs are kept as asked, though {flaw}" for flaw in report.flaws]
    if report.mirrored_faces:
        notes.append(report.mirrored(len(surface.faces)))
    wide = default_gutter(resolution)
    gutter = int(min(wide, max(2, report.gap_px // 2)))
    if gutter < wide:
        notes.append(f"the file's own charts leave room for a gutter of {gutter} texels at {resolution}")
    return Atlas.of(surface, surface.corner_uv, resolution=resolution, gutter_px=gutter, notes=tuple(notes))


def choose_atlas(
    surface: Surface,
    *,
    uv: Uv = "auto",
    method: Method = "auto",
    resolution: int = 2048,
    gutter_px: int | None = None,
    budget_s: float = 30.0,
    threads: int | None = None,
    tick: Tick | None = None,
) -> Atlas:
    """Keep the file's own unwrap or make a new one.

    Parameters
    ----------
    surface : Surface
        What will be baked.
    uv : {"auto", "keep", "unwrap"}
        ``"auto"`` keeps own UVs that pass the gate, and else unwraps with a note that says why; ``"keep"``
        insists: flaws become notes.
    method : {"auto", "xatlas", "uvunwrap"}
        Who unwraps.
    resolution : int
        Side of the page in texels.
    gutter_px : int, optional
        As in `unwrap`.
    budget_s : float
        As in `unwrap`.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share; may raise to cancel.

    Returns
    -------
    atlas : Atlas
        Ready to bake on.

    Raises
    ------
    InputError
        If ``"keep"`` cannot be had, or an option is unknown.
    """
    if uv not in get_args(Uv):
        raise InputError(f"uv is {uv!r}; it takes one of {', '.join(get_args(Uv))}")
    reason = ""
    if uv == "keep" or (uv == "auto" and surface.corner_uv is not None):
        try:
            return keep_own(surface, resolution=resolution, insist=uv == "keep", threads=threads)
        except InputError as problem:
            if uv == "keep":
                raise
            reason = str(problem).removesuffix(USE_UNWRAP)
    atlas = unwrap(
        surface, method=method, resolution=resolution, gutter_px=gutter_px, budget_s=budget_s, tick=tick
    )
    if not reason:
        return atlas
    return Atlas(**{**vars(atlas), "notes": (f"unwrapped anew: {reason}", *atlas.notes)})


def _gap(atlas: Atlas, owner: NDArray[np.int32]) -> float:
    """Measure the free texels between the two nearest charts, from the texels that they own."""
    mapped = owner >= 0
    if atlas.chart_count < 2 or not mapped.any():
        return float("inf")
    width = owner.shape[1]
    source = nearest_mapped(mapped)
    label = atlas.chart[owner.ravel()[source]]
    least = np.inf
    for near, far in (
        ((slice(None), slice(1, None)), (slice(None), slice(None, -1))),
        ((slice(1, None), slice(None)), (slice(None, -1), slice(None))),
    ):
        meet = label[near] != label[far]
        first, second = source[near][meet], source[far][meet]
        if len(first):
            apart = np.hypot(first % width - second % width, first // width - second // width)
            least = min(least, float(apart.min()))
    return max(0.0, least - 1)
