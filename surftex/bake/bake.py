"""`bake`: a surface and a material, down the hill to maps."""

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from numpy.typing import NDArray

from surftex.arrays import checked_whole
from surftex.bake.stages import Progress, Stages
from surftex.errors import InputError, WorkError
from surftex.kernels.pool import one_blas_thread
from surftex.recipe.model import BakeSettings, MeshSettings, Recipe
from surftex.recipe.read import load_recipe, recipe_for
from surftex.surface.surface import Surface
from surftex.words import sort_of

if TYPE_CHECKING:
    from surftex.bake.displacing import Baked
    from surftex.bake.growing import Growth
    from surftex.charts.atlas import Atlas
    from surftex.maps.mapset import MapSet


def bake(
    subject: Any,
    material: Any = None,
    *,
    resolution: int | None = None,
    seed: int | None = None,
    maps: tuple[str, ...] | list[str] | str | None = None,
    threads: int | None = None,
    uv: Literal["auto", "keep", "unwrap"] | None = None,
    unwrapper: Literal["auto", "xatlas", "uvunwrap"] | None = None,
    gutter: int | None = None,
    features: Mapping[str, NDArray] | str | os.PathLike[str] | None = None,
    tile: int | None = None,
    progress: Progress | None = None,
    max_features: int | None = None,
    equalise: bool | None = None,
) -> "MapSet":
    """Bake a material onto a surface.

    Parameters
    ----------
    subject : Surface, path, trimesh.Trimesh, pyvista.PolyData, (vertices, faces) or Recipe
        What to bake; meshes in memory are in millimetres. The path of a TOML recipe, or a `Recipe`, stands
        for mesh and material both.
    material : Leather, Recipe or str, optional
        A material, a recipe, the name of a preset, or the path of a recipe.
    resolution : int, optional
        Side of the maps in texels; a recipe's own, or 2048.
    seed : int, optional
        Of everything random; a recipe's own, or 0.
    maps : sequence of str, optional
        Such as ``("height", "normal")``; what the material makes, without it.
    threads : int, optional
        None means every core; cannot change a byte.
    uv : {"auto", "keep", "unwrap"}, optional
        What to do with the file's own UVs.
    unwrapper : {"auto", "xatlas", "uvunwrap"}, optional
        Who unwraps where that is needed.
    gutter : int, optional
        Free texels around charts; chosen by the resolution without it.
    features : mapping or path, optional
        What an earlier bake placed (``maps.features`` or its ``features.npz``): nothing is placed anew. A file says
        with which seed, size and parameters; others are refused, and its seed is taken where none is given.
    tile : int, optional
        Rows that are worked on at a time, to bound memory; cannot change a byte.
    progress : callable, optional
        ``progress(stage, share)``; may raise to cancel.
    max_features : int, optional
        The bake refuses beyond it; 5 million without it.
    equalise : bool, optional
        Even out what is left of seams by least squares.

    Returns
    -------
    maps : MapSet
        Maps by name, and the report.

    Raises
    ------
    InputError
        If mesh, material or an option is wrong; what, where and how to mend it, in one line.
    WorkError
        If the work itself failed.

    Examples
    --------
    >>> import surftex as sx
    >>> maps = sx.bake(sx.shapes.sphere(20), sx.Leather.preset("calf"), resolution=64)  # doctest: +SKIP
    >>> maps["height"].shape  # doctest: +SKIP
    (64, 64)
    """
    subject, recipe = _recipe_and_subject(subject, material)
    whole = Recipe.of(
        recipe,
        resolution=resolution,
        seed=seed,
        maps=_names(maps),
        uv=uv,
        unwrapper=unwrapper,
        gutter=gutter,
        max_features=max_features,
        equalise=equalise,
    )
    return run(whole, subject, features=features, threads=threads, tile=tile, progress=progress).maps


