"""MaterialX: a standard surface wired to the maps of a bake, for Arnold, Karma, RenderMan, Maya and whatever else reads it.

One network and, for each part of the mesh, two materials that use it: one of the part's name, which shows the relief by its
normals, and one that ends in ``_displaced``, which shows it by displacement. Pictures are named relative to the file. Colour is
sRGB, all else is read as numbers. `specular` is F0 / 0.08 and becomes the index of refraction with that F0. Heights and radii
are millimetres in their files, and metres, like the GLB, where they enter a shader: in a scene with another unit, change the
inputs `scale` and `subsurface_scale`.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence

from surftex.files.naming import own_identifier

METRES_PER_MM = 0.001

_WIRES = {
    "base_color": ("base_color", "color3"),
    "roughness": ("specular_roughness", "float"),
    "metallic": ("metalness", "float"),
    "subsurface": ("subsurface", "float"),
}
"""Maps that enter the shader as they are: its input, and its type."""

_TYPES = {
    "base_color": "color3", "roughness": "float", "metallic": "float", "specular": "float", "normal": "vector3",
    "subsurface": "float", "subsurface_radius_mm": "vector3", "height": "float",
}  # fmt: skip
"""Maps that a standard surface has a use for. Radii are a vector, so that nobody takes them for colours."""


def materialx_bytes(
    pictures: Mapping[str, str], materials: Sequence[str], *, name: str, tiles: Sequence[int] = ()
) -> bytes:
    """Write a material and its network.

    Parameters
    ----------
    pictures : mapping of str to str
        Files by the name of the map, relative to that of the material, with ``<UDIM>`` for the page's number where
        there are several. Maps that a standard surface has no use for are left out.
    materials : sequence of str
        Names of the parts of the mesh: a material each.
    name : str
        Start of the names of nodes.
    tiles : sequence of int
        Numbers of the pages, where there are several.

    Returns
    -------
    data : bytes
        XML, version 1.38 of the format, which later readers take too.
    """
    stem = own_identifier(name, set())
    document = ET.Element("materialx", version="1.38", colorspace="lin_rec709")
    if tiles:
        about = ET.SubElement(document, "geominfo", name="pages", geom="*")
        numbers = ", ".join(map(str, tiles))
        ET.SubElement(about, "geomprop", name="udimset", type="stringarray", value=numbers)
    graph = ET.SubElement(document, "nodegraph", name=f"{stem}_maps")
    known = [role for role in _TYPES if role in pictures]
    for role in known:
        _image(graph, role, pictures[role])
    inlets = _inlets(graph, known)
    smooth = {key: type_ for key, type_ in inlets.items() if key not in ("normal", "displacement")}
    looks: dict[str, dict[str, str]] = {}
    if "normal" in known or "height" not in known:
        looks[""] = {
            "surfaceshader": _shader(
                document, graph, f"{stem}_surface", {**smooth, **_only(inlets, "normal")}
            )
        }
    if "height" in known:
        relief = _node(document, "displacement", f"{stem}_relief", "displacementshader")
        _enter(relief, graph, _only(inlets, "displacement"))
        _value(relief, "scale", "float", METRES_PER_MM)
        looks["_displaced" if looks else ""] = {
            "surfaceshader": _shader(document, graph, f"{stem}_smooth", smooth),
            "displacementshader": relief.attrib["name"],
        }
    taken = {each.attrib["name"] for each in document}
    for suffix, shaders in looks.items():
        for material in materials:
            shown = _node(document, "surfacematerial", own_identifier(material + suffix, taken), "material")
            for kind, shader in shaders.items():
                _connect(shown, kind, kind, shader)
    ET.indent(document)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(document, "utf-8") + b"\n"


def _inlets(graph: ET.Element, known: Sequence[str]) -> dict[str, str]:
    """Lead the maps out of the graph; the type of each by the input that it is for."""
    nodes = {_WIRES[role][0]: (_WIRES[role][1], role) for role in known if role in _WIRES}
    if "specular" in known:
        nodes["specular_IOR"] = "float", _index_of_refraction(graph)
    if "subsurface" in known and "base_color" in known:
        nodes["subsurface_color"] = "color3", "base_color"
    if "subsurface_radius_mm" in known:
        _connect(_node(graph, "convert", "radius", "color3"), "in", "vector3", "subsurface_radius_mm")
        nodes["subsurface_radius"] = "color3", "radius"
    if "normal" in known:
        _connect(_node(graph, "normalmap", "normal_in_space", "vector3"), "in", "vector3", "normal")
        nodes["normal"] = "vector3", "normal_in_space"
    if "height" in known:
        nodes["displacement"] = "float", "height"
    for key, (type_, node) in nodes.items():
        ET.SubElement(graph, "output", name=f"{key}_out", type=type_, nodename=node)
    return {key: type_ for key, (type_, _) in nodes.items()}


def _shader(document: ET.Element, graph: ET.Element, name: str, inlets: Mapping[str, str]) -> str:
    """Make a standard surface; its name."""
    surface = _node(document, "standard_surface", name, "surfaceshader", base=1.0)
    if "specular_roughness" not in inlets:
        _value(surface, "specular_roughness", "float", 0.5)
    if "subsurface" in inlets:
        _value(surface, "subsurface_scale", "float", METRES_PER_MM)
    _enter(surface, graph, inlets)
    return name


def _enter(shader: ET.Element, graph: ET.Element, inlets: Mapping[str, str]) -> None:
    """Feed inputs of a shader from the graph."""
    for key, type_ in inlets.items():
        where = {"nodegraph": graph.attrib["name"], "output": f"{key}_out"}
        ET.SubElement(shader, "input", {"name": key, "type": type_, **where})


def _only(inlets: Mapping[str, str], key: str) -> dict[str, str]:
    return {key: inlets[key]} if key in inlets else {}


def _image(graph: ET.Element, role: str, file: str) -> None:
    """Read a picture. The page does not repeat."""
    node = _node(graph, "image", role, _TYPES[role])
    picture = ET.SubElement(node, "input", name="file", type="filename", value=file)
    if role == "base_color":
        picture.set("colorspace", "srgb_texture")
    for axis in ("uaddressmode", "vaddressmode"):
        ET.SubElement(node, "input", name=axis, type="string", value="clamp")


def _index_of_refraction(graph: ET.Element) -> str:
    """Compute (1 + r) / (1 - r), where r squared is F0; the node that has it."""
    _value(
        _connect(_node(graph, "multiply", "f0", "float"), "in1", "float", "specular"), "in2", "float", 0.08
    )
    _connect(_node(graph, "sqrt", "reflected", "float"), "in", "float", "f0")
    _connect(_node(graph, "add", "above", "float", in1=1.0), "in2", "float", "reflected")
    _connect(_node(graph, "subtract", "below", "float", in1=1.0), "in2", "float", "reflected")
    ratio = _node(graph, "divide", "ior", "float")
    _connect(_connect(ratio, "in1", "float", "above"), "in2", "float", "below")
    return "ior"


def _node(parent: ET.Element, kind: str, name: str, type_: str, **values: float) -> ET.Element:
    node = ET.SubElement(parent, kind, name=name, type=type_)
    for key, value in values.items():
        _value(node, key, "float", value)
    return node


def _value(node: ET.Element, key: str, type_: str, value: float) -> None:
    ET.SubElement(node, "input", name=key, type=type_, value=f"{value:g}")


def _connect(node: ET.Element, key: str, type_: str, source: str) -> ET.Element:
    """Feed an input from a node beside; hand the node back."""
    ET.SubElement(node, "input", name=key, type=type_, nodename=source)
    return node
