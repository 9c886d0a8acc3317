"""MaterialX and USD by their own libraries: sound, complete, and every map where it belongs."""

import sys
import zipfile

import numpy as np
import pytest

from surftex.charts.atlas import Atlas
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError
from surftex.maps.mapset import MapSet
from surftex.maps.normal import surface_tangents
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface

NAMES = (
    "base_color", "roughness", "metallic", "specular", "subsurface", "subsurface_radius_mm", "normal", "height",
    "ambient_occlusion", "region",
)  # fmt: skip


def picture(name, side=16):
    random = np.random.RandomState(len(name))
    if name == "region":
        return random.randint(-1, 5, (side, side))
    if name == "normal":
        return np.broadcast_to([0.0, 0.6, 0.8], (side, side, 3))
    colour = (3,) if name in ("base_color", "subsurface_radius_mm") else ()
    return random.uniform(0.1, 0.9, (side, side, *colour)).astype(np.float32)


def parted(names=NAMES, *, mm_per_unit=10.0, origin_mm=(1.0, 2.0, 3.0), part_names=("2 über", "2-über")):
    """A ball of two parts whose names differ in nothing that an identifier may hold."""
    ball = sphere(20.0, subdivisions=2)
    part = (ball.vertices[ball.faces][..., 2].mean(axis=1) < 0).astype(int)
    ball = Surface.from_arrays(
        ball.vertices, ball.faces, part=part if len(part_names) > 1 else None, part_names=part_names,
        origin_mm=origin_mm, mm_per_unit=mm_per_unit,
    )  # fmt: skip
    atlas = unwrap(ball, method="uvunwrap", resolution=64)
    maps = {name: picture(name) for name in names}
    return MapSet(maps, ball, atlas, surface_tangents(ball, atlas), stem="my shoe & é")


def paged(names=NAMES):
    """A sheet over two tiles."""
    sheet = plane(cells=2)
    atlas = Atlas.of(sheet, sheet.corner_uv * [2.0, 1.0])
    maps = {f"{name}.{tile}": picture(name) for name in names for tile in (1001, 1002)}
    return MapSet(maps, sheet, atlas, surface_tangents(sheet, atlas), stem="sheet")


def material_of(path):
    """The document, beside the library of nodes."""
    mx = pytest.importorskip("MaterialX")
    library, document = mx.createDocument(), mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    mx.readFromXmlFile(document, str(path))
    document.setDataLibrary(library)
    return document, library


@pytest.mark.parametrize("make", [parted, paged])
def test_materialx_is_valid_and_becomes_shaders(make, tmp_path):
    maps = make()
    maps.save(tmp_path, materialx=True)
    document, library = material_of(tmp_path / f"{maps.stem}.mtlx")
    valid, why = document.validate()
    assert valid, why
    import MaterialX
    from MaterialX import PyMaterialXGenGlsl, PyMaterialXGenOsl, PyMaterialXGenShader

    looks = document.getMaterialNodes()
    parts = ["_2__ber", "_2__ber_1"] if make is parted else ["sheet"]
    shown = [name.replace("ber", "ber_displaced").replace("sheet", "sheet_displaced") for name in parts]
    assert [look.getName() for look in looks] == parts + shown
    for generators in (PyMaterialXGenGlsl.GlslShaderGenerator, PyMaterialXGenOsl.OslShaderGenerator):
        generator = generators.create()
        context = PyMaterialXGenShader.GenContext(generator)
        context.registerSourceCodeSearchPath(MaterialX.getDefaultDataSearchPath())
        colours = PyMaterialXGenShader.DefaultColorManagementSystem.create(generator.getTarget())
        colours.loadLibrary(library)
        generator.setColorManagementSystem(colours)
        for look in looks:
            code = generator.generate(look.getName(), look, context).getSourceCode("pixel")
            assert code.count("srgb_texture_to_lin_rec709") >= 1


def test_materialx_reads_every_map_from_beside_as_what_it_is(tmp_path):
    maps = parted()
    maps.save(tmp_path, materialx=True)
    document, _ = material_of(tmp_path / f"{maps.stem}.mtlx")
    assert document.getColorSpace() == "lin_rec709"
    graph = document.getNodeGraph("my_shoe_____maps")
    images = {node.getName(): node for node in graph.getNodes("image")}
    for name, node in images.items():
        file = node.getInput("file")
        assert (tmp_path / file.getValueString()).is_file()
        assert file.getColorSpace() == ("srgb_texture" if name == "base_color" else "")
        assert node.getType() != "color3" or name == "base_color"  # numbers are nobody's colours
    assert set(images) == set(NAMES) - {"region", "ambient_occlusion"}
    plain, displaced = (
        look for look in document.getMaterialNodes() if look.getName() in ("_2__ber", "_2__ber_displaced")
    )
    shader = plain.getConnectedNode("surfaceshader")
    for key, source in {
        "base_color": "base_color", "specular_roughness": "roughness", "metalness": "metallic",
        "subsurface": "subsurface", "subsurface_color": "base_color", "subsurface_radius": "radius",
        "specular_IOR": "ior", "normal": "normal_in_space",
    }.items():  # fmt: skip
        assert shader.getInput(key).getConnectedOutput().getNodeName() == source, key
    assert plain.getConnectedNode("displacementshader") is None
    assert displaced.getConnectedNode("surfaceshader").getInput("normal") is None
    relief = displaced.getConnectedNode("displacementshader")
    assert relief.getInputValue("scale") == pytest.approx(0.001)  # mm to metres, like the GLB
    assert shader.getInputValue("subsurface_scale") == pytest.approx(0.001)