def run(
    recipe: Recipe,
    subject: Any = None,
    *,
    features: Mapping[str, NDArray] | str | os.PathLike[str] | None = None,
    threads: int | None = None,
    tile: int | None = None,
    progress: Progress | None = None,
    remember: bool = False,
    growth: "Growth | None" = None,
) -> "Baked":
    """Bake a recipe, and keep the patterns beside the maps.

    Parameters
    ----------
    recipe : Recipe
        Everything that decides the bake.
    subject : as for `bake`, optional
        The recipe's own mesh without it.
    features : mapping or path, optional
        As for `bake`.
    threads : int, optional
        As for `bake`.
    tile : int, optional
        As for `bake`.
    progress : callable, optional
        As for `bake`.
    remember : bool
        Take unwrap and features from the user's cache folder where an earlier run left them, and leave them there.
    growth : Growth, optional
        Goes on from it, keeps it when the bake is done or cut off, and remembers states on the way.

    Returns
    -------
    baked : Baked
        ``maps`` and ``stack``.

    Raises
    ------
    InputError
        As for `bake`.
    WorkError
        As for `bake`.
    """
    threads = None if threads is None else checked_whole(threads, "threads", 1)
    tile = None if tile is None else checked_whole(tile, "tile", 1)
    if recipe.bake.usd:
        from surftex.files.usd import check_usd

        check_usd()
    try:
        with one_blas_thread():
            return _bake(
                subject, recipe, features, threads, tile, Stages(progress), remember=remember, growth=growth
            )
    except MemoryError:
        side = recipe.bake.resolution
        raise WorkError(
            f"not enough memory for {side} x {side}; lower the resolution or ask for fewer maps"
        ) from None


def _bake(
    subject: Any, recipe: Recipe, features: Any, threads: int | None, tile: int | None, stages: Stages,
    *, remember: bool, growth: "Growth | None",
) -> "Baked":  # fmt: skip
    from surftex.bake.advising import foretell_sizes, foretell_time
    from surftex.bake.displacing import Baked
    from surftex.bake.fields import make_fields
    from surftex.bake.growing import ground_key, grown_on
    from surftex.bake.growth_facts import grown_cells
    from surftex.bake.limits import foresee, refuse_too_many
    from surftex.bake.looks import clamped_warnings
    from surftex.bake.pages import bake_pages, chosen_maps, equalise_pages
    from surftex.bake.placed import refuse_uncovered, start_from
    from surftex.bake.remembering import features_key, remember_features, remembered_features
    from surftex.bake.report import make_report, measured_seams
    from surftex.bake.scales import scale_report, size_warnings
    from surftex.bake.stack import place_stack
    from surftex.bake.unwrapping import Unwrapping
    from surftex.files.building import LEAVES_PAGE
    from surftex.maps.mapset import MapSet

    settings = recipe.bake
    with stages.stage("load"):
        surface = _surface(subject, recipe)
        stages.warn(
            *(each for each in surface.warnings if not (settings.udim and each.startswith(LEAVES_PAGE)))
        )
        given = _features(features, settings.max_features)
        untold: tuple[str, ...] = ()
        if isinstance(features, (str, os.PathLike)):
            recipe, untold = start_from(Path(features), recipe, surface)
            stages.warn(*untold)
        fields = make_fields(recipe, surface)
        if isinstance(features, (str, os.PathLike)):
            refuse_uncovered(Path(features), recipe, surface, fields)
        begun = None
        if growth is not None:
            begun = growth.begun(recipe, ground_key(surface, grown_on(recipe, surface, fields)))
    key = features_key(recipe, surface) if remember and given is None and growth is None else None
    with Unwrapping(surface, settings, stages, threads, remember=remember) as unwrapping:
        own = unwrapping.own
        loaded = surface.warnings
        if settings.udim and own is not None:
            loaded = tuple(each for each in loaded if not each.startswith(LEAVES_PAGE))
        stages.warn(*loaded, *unwrapping.notes, *(own.notes if own is not None else ()))
        foretold = foretell_sizes(recipe, surface, own, stages)
        with stages.stage("place") as tick:
            known = given if key is None else remembered_features(key)
            foreseen = None
            if given is None:
                foreseen = foresee(recipe, surface, fields)
                refuse_too_many(recipe, foreseen)
                if known is None and not begun:
                    foretell_time(recipe, surface, foreseen, own, threads, stages)
            options: Any = {"features": known, "begun": begun, "foreseen": foreseen, "threads": threads}
            if growth is None:
                stack = place_stack(recipe, surface, fields, tick=tick, **options)
            else:
                with growth.kept(stages, "place") as tick:
                    stack = place_stack(recipe, surface, fields, tick=tick, **options)
        if key is not None and known is None:
            remember_features(key, stack.features)
        stages.warn(*stack.warnings)
        maps = chosen_maps(stack, settings.maps)
        atlas = unwrapping.atlas()
    side = settings.resolution
    fits = size_warnings(recipe, surface.longest_side_mm, atlas.texels_per_mm(surface, side), side)
    stages.warned.update(text for layer, text in fits.items() if layer in foretold)
    paged = (*atlas.notes, *fits.values(), *_grey(settings, atlas), *_one_tile(settings, atlas))
    stages.warn(*paged)
    with stages.stage("bake") as tick:
        pages = bake_pages(
            surface, atlas, stack, settings.resolution, maps,
            gutter_px=settings.gutter, tile_rows=tile, udim=settings.udim, threads=threads, tick=tick,
        )  # fmt: skip
    moved: dict[str, Any] = {}
    if settings.equalise:
        with stages.stage("equalise") as tick:
            moved = equalise_pages(surface, atlas, pages, tick=tick)
    with stages.stage("seams"):
        seam = measured_seams(surface, atlas, pages)
    with stages.stage("scales"):
        scales = scale_report(surface, recipe, features=stack.features)
    warnings = loaded + untold + unwrapping.notes + paged + stack.warnings + clamped_warnings(pages, stack)
    stages.warn(*warnings)
    report = make_report(surface, recipe, stack, atlas, pages, seam, scales, stages, warnings)
    if moved:
        report["equalised"] = moved
    if grown := grown_cells(stack.features):
        report["cells"] = grown
    maps_made = MapSet(pages.images, surface, atlas, pages.tangents, stack.features, report)
    return Baked(maps_made, stack, recipe)


