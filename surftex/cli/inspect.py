"""``surftex inspect``: what a mesh is, what is wrong with it, what a bake would cost."""

import json
from argparse import Namespace
from typing import Any

from surftex.cli.say import one_line, out
from surftex.words import by_count, plain

_USUAL = "calf"
"""What the cost is of, unless told."""

_ONE = {"cells": "a cell", "pixels": "two pixels", "furrows": "a furrow"}


def run(options: Namespace) -> None:
    """Load a mesh and describe it.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If there is no surface in the file, or no such material.
    """
    from surftex.bake.cost import bake_cost
    from surftex.bake.loading import load
    from surftex.bake.scales import scale_report
    from surftex.bake.unwrapping import own_uv_plan
    from surftex.recipe.compose import composed
    from surftex.recipe.read import recipe_for
    from surftex.surface.inspect import describe

    material = options.material or _USUAL
    scale = {key: getattr(options, key) for key in ("units", "size", "part", "crease")}
    recipe = composed(recipe_for(material, allow_outside=options.allow_outside), options.subject, scale)
    mesh = recipe.mesh
    surface = load(options.subject, units=mesh.units, size=mesh.size, part=mesh.part, crease=mesh.crease)
    facts = describe(surface).as_dict()
    facts["own_uv"]["plan"] = own_uv_plan(surface, recipe.bake)
    cost = bake_cost(surface, material, recipe)
    told = [recipe] if options.material else [recipe_for("skin"), recipe]
    scales = scale_report(surface, *told)
    under = material if options.material else "skin or leather"
    if options.json:
        out(json.dumps({**facts, "scales": scales, "cost": cost}, indent=1, ensure_ascii=False))
        return
    out("\n".join(one_line(row) for row in [*_rows(facts, cost), *_scales(scales, under)]))


def _rows(facts: dict[str, Any], cost: dict[str, Any]) -> list[str]:
    size = " x ".join(plain(side, 4) for side in facts["size_mm"])
    spans = ", ".join(
        f"{axis} {plain(low, 4)} to {plain(high, 4)}" for axis, (low, high) in facts["span_mm"].items()
    )
    volume = "" if facts["volume_mm3"] is None else f"; volume: {plain(facts['volume_mm3'], 6)} mm^3"
    edges = ", ".join(f"{name} {plain(length)}" for name, length in facts["edge_length_mm"].items())
    borders = f"{facts['border_loops']} ({plain(facts['border_length_mm'], 4)} mm)"
    rows = [
        f"{facts['name']}: {by_count(facts['faces'], '{:,} face', '{:,} faces')}, "
        f"{by_count(facts['vertices'], '{:,} vertex', '{:,} vertices')}, {size} mm",
        f"spans {spans} mm in the file",
        f"unit of the file: {_unit(facts['mm_per_unit'])}",
        f"area: {plain(facts['area_mm2'], 6)} mm^2{volume}",
        f"components: {facts['components']} ({facts['closed_components']} closed); borders: {borders}; "
        f"genus: {facts['genus']}",
        f"edges: {edges} mm",
        f"smallest angle: {facts['smallest_angle_degrees']:.3g} degrees; slivers: {facts['slivers']:,}",
        *_own_uv(facts["own_uv"]),
        f"own normals: {'yes' if facts['own_normals'] else 'no'}",
    ]
    rows += [
        f"part {part['name']!r}: {by_count(part['faces'], '{:,} face', '{:,} faces')}, {plain(part['area_mm2'], 5)} mm^2"
        for part in facts["parts"]
    ]
    many = [
        by_count(count, f"about {{:,}} {kind}", f"about {{:,}} {kind}s")
        for kind, count in cost["placed"].items()
    ]
    threads = by_count(cost["threads"], "{:,} thread", "{:,} threads")
    rows.append(f"a bake of {cost['material']}: {', '.join([*many, f'on {threads}'])}")
    rows += [_page(page, cost["made_of"]) for page in cost["pages"]]
    rows += _finest(cost)
    if cost["refused"]:
        rows.append(f"  that bake would be refused: {cost['refused']}")
    rows += [f"  warning: {warning}" for warning in cost["warnings"]]
    rows += [f"warning: {warning}" for warning in facts["warnings"]]
    return rows


def _scales(scales: dict[str, Any], under: str) -> list[str]:
    mesh = scales["mesh_mm"]
    told = "none, or not measured" if mesh is None else f"about {plain(mesh)} mm"
    rows = [f"finest relief of the mesh: {told}"]
    return [*rows, f"  under {under}: {scales['note']}"] if scales["note"] else rows


def _finest(cost: dict[str, Any]) -> list[str]:
    """Say what a page must show, and which would."""
    if cost["finest"] is None:
        return ["  finest of the material: not known before a bake"]
    rows = []
    for i, each in enumerate(cost["advice"], 1):
        side, density = each["resolution"], each["texels_per_mm"]
        would = f"--resolution {side}" if side else f"--udim --texels-per-mm {density:g}"
        role = "finest of the material:" if i == len(cost["advice"]) else "made of"
        rows.append(f"  {role} {each['kind']} of {plain(each['mm'], 4)} mm; {would} shows them well")
    return rows


def _page(page: dict[str, Any], made_of: str | None) -> str:
    side = f"{page['resolution']:>5} x {page['resolution']:<5}"
    density = f"{page['texels_per_mm']:8.3g} texels/mm"
    if page["texels_per_cell"] is not None:
        density += f" {page['texels_per_cell']:8.3g} across {_ONE.get(str(made_of), made_of)}"
    disk = f", and {page['disk_mb']:,.0f} MB in temporary files" if page["disk_mb"] else ""
    return f"  {side} {density}   about {page['seconds']:.0f} s, {page['memory_mb']:,.0f} MB{disk}"


def _unit(mm_per_unit: float) -> str:
    """Name a unit; what scales a mesh to a size has no name."""
    from surftex.units import MM_PER_UNIT

    names = {"um": "micrometres", "mm": "millimetres", "cm": "centimetres", "m": "metres", "in": "inches"}
    for unit, name in names.items():
        if abs(mm_per_unit / MM_PER_UNIT[unit] - 1) < 1e-9:
            return name
    return f"{mm_per_unit:.6g} mm"


def _own_uv(facts: dict[str, Any]) -> list[str]:
    """Describe UVs, and what a bake makes of them."""
    rest = (
        f"{key.replace('_', ' ')} {_short(value)}"
        for key, value in facts.items()
        if key not in ("state", "plan")
    )
    rows = ["; ".join([f"own UVs: {facts['state']}", *rest])]
    plan = facts["plan"]
    if plan is None:
        return rows
    if plan["auto"] == "keep":
        rows.append("  a bake keeps them")
    else:
        insist = "keeps them all the same, with a warning" if plan["keep"] == "keep" else "is refused"
        rows.append(f"  a bake unwraps anew: {'; '.join(plan['why'])}; --uv keep {insist}")
    return [*rows, *([f"  {plan['mirrored']}"] if plan["mirrored"] and plan["keep"] == "keep" else [])]


def _short(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_short, value)) + "]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
