"""From the polygons of a file, or of another library, to a surface in millimetres."""

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError
from surftex.files.polygons import Polygons, check_face_count
from surftex.files.reading import printable
from surftex.files.scaling import mm_per_unit
from surftex.surface.parts import chosen_faces, in_use, naming_kind
from surftex.surface.repair import extent, repair
from surftex.surface.surface import Surface
from surftex.surface.triangulate import triangulate
from surftex.words import by_count, sort_of

_UV_ROUNDING = 1e-4


def surface_of(
    polygons: Polygons,
    where: str,
    *,
    name: str,
    sha256: str,
    units: str | None = None,
    size: str | float | None = None,
    part: str | None = None,
) -> Surface:
    """Choose a part, scale, centre, triangulate and mend.

    Parameters
    ----------
    polygons : Polygons
        What was read.
    where : str
        Its origin, for messages.
    name : str
        Stem for file names.
    sha256 : str
        Of its bytes.
    units : str, optional
        As for `surftex.files.meshes.load`.
    size : str or float, optional
        As for `surftex.files.meshes.load`.
    part : str, optional
        As for `surftex.files.meshes.load`.

    Returns
    -------
    surface : Surface
        Vertices count from the middle of the bounding box.

    Raises
    ------
    MeshFileError
        If the part is unknown, or the scale cannot be told.
    SurfaceError
        If nothing with an area is left.
    """
    warnings = list(polygons.warnings)
    used = np.zeros(len(polygons.vertices), bool)
    used[polygons.corner] = True
    if not used.all():
        warnings.append(
            by_count(
                int((~used).sum()),
                "{} vertex that no face uses was dropped",
                "{} vertices that no face uses were dropped",
            )
        )
    places = polygons.vertices[used]
    scale, notes = mm_per_unit(
        float(extent(places).max()),
        where,
        own=polygons.mm_per_unit,
        named=polygons.named_unit,
        units=units,
        size=size,
    )
    warnings.extend(notes)
    kind, selected = (naming_kind(polygons.labels) if polygons.labels else None), False
    if part is not None:
        chosen = _chosen(polygons, part, where)
        polygons, selected = polygons.selected(chosen), not chosen.all()
        used[:] = False
        used[polygons.corner] = True
        places = polygons.vertices[used]
        extent(places)
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    points = (places - middle) * scale
    corner = (np.cumsum(used) - 1)[polygons.corner]

    sizes = np.diff(polygons.start)
    check_face_count(int((sizes - 2).sum()), where)
    triangles, polygon = triangulate(points, corner, polygons.start)
    labels = {kind: in_use(*label) for kind, label in polygons.labels.items()}
    label, names = labels[kind] if kind else (np.zeros(len(polygons.start) - 1, np.int32), ("surface",))
    uv = _own_uv(polygons, triangles, warnings)
    normal = None if polygons.normals is None else polygons.normals[triangles]
    mended = repair(
        points,
        corner[triangles],
        corner_uv=uv,
        corner_normal=normal,
        part=label[polygon],
        attributes={name: values[triangles] for name, values in polygons.attributes.items()},
    )
    kept, given = (np.bincount(part, minlength=len(names)) for part in (mended.part, label[polygon]))
    if lost := [
        name for name, now, before in zip(names, kept, given, strict=True) if before > 0 and now == 0
    ]:
        several = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
        warnings.append(
            f"nothing is left of part {lost[0]!r}{several}: all faces are too small beside the whole mesh, or have no area; "
            "choose such a part by itself (part, --part)"
        )
    return Surface.from_arrays(
        mended.vertices,
        mended.faces,
        corner_uv=mended.corner_uv,
        corner_normal=mended.corner_normal,
        part=mended.part,
        part_names=names,
        labels={kind: (index[polygon[mended.source_face]], names) for kind, (index, names) in labels.items()},
        selected=selected,
        origin_mm=middle * scale,
        name=name,
        sha256=sha256,
        mm_per_unit=scale,
        warnings=tuple(warnings) + mended.warnings,
        attributes=mended.attributes,
    )


def _chosen(polygons: Polygons, part: str, where: str) -> NDArray[np.bool_]:
    """Find the polygons of a part, where the file names any."""
    if not isinstance(part, str):
        raise MeshFileError(f"{where}: part is {sort_of(part)}; it takes a name")
    if not polygons.labels:
        raise MeshFileError(
            f"{where}: has no named parts, so there is no {printable(part, longest=60)!r}; leave the part out"
        )
    return chosen_faces(polygons.labels, part, f"{where}:", error=MeshFileError)


LEAVES_PAGE = "the file's UVs leave 0..1"
"""Start of a warning that says nothing where tiles are wanted."""


def _own_uv(
    polygons: Polygons, triangles: NDArray[np.int64], warnings: list[str]
) -> NDArray[np.float64] | None:
    """Take the first UV set that is complete and lies in 0..1, else the first complete one."""
    fallback: tuple[int, NDArray[np.float64]] | None = None
    partial = 0
    for number, values in enumerate(polygons.uv_sets):
        uv = values[triangles]
        sound = np.isfinite(uv).all(axis=(1, 2)) & (np.abs(uv) < 1e6).all(axis=(1, 2))
        if not sound.all():
            partial = partial or int((~sound).sum())
            continue
        side = uv[:, 1:] - uv[:, :1]
        area = np.abs(side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0])
        if not area.sum() > 0:
            warnings.append(f"UV set {number} has no area and is ignored")
            continue
        if uv.min() >= -_UV_ROUNDING and uv.max() <= 1 + _UV_ROUNDING:
            if number:
                warnings.append(f"UV set {number} is used: the sets before it leave 0..1 or are incomplete")
            return np.clip(uv, 0.0, 1.0)
        fallback = fallback or (number, uv)
    if fallback is not None:
        low, high = fallback[1].min(), fallback[1].max()
        warnings.append(f"{LEAVES_PAGE} (they run from {low:.3g} to {high:.3g})")
        return fallback[1]
    if partial:
        warnings.append(f"{partial} of {len(triangles)} faces have no usable UVs; the file's UVs are ignored")
    return None