def _grey(settings: BakeSettings, atlas: "Atlas") -> tuple[str, ...]:
    if not (settings.displaced and settings.displaced_format == "glb" and len(atlas.tiles) > 1):
        return ()
    return ("the displaced GLB names no pictures, as they lie in several tiles: it is shown grey",)


def _one_tile(settings: BakeSettings, atlas: "Atlas") -> tuple[str, ...]:
    wanted = settings.udim and settings.texels_per_mm is None and settings.uv != "keep"
    if not wanted or len(atlas.tiles) > 1:
        return ()
    return (
        "all lies on one tile; name a density (texels_per_mm, --texels-per-mm) to have it spread over as many as that takes",
    )


def _recipe_and_subject(subject: Any, material: Any) -> tuple[Any, Any]:
    """Tell mesh and material apart; either may come from a recipe."""
    if material is None:
        if isinstance(subject, (str, os.PathLike)) and str(subject).lower().endswith(".toml"):
            subject = load_recipe(Path(subject))
        if not isinstance(subject, Recipe):
            raise InputError("a mesh needs a material: a Leather, a Recipe, or the name of a preset")
        if subject.mesh.path is None:
            raise InputError("the recipe names no mesh; add path under [mesh], or hand in a mesh as well")
        return None, subject
    if isinstance(material, (str, os.PathLike)):
        material = recipe_for(os.fspath(material))
    if isinstance(material, Recipe) and material.mesh.path is not None:
        material = material.model_copy(update={"mesh": MeshSettings()})  # how another mesh is to be read
    return subject, material


def _surface(subject: Any, recipe: Recipe) -> Surface:
    from surftex.bake.loading import load

    mesh = recipe.mesh
    if isinstance(subject, Surface):
        return subject
    path = mesh.path if subject is None else subject
    return load(path, units=mesh.units, size=mesh.size, part=mesh.part, crease=mesh.crease)


def _features(features: Any, most: int) -> Any:
    from surftex.bake.limits import ABOUT
    from surftex.bake.stack import counted

    if isinstance(features, (str, os.PathLike)):
        from surftex.files.features import load_features

        features = load_features(Path(features))
    if not isinstance(features, (Mapping, type(None))):
        raise InputError(f"features is {sort_of(features)}; it takes a bake's features, or their file")
    if features is not None and (count := counted(features)) > ABOUT * most:
        raise InputError(
            f"{count:,} features are given, more than the {most:,} that are allowed; raise max_features (--max-features)"
        )
    return features


def _names(maps: Any) -> Any:
    return tuple(maps) if isinstance(maps, Iterable) and not isinstance(maps, str) else maps
