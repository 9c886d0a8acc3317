"""USD: a mesh with its unwrap and its material, for whatever opens a stage.

One prim holds the mesh and its materials. The stage counts in the unit of the mesh's own file, y up. Corners carry UVs (`st`)
and shading normals, vertices stay whole; each part is a `GeomSubset` with a material of its name. The material is a
UsdPreviewSurface; it has no place for what happens below the surface. Its relief is shown once: by the normal map, or, in the
other variant of the set `relief`, by displacement. A `.usdz` is one file with the pictures inside, without the height, which
viewers of such files have no use for.
"""

import struct
import zipfile
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError, WorkError
from surftex.files.glb import far_origin
from surftex.files.naming import own_identifier
from surftex.surface.surface import Surface
from surftex.surface.weld import equal_rows
from surftex.units import MM_PER_UNIT

FORMATS = ("usda", "usdc", "usdz")
"""Text, binary, and one file with everything inside."""

_WIRES = {
    "base_color": ("diffuseColor", "Color3f", "rgb"),
    "specular": ("ior", "Float", "r"),
    "roughness": ("roughness", "Float", "r"),
    "metallic": ("metallic", "Float", "r"),
    "ambient_occlusion": ("occlusion", "Float", "r"),
    "normal": ("normal", "Normal3f", "rgb"),
    "height": ("displacement", "Float", "r"),
}
"""Maps that a UsdPreviewSurface has a use for: its input, and what it takes of the picture."""

_IOR = (0.68, 1.16)
"""Scale and bias from `specular`, to an index of refraction: F0 is right to 4 % from 0.2 to 0.6, exact at 0.5."""

_RELIEF = ("normal", "height")

_ALIGNED, _HEADER, _FIELD, _PADDING = 64, 30, 4, 0x1986
"""Of a .usdz: the bytes that files start at a multiple of, of a header and of an empty field, and the field that pads."""


def check_usd() -> None:
    """Refuse, before any work, to write USD where its library is missing.

    Raises
    ------
    InputError
        Saying how to install it.
    """
    _library()


def write_usd(
    path: Path,
    surface: Surface,
    corner_uv: NDArray[np.float64],
    pictures: Mapping[str, str],
    *,
    name: str,
) -> None:
    """Write a surface with its maps.

    Parameters
    ----------
    path : Path
        Ends in one of `FORMATS`; beside the pictures.
    surface : Surface
        m faces; the origin that was taken off is added again.
    corner_uv : (m, 3, 2) float64
        The unwrap; v up. Pages of UDIM lie side by side.
    pictures : mapping of str to str
        Files by the name of the map, with ``<UDIM>`` for the page's number where there are several. Maps that
        the material has no use for are left out.
    name : str
        Of the prim.

    Raises
    ------
    InputError
        If the library is missing, or a .usdz is asked for with several pages.
    WorkError
        If the file cannot be written.
    """
    pxr = _library()
    packed = path.suffix == ".usdz"
    known = {
        role: pictures[role] for role in _WIRES if role in pictures and not (packed and role == "height")
    }
    if packed and any("<UDIM>" in file for file in known.values()):
        raise InputError("a .usdz holds no pages of UDIM; write usda or usdc, or bake one page")
    stage = pxr.Usd.Stage.CreateInMemory()
    _describe(pxr, stage, surface, corner_uv, known, name)
    try:
        if packed:
            _pack(path, stage, sorted(known.values()))
        else:
            stage.GetRootLayer().Export(str(path))
    except (OSError, pxr.Tf.ErrorException) as problem:
        raise WorkError(f"{path.name}: cannot write: {str(problem).splitlines()[0]}") from None


def _library() -> Any:
    """Hand out the modules of the library, whose own types are not told."""
    try:
        from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdShade, Vt
    except ImportError:
        raise InputError("USD needs its library; install it with: pip install 'surftex[usd]'") from None
    return SimpleNamespace(
        Gf=Gf, Kind=Kind, Sdf=Sdf, Tf=Tf, Usd=Usd, UsdGeom=UsdGeom, UsdShade=UsdShade, Vt=Vt
    )


