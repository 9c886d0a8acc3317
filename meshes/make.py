"""Write every mesh of this folder again: `python -m meshes.make [NAME ...]`."""

import sys
from importlib import import_module
from pathlib import Path

FILES = {
    "torus": "torus.obj",
    "bottle": "bottle.glb",
    "cushion": "cushion.obj",
    "shoe": "shoe.obj",
    "head": "head.ply",
    "handbag": "handbag.obj",
    "steering_wheel": "steering_wheel.glb",
    "watch_strap": "watch_strap.obj",
}


def build(name):
    return import_module(f"meshes.{name}").build()


def main(names, folder=Path(__file__).parent):
    from meshes.check import report
    from meshes.model import write

    for name in names or FILES:
        parts = build(name)
        write(Path(folder) / FILES[name], parts)
        size = (Path(folder) / FILES[name]).stat().st_size
        print(name, f"{size / 1000:.0f} kB", [part.name for part in parts], report(parts))


if __name__ == "__main__":
    main(sys.argv[1:])