def test_pages_are_named_by_a_token(tmp_path):
    maps = paged()
    maps.save(tmp_path, materialx=True)
    document, _ = material_of(tmp_path / "sheet.mtlx")
    assert document.getGeomPropValue("udimset").getValueString() == "1001, 1002"
    file = document.getNodeGraph("sheet_maps").getNode("normal").getInputValue("file")
    assert file == "sheet_normal.<UDIM>.png"
    assert all((tmp_path / file.replace("<UDIM>", str(tile))).is_file() for tile in (1001, 1002))


def issues(path):
    """What the library's own validators say."""
    from pxr import Usd, UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 20
    found = UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(str(path)))
    return [(issue.GetName(), issue.GetMessage()) for issue in found]


@pytest.mark.parametrize("kind", ["usda", "usdc", "usdz"])
def test_usd_is_sound_and_the_same_each_time(kind, tmp_path):
    pytest.importorskip("pxr")
    data = []
    for folder in ("a", "b"):
        maps = parted()
        path = tmp_path / folder / f"{maps.stem}.{kind}"
        assert path in maps.save(tmp_path / folder, usd=kind)
        assert issues(path) == []
        data.append(path.read_bytes())
    assert data[0] == data[1]
    assert len(list((tmp_path / "a").iterdir())) == len(maps.file_names) + 1