def _describe(
    pxr: Any,
    stage: Any,
    surface: Surface,
    corner_uv: NDArray[np.float64],
    pictures: Mapping[str, str],
    name: str,
) -> None:
    """Fill an empty stage."""
    unit_mm = surface.mm_per_unit if surface.mm_per_unit in MM_PER_UNIT.values() else 1.0
    pxr.UsdGeom.SetStageMetersPerUnit(stage, unit_mm / 1000)
    pxr.UsdGeom.SetStageUpAxis(stage, pxr.UsdGeom.Tokens.y)
    stage.GetRootLayer().documentation = "surftex"
    own = own_identifier(name, set())
    root = pxr.UsdGeom.Xform.Define(stage, f"/{own}")
    stage.SetDefaultPrim(root.GetPrim())
    pxr.Usd.ModelAPI(root).SetKind(pxr.Kind.Tokens.component)
    mesh = pxr.UsdGeom.Mesh.Define(stage, root.GetPath().AppendChild(own))
    _shape(pxr, mesh, surface, corner_uv, unit_mm)

    slots, taken = surface.slot_names(name), {own}
    place = root.GetPath().AppendChild(own_identifier("materials", taken))
    pxr.UsdGeom.Scope.Define(stage, place)
    binding = pxr.UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    networks, taken = [], set()
    for part, text in slots.items():
        label = own_identifier(text, taken)
        material = pxr.UsdShade.Material.Define(stage, place.AppendChild(label))
        material.GetPrim().SetDisplayName(text)
        networks.append((material, *_network(pxr, stage, material, pictures, 1 / unit_mm)))
        if len(slots) == 1:
            binding.Bind(material)
            continue
        face = np.flatnonzero(surface.part == part).astype(np.int32)
        subset = binding.CreateMaterialBindSubset(label, _array(pxr.Vt.IntArray, face))
        pxr.UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
    if len(slots) > 1:
        binding.SetMaterialBindSubsetsFamilyType(pxr.UsdGeom.Tokens.partition)
    _show_relief(pxr, root.GetPrim(), networks)


