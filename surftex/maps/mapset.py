"""`MapSet`: what a bake gives. Pictures by name, with the surface they belong to, to save or to look at."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surftex.charts.atlas import Atlas
from surftex.errors import InputError
from surftex.files.output import check_output, file_hashes, whole_output
from surftex.maps.page import read_only
from surftex.paged import blocks
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.maps.exchange import Usd
    from surftex.maps.notebook import TexturedMesh

MAPS = {
    "base_color": "(h, w, 3) linear sRGB, 0 to 1; 8-bit sRGB PNG",
    "roughness": "(h, w) 0 to 1, linear; 8-bit PNG",
    "normal": "(h, w, 3) unit vectors, -1 to 1, along tangent, bitangent, normal; 16-bit PNG",
    "height": "(h, w) mm above the surface; 32-bit EXR",
    "ambient_occlusion": "(h, w) 0 to 1, 1 = open; 8-bit PNG",
    "specular": "(h, w) F0 / 0.08, 0 to 1; 8-bit PNG",
    "metallic": "(h, w) 0 to 1; 8-bit PNG",
    "region": "(h, w) int32, -1 = none; 32-bit EXR",
    "subsurface": "(h, w) share of light that enters, 0 to 1; 8-bit PNG",
    "subsurface_radius_mm": "(h, w, 3) mm, mean way of red, green and blue below the surface; 32-bit EXR",
}
"""Maps that every viewer knows. Other names are raw parameters: 32-bit EXR of (h, w) or (h, w, 3) numbers."""

_COLOURS = {"base_color", "normal", "subsurface_radius_mm"}


@dataclass(frozen=True, eq=False)
class MapSet(Mapping[str, NDArray[Any]]):
    """Maps of one surface under one unwrap; ``maps["height"]`` is an array, row 0 on top.

    Attributes
    ----------
    maps : mapping of str to (h, w) or (h, w, 3) float32
        By name, in the ranges of `MAPS`; ``region`` is int32; pages of a UDIM bake by name and number, such as
        ``height.1002``. Read-only views: the arrays are handed over.
    surface : Surface
        What was baked; m faces.
    atlas : Atlas
        Its unwrap.
    tangents : (m, 3, 4) float64
        Those that the normal map is told in; see `surftex.maps.normal.surface_tangents`.
    features : mapping of str to structured array, or None
        Everything placed, by kind.
    report : mapping
        Plain JSON.
    stem : str
        Start of file names.
    """

    maps: Mapping[str, NDArray[Any]]
    surface: Surface
    atlas: Atlas
    tangents: NDArray[np.float64]
    features: Mapping[str, NDArray[Any]] | None = None
    report: Mapping[str, Any] = field(default_factory=dict)
    stem: str = ""

    def __post_init__(self) -> None:
        maps = {name: _checked_map(name, image) for name, image in self.maps.items()}
        sizes = {image.shape[:2] for image in maps.values()}
        if len(sizes) > 1:
            raise InputError(f"maps have several sizes: {', '.join(map(str, sorted(sizes)))}")
        stem = self.stem or self.surface.name
        if not stem or stem.startswith(".") or any(c in '/\\:*?"<>|\0\n' for c in stem):
            raise InputError(f"{stem!r} cannot start file names")
        object.__setattr__(self, "maps", MappingProxyType(maps))
        object.__setattr__(self, "stem", stem)

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self.maps:
            raise KeyError(f"{name!r}; this bake made {', '.join(self.maps)}")
        return self.maps[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.maps)

    def __len__(self) -> int:
        return len(self.maps)

    def __repr__(self) -> str:
        size = "x".join(str(n) for n in next(iter(self.maps.values())).shape[:2]) if self.maps else "no"
        return f"MapSet({self.stem!r}, {size} texels: {', '.join(self.maps)})"

    def _repr_html_(self) -> str:
        from surftex.maps.notebook import contact_sheet

        return contact_sheet(self)

    @property
    def file_names(self) -> list[str]:
        """Names of the files that `save` writes unless told more."""
        from surftex.maps.encode import file_name, textures_beside

        names = [
            f"{self.stem}.glb",
            *(file_name(self.stem, name) for name in [*self.maps, *textures_beside(self)]),
        ]
        return [*names, *(["features.npz"] if self.features is not None else []), "report.json"]

    def save(
        self,
        folder: str | Path,
        *,
        materialx: bool = False,
        usd: "Usd | None" = None,
        overwrite: bool = False,
        threads: int | None = None,
    ) -> list[Path]:
        """Write maps, GLB, features and report: all of them, or nothing.

        Parameters
        ----------
        folder : path
            Made when it is missing. Files of other names in it stay.
        materialx : bool
            Write the material as MaterialX as well.
        usd : {"usda", "usdc", "usdz"}, optional
            Write mesh and material as USD as well; it takes the extra ``usd``.
        overwrite : bool
            Whether files of the same names may be replaced.
        threads : int, optional
            None means every core; it cannot change a byte.

        Returns
        -------
        paths : list of Path
            What was written.

        Raises
        ------
        InputError
            If the folder is a file or a link, or holds one of the files.
        WorkError
            If the disk does not take them.
        """
        from surftex.maps.exchange import exchange_names

        more = exchange_names(self.stem, materialx=materialx, usd=usd)
        check_output(folder, [*self.file_names, *more], overwrite=overwrite)
        with whole_output(folder, overwrite=overwrite) as workplace:
            self.write(workplace, materialx=materialx, usd=usd, threads=threads)
            names = sorted(path.name for path in workplace.iterdir())
        return [Path(folder) / name for name in names]

    def write(
        self,
        workplace: Path,
        *,
        materialx: bool = False,
        usd: "Usd | None" = None,
        threads: int | None = None,
    ) -> None:
        """Write everything into a folder that is nobody's yet; `save` and bakes with more files build on it.

        Parameters
        ----------
        workplace : Path
            From `surftex.files.output.whole_output`. The report lists all files that are in it.
        materialx : bool
            As for `save`.
        usd : {"usda", "usdc", "usdz"}, optional
            As for `save`.
        threads : int, optional
            None means every core.
        """
        from surftex.files.features import save_features
        from surftex.maps.encode import write_maps
        from surftex.maps.exchange import write_exchange

        write_maps(self, workplace, threads=threads)
        write_exchange(self, workplace, materialx=materialx, usd=usd)
        if self.features is not None:
            save_features(workplace / "features.npz", self.features, self.report.get("placed"))
        report = {**self.report, "outputs": file_hashes(workplace)}
        (workplace / "report.json").write_text(
            json.dumps(report, indent=1, ensure_ascii=False) + "\n", "utf-8"
        )

    def textured_mesh(self) -> "TexturedMesh":
        """Make meshes for a notebook.

        Returns
        -------
        meshes : TexturedMesh
            ``.polydata`` with ``.texture`` (`polydata.plot(texture=texture)`) for pyvista, and ``.trimesh``
            (``trimesh.show()``) with a PBR material; millimetres.
        """
        from surftex.maps.notebook import textured_mesh

        return textured_mesh(self)


def _checked_map(name: str, image: NDArray[Any]) -> NDArray[Any]:
    """Refuse pictures that cannot be the map of that name."""
    base, _, tile = name.partition(".")
    if not base.isidentifier() or (tile and not tile.isdigit()):
        raise InputError(
            f"{name!r} is no name of a map; it takes letters, digits and underscores, and a tile's number after a point"
        )
    array = np.asarray(image)
    channels = 3 if base in _COLOURS else 1
    shape = array.shape[2:]
    known = base in MAPS
    if (
        array.ndim not in (2, 3)
        or (known and shape != ((3,) if channels == 3 else ()))
        or shape not in ((), (3,))
    ):
        raise InputError(
            f"map {name} has shape {array.shape}; it takes {MAPS.get(base, '(h, w) or (h, w, 3)')}"
        )
    array = array.astype(np.int32 if base == "region" else np.float32, copy=False)
    if array.dtype == np.float32:
        wrong = sum(int(np.count_nonzero(~np.isfinite(array[rows]))) for rows in blocks(array))
        if wrong:
            raise InputError(f"map {name} holds {wrong} values that are not finite")
    return read_only(array)
