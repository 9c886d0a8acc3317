"""Writes which kernels a bake compiles, and for what types: `python -m docs.make_signatures`.

Small bakes of every kind of material are run, each kind in a process of its own; what they call is noted in the order
in which it is first called. A test compares the list with what this writes.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from numba.core import types
from numba.core.dispatcher import Dispatcher

from surftex.kernels.ahead import LIST

ROOT = Path(__file__).resolve().parents[1]
SHOE = ROOT / "meshes" / "shoe.obj"


def written(kind: Any) -> str:
    """A type in numba's own notation."""
    if isinstance(kind, types.Array):
        if not kind.mutable or kind.layout == "F":
            return f"Array({written(kind.dtype)}, {kind.ndim}, {kind.layout!r}, {not kind.mutable})"
        return f"{written(kind.dtype)}[{', '.join([':'] * (kind.ndim - 1) + ['::1' if kind.layout == 'C' else ':'])}]"
    if isinstance(kind, types.BaseTuple):
        parts = "".join(f"{written(each)}, " for each in kind.types)
        named = isinstance(kind, types.BaseNamedTuple)
        return f"NamedTuple(({parts}), {kind.instance_class.__name__})" if named else f"Tuple(({parts}))"
    return "boolean" if isinstance(kind, types.Boolean) else str(kind)


def leather() -> None:
    """Elements on a closed surface and on one with borders; a mesh with UVs of its own; all files."""
    import surftex as sx
    from surftex.surface.shapes import cylinder, sphere

    tube, ball = cylinder(6.0, 12.0, columns=24, rows=12), sphere(6.0, subdivisions=2)
    everything = {"cell_size": 2.0, "wrinkle_count": 3, "pore_density": 1.0, "pocket_depth": 0.01, "crown_spacing": 5.0,
                  "regularity": 1}  # fmt: skip
    shoe = sx.load(SHOE, units="mm")
    with tempfile.TemporaryDirectory() as folder:
        sx.bake(shoe, sx.Leather.preset("calf", cell_size=12.0), resolution=256).save(Path(folder) / "shoe")
    sx.bake(tube, sx.Leather.preset("calf", **everything), resolution=64, unwrapper="uvunwrap")
    sx.bake(tube, sx.Leather.preset("calf", invasion=0.3, **everything), resolution=64, unwrapper="uvunwrap")
    crocodile = sx.Leather.preset("crocodile", cell_size=4.0)
    sx.bake(ball, crocodile, resolution=64, unwrapper="uvunwrap", maps="height,region")


def cells() -> None:
    """Grown particles on a surface, and on a square that repeats."""
    import surftex as sx
    from surftex.surface.shapes import cylinder

    grown = sx.Cells.preset("oriented", cell_size=2.0, generations=30, wrinkle_count=2, attraction=0.1)
    sx.bake(cylinder(6.0, 12.0, columns=24, rows=12), grown, resolution=64)
    grown.tile(24.0).page(16)


def composite() -> None:
    """A texture learnt from a photograph."""
    import surftex as sx
    from surftex.surface.shapes import sphere

    learnt = sx.Composite.preset("gravel", pixel_size=1.5, sweeps=2)
    sx.bake(sphere(6.0, subdivisions=2), learnt, resolution=64)


def skin() -> None:
    """Skin on a head."""
    import surftex as sx

    head = sx.load(SHOE.with_name("head.ply"), units="mm")
    sx.bake(head, sx.Skin.preset("skin"), resolution=128)


KINDS = {make.__name__: make for make in (leather, cells, composite, skin)}


def note(kind: str) -> list[str] | None:
    """Run one kind's bakes here, and tell what they called; None if a kernel had to be compiled.

    A kernel that is compiled takes other kernels with it, which a kernel that is loaded does not.
    """
    seen: dict[str, Any] = {}
    usual = Dispatcher.compile

    def noted(self: Any, signature: Any) -> Any:
        function = self.py_func
        if function.__module__.startswith("surftex.kernels."):
            arguments = signature if isinstance(signature, tuple) else signature.args
            name = f"{function.__module__.removeprefix('surftex.kernels.')}.{function.__name__}"
            seen.setdefault(f"{name} ({''.join(f'{written(each)}, ' for each in arguments)})", self)
        return usual(self, signature)

    Dispatcher.compile = noted
    KINDS[kind]()
    return None if any(kernel.stats.cache_misses for kernel in seen.values()) else list(seen)


def called(kind: str) -> list[str]:
    """What one kind's bakes call, in the order of the first call."""
    command = [sys.executable, "-m", "docs.make_signatures", kind]
    for _ in range(2):
        rows = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True, cwd=ROOT).stdout)
        if rows is not None:
            return rows
    raise SystemExit(
        "kernels are compiled, but not kept: set NUMBA_CACHE_DIR to a folder that can be written"
    )


def made() -> str:
    """The list: a row for each, with the kinds of material that want it."""
    wanted: dict[str, list[str]] = {}
    for kind in KINDS:
        for row in called(kind):
            wanted.setdefault(row, []).append(kind)
    return "".join(f"{','.join(kinds)} {row}\n" for row, kinds in wanted.items())


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(note(sys.argv[1])))
    else:
        LIST.write_text(made(), "utf-8")