def _shape(pxr: Any, mesh: Any, surface: Surface, corner_uv: NDArray[np.float64], unit_mm: float) -> None:
    """Describe triangles, UVs and normals."""
    far = far_origin(surface)
    points = (surface.vertices if far else surface.vertices + surface.origin_mm) / unit_mm
    points = _array(pxr.Vt.Vec3fArray, points.astype(np.float32))
    mesh.CreatePointsAttr(points)
    mesh.CreateExtentAttr(pxr.UsdGeom.PointBased.ComputeExtent(points))
    mesh.CreateFaceVertexCountsAttr(_array(pxr.Vt.IntArray, np.full(len(surface.faces), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(_array(pxr.Vt.IntArray, surface.faces.ravel()))
    mesh.CreateSubdivisionSchemeAttr(pxr.UsdGeom.Tokens.none)
    mesh.CreateOrientationAttr(pxr.UsdGeom.Tokens.rightHanded)
    if far:
        mesh.AddTranslateOp().Set(pxr.Gf.Vec3d(*(surface.origin_mm / unit_mm).tolist()))
    types = pxr.Sdf.ValueTypeNames
    for key, type_, array, values in (
        ("st", types.TexCoord2fArray, pxr.Vt.Vec2fArray, corner_uv),
        ("normals", types.Normal3fArray, pxr.Vt.Vec3fArray, surface.shading_normal),
    ):
        rows = values.reshape(-1, values.shape[-1]).astype(np.float32)
        number = equal_rows(rows)
        first = np.unique(number, return_index=True)[1]
        primvar = pxr.UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(key, type_, pxr.UsdGeom.Tokens.faceVarying)
        primvar.Set(_array(array, rows[first]))
        primvar.SetIndices(_array(pxr.Vt.IntArray, number.astype(np.int32)))


def _network(
    pxr: Any, stage: Any, material: Any, pictures: Mapping[str, str], unit_per_mm: float
) -> tuple[Any, dict[str, Any]]:
    """Make the shader of a material and its pictures, and wire all but the relief; the shader, and each picture's output."""
    types = pxr.Sdf.ValueTypeNames

    def node(label: str, kind: str) -> Any:
        made = pxr.UsdShade.Shader.Define(stage, material.GetPath().AppendChild(label))
        made.CreateIdAttr(kind)
        return made

    surface = node("surface", "UsdPreviewSurface")
    surface.CreateInput("ior", types.Float).Set(1.5)
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    place = node("place", "UsdPrimvarReader_float2")
    place.CreateInput("varname", types.String).Set("st")
    st = place.CreateOutput("result", types.Float2)
    scales = {"normal": (2.0, -1.0), "specular": _IOR, "height": (unit_per_mm, 0.0)}
    outputs = {}
    for role, file in pictures.items():
        key, type_, channel = _WIRES[role]
        picture = node(role, "UsdUVTexture")
        picture.CreateInput("file", types.Asset).Set(pxr.Sdf.AssetPath(f"./{file}"))
        colour = "sRGB" if role == "base_color" else "raw"
        picture.CreateInput("sourceColorSpace", types.Token).Set(colour)
        picture.CreateInput("st", types.Float2).ConnectToSource(st)
        for axis in ("wrapS", "wrapT"):
            picture.CreateInput(axis, types.Token).Set("clamp")
        if role in scales:
            scale, bias = scales[role]
            picture.CreateInput("scale", types.Float4).Set(pxr.Gf.Vec4f(scale, scale, scale, 1))
            picture.CreateInput("bias", types.Float4).Set(pxr.Gf.Vec4f(bias, bias, bias, 0))
        outputs[role] = picture.CreateOutput(channel, types.Float3 if channel == "rgb" else types.Float)
        if role not in _RELIEF:
            surface.CreateInput(key, getattr(types, type_)).ConnectToSource(outputs[role])
    return surface, outputs


def _show_relief(pxr: Any, root: Any, networks: list[tuple[Any, Any, dict[str, Any]]]) -> None:
    """Wire normal map and height: each in a variant of its own where there are both, the normal map first."""
    reliefs = [role for role in _RELIEF if role in networks[0][2]]
    choice = root.GetVariantSets().AddVariantSet("relief") if len(reliefs) > 1 else None
    for role in reliefs:
        key, type_, _ = _WIRES[role]
        if choice is not None:
            choice.AddVariant(key)
            choice.SetVariantSelection(key)
        with nullcontext() if choice is None else choice.GetVariantEditContext():
            for material, surface, outputs in networks:
                inlet = surface.CreateInput(key, getattr(pxr.Sdf.ValueTypeNames, type_))
                inlet.ConnectToSource(outputs[role])
                if role == "height":
                    material.CreateDisplacementOutput().ConnectToSource(surface.ConnectableAPI(), key)
    if choice is not None:
        choice.SetVariantSelection(_WIRES[reliefs[0]][0])


def _pack(path: Path, stage: Any, pictures: list[str]) -> None:
    """Write a package: not compressed, each file on a boundary, no time of day."""
    draft = path.with_suffix(".usdc")
    try:
        stage.GetRootLayer().Export(str(draft))
        with zipfile.ZipFile(path, "w") as package:
            for file in (draft.name, *pictures):
                entry = zipfile.ZipInfo(file)
                room = -(package.start_dir + _HEADER + len(file.encode())) % _ALIGNED
                room += _ALIGNED if 0 < room < _FIELD else 0
                if room:
                    entry.extra = struct.pack("<HH", _PADDING, room - _FIELD) + bytes(room - _FIELD)
                package.writestr(entry, (path.parent / file).read_bytes())
    finally:
        draft.unlink(missing_ok=True)


def _array(kind: Any, values: NDArray[Any]) -> Any:
    return kind.FromNumpy(np.ascontiguousarray(values))
