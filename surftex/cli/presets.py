"""``surftex presets``: what is on the shelf, and one of it as a recipe to start from."""

import json
from argparse import Namespace

from surftex.cli.say import one_line, out


def run(options: Namespace) -> None:
    """List the presets, or print one.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    RecipeError
        If there is no such preset; the message names the nearest.
    """
    from surftex.recipe.layer import all_presets, preset_material

    if options.name is not None:
        from surftex.materials.presets import parameters
        from surftex.recipe.write import starter

        material = preset_material(options.name)
        values = parameters(material, options.name)
        if options.json:
            out(
                json.dumps(
                    {"material": material, "preset": options.name, **values}, indent=1, ensure_ascii=False
                )
            )
        else:
            out(starter(material, options.name, all_presets()[material][options.name], values).rstrip("\n"))
        return
    shelves = all_presets()
    if options.json:
        out(json.dumps(shelves, indent=1, ensure_ascii=False))
        return
    width = max(len(name) for presets in shelves.values() for name in presets)
    rows = []
    for material, presets in shelves.items():
        rows.append(f"{material}:")
        rows += [f"  {name:<{width}}  {one_line(caption)}" for name, caption in presets.items()]
    out("\n".join(rows))