def test_usd_holds_the_mesh_in_its_own_unit(tmp_path):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom, UsdShade

    maps = parted()
    maps.save(tmp_path, usd="usda")
    stage = Usd.Stage.Open(str(tmp_path / f"{maps.stem}.usda"))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    mesh = next(UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    surface = maps.surface
    points = (surface.vertices + surface.origin_mm) / 10
    np.testing.assert_allclose(mesh.GetPointsAttr().Get(), points, atol=1e-6)
    np.testing.assert_array_equal(mesh.GetFaceVertexIndicesAttr().Get(), surface.faces.ravel())
    corner = UsdGeom.PrimvarsAPI(mesh)
    for key, values in {"st": maps.atlas.corner_uv, "normals": surface.shading_normal}.items():
        primvar = corner.GetPrimvar(key)
        assert primvar.GetInterpolation() == "faceVarying"
        np.testing.assert_allclose(primvar.ComputeFlattened(), values.reshape(-1, values.shape[2]), atol=1e-6)
    subsets = UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
    assert [np.array(each.GetIndicesAttr().Get()).tolist() for each in subsets] == [
        np.flatnonzero(surface.part == part).tolist() for part in (0, 1)
    ]
    bound = [
        UsdShade.MaterialBindingAPI(each.GetPrim()).ComputeBoundMaterial()[0].GetPrim() for each in subsets
    ]
    assert [each.GetDisplayName() for each in bound] == ["2 über", "2-über"]
    assert len({each.GetPath() for each in bound}) == 2


@pytest.mark.parametrize(("make", "unit_mm"), [(parted, 10.0), (paged, 1.0)])
def test_usd_wires_every_map_in_its_colour_space(make, unit_mm, tmp_path):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdShade

    maps = make()
    maps.save(tmp_path, usd="usdc")
    stage = Usd.Stage.Open(str(tmp_path / f"{maps.stem}.usdc"))
    relief = stage.GetDefaultPrim().GetVariantSet("relief")
    assert relief.GetVariantSelection() == "normal"

    def wired():
        """By input of each shader: the picture, its colour space, its scale and bias."""
        result = []
        for prim in stage.Traverse():
            shader = UsdShade.Shader(prim)
            if not shader or shader.GetIdAttr().Get() != "UsdPreviewSurface":
                continue
            seen = {}
            for key in shader.GetInputs():
                if not key.HasConnectedSource():
                    continue
                source = UsdShade.Shader(key.GetConnectedSources()[0][0].source.GetPrim())
                told = {each: source.GetInput(each) for each in ("file", "sourceColorSpace", "scale", "bias")}
                told = {each: value.Get() for each, value in told.items() if value}
                assert (
                    UsdShade.Shader(source.GetInput("st").GetConnectedSources()[0][0].source.GetPrim())
                    .GetInput("varname")
                    .Get()
                    == "st"
                )
                seen[key.GetBaseName()] = told
            result.append(seen)
        return result

    token = ".<UDIM>" if make is paged else ""
    for seen in wired():
        assert set(seen) == {"diffuseColor", "roughness", "metallic", "ior", "occlusion", "normal"}
        assert seen["diffuseColor"]["file"].path == f"./{maps.stem}_base_color{token}.png"
        assert {key: each["sourceColorSpace"] for key, each in seen.items() if key != "diffuseColor"} == {
            key: "raw" for key in seen if key != "diffuseColor"
        }
        assert seen["diffuseColor"]["sourceColorSpace"] == "sRGB"
        assert tuple(seen["normal"]["scale"]) == (2, 2, 2, 1)
        assert tuple(seen["normal"]["bias"]) == (-1, -1, -1, 0)
        scale, bias = (seen["ior"][key][0] for key in ("scale", "bias"))
        specular = np.linspace(0.2, 0.6, 50)
        ior = scale * specular + bias
        np.testing.assert_allclose(((ior - 1) / (ior + 1)) ** 2, 0.08 * specular, rtol=0.041)
    relief.SetVariantSelection("displacement")
    for seen in wired():
        assert "normal" not in seen
        assert seen["displacement"]["scale"][0] == pytest.approx(1 / unit_mm)
        assert seen["displacement"]["file"].path == f"./{maps.stem}_height{token}.exr"


def test_a_far_origin_goes_into_a_transform_and_odd_units_become_millimetres(tmp_path):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    maps = parted(("height",), mm_per_unit=3.7, origin_mm=(5e6, 0.0, 0.0), part_names=("one",))
    maps.save(tmp_path, usd="usda")
    stage = Usd.Stage.Open(str(tmp_path / f"{maps.stem}.usda"))
    assert issues(tmp_path / f"{maps.stem}.usda") == []
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.001
    mesh = next(UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    assert tuple(UsdGeom.XformCache().GetLocalToWorldTransform(mesh.GetPrim()).ExtractTranslation()) == (
        5e6,
        0,
        0,
    )
    assert np.abs(mesh.GetPointsAttr().Get()).max() <= 20.001
    assert not stage.GetDefaultPrim().GetVariantSets().GetNames()


def test_a_package_holds_what_it_shows_and_nothing_else(tmp_path):
    pytest.importorskip("pxr")
    maps = parted()
    maps.save(tmp_path, usd="usdz")
    with zipfile.ZipFile(tmp_path / f"{maps.stem}.usdz") as package:
        inside = package.infolist()
        assert inside[0].filename == f"{maps.stem}.usdc"  # the first is the one that is opened
        kept = ("ambient_occlusion", "base_color", "metallic", "normal", "roughness", "specular")
        assert [each.filename for each in inside[1:]] == [f"{maps.stem}_{name}.png" for name in kept]
        for each in inside:
            assert each.compress_type == zipfile.ZIP_STORED
            start = each.header_offset + 30 + len(each.filename.encode()) + len(each.extra)
            assert start % 64 == 0
            beside = tmp_path / each.filename
            assert not beside.exists() or package.read(each) == beside.read_bytes()
    assert not (tmp_path / f"{maps.stem}.usdc").exists()


def test_what_cannot_be_is_refused_before_anything_is_written(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="usd is 'obj'; it takes usda, usdc, usdz"):
        parted().save(tmp_path / "out", usd="obj")  # type: ignore[arg-type]
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(InputError, match=r"pip install 'surftex\[usd\]'"):
        parted().save(tmp_path / "out", usd="usda")
    assert not (tmp_path / "out").exists()
    monkeypatch.undo()
    pytest.importorskip("pxr")
    with pytest.raises(InputError, match="no pages of UDIM"):
        paged().save(tmp_path / "out", usd="usdz")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("names", [("height",), ("region",), ("base_color",), ("subsurface",)])
def test_few_maps_make_a_sound_material_too(names, tmp_path):
    maps = parted(names)
    maps.save(tmp_path, materialx=True)
    document, _ = material_of(tmp_path / f"{maps.stem}.mtlx")
    assert document.validate()[0]
    looks = document.getMaterialNodes()
    assert len(looks) == 2
    assert (looks[0].getConnectedNode("displacementshader") is not None) == (names == ("height",))
    pytest.importorskip("pxr")
    maps.save(tmp_path, usd="usda", overwrite=True)
    assert issues(tmp_path / f"{maps.stem}.usda") == []
