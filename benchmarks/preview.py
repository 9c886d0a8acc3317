"""What a change costs in the preview at 1024 x 1024: `python -m benchmarks.preview`; CPU time of all threads."""

import time
from pathlib import Path

from surftex.files.meshes import load
from surftex.preview.live import Live
from surftex.preview.session import Session
from surftex.recipe.read import recipe_for

MESHES = Path(__file__).resolve().parent.parent / "meshes"
CHANGES = {
    ("shoe.obj", "90 mm", "calf"): (
        ("sulcus_depth", 0.05), ("sulcus_width", 0.17), ("crista_height", 0.08), ("color", [0.2, 0.1, 0.1]),
        ("waviness", 0.12), ("cell_size", 1.0),
    ),
    ("torus.obj", "60 mm", "milled"): (("relief", 0.12), ("wrinkle_width", 1.2), ("taper", 0.5)),
    ("head.ply", "280 mm", "skin"): (("relief_depth", 0.06), ("relief_width", 0.14), ("pore_depth", [0.02, 0.06])),
}  # fmt: skip


def timed(work):
    start, cpu = time.perf_counter(), time.process_time()
    result = work()
    return result, time.perf_counter() - start, time.process_time() - cpu


def main() -> None:
    for (mesh, size, material), changes in CHANGES.items():
        surface, recipe = load(MESHES / mesh, size=size), recipe_for(material)
        session, live = Session(recipe, surface), Live(surface, recipe)
        _, wall, cpu = timed(lambda live=live, session=session: live.draw(session.recipe))
        print(
            f"{mesh} {size} {material}, {len(live.texels):,} texels: first {cpu:.2f} s CPU, {wall:.2f} s wall"
        )
        session.set(*changes[0])
        live.draw(session.recipe)  # the kernels are compiled by now
        session.undo()
        live.draw(session.recipe)
        for key, value in changes:
            session.set(key, value)
            if live.effort(session.recipe) == "placed":
                place = surface.vertices[surface.faces[0, 0]]
                look, wall, cpu = timed(lambda: live.first_look(session.recipe, place))  # noqa: B023
                if look is not None:
                    print(f"  {key:16} first look  {1000 * cpu:6.0f} ms CPU {1000 * wall:6.0f} ms wall")
            frame, wall, cpu = timed(lambda: live.draw(session.recipe))  # noqa: B023
            print(f"  {key:16} {frame.effort:10}  {1000 * cpu:6.0f} ms CPU {1000 * wall:6.0f} ms wall")
        session.close()


if __name__ == "__main__":
    main()
