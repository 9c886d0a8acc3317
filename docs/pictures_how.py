"""Makes the pictures of `docs/how-it-works.md` and `docs/preview.md`: `python -m docs.pictures_how [NAME ...]`."""

import asyncio
import io
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

import surftex as sx
from docs.make_pictures import MESHES, save
from surftex.charts.texels import texels
from surftex.files.meshes import load
from surftex.preview.render import render
from surftex.preview.sheet import contact_sheet
from surftex.surface.closest import closest_points

SIZE = (460, 400)


def banded(distance_mm, step_mm):
    """Colours of distance in bands."""
    share = np.clip(distance_mm / (step_mm * 12), 0, 1)[..., None]
    near, far = np.array([0.75, 0.30, 0.08]), np.array([0.04, 0.10, 0.26])
    line = 0.55 + 0.45 * ((distance_mm / step_mm) % 1 > 0.12)[..., None]
    return ((near * (1 - share) + far * share) * line).astype(np.float32)


def how_distance():
    """Distance through space and along the surface, from one end of a strap, in bands of 8 mm."""
    surface = load(MESHES / "watch_strap.obj", units="mm")
    maps = sx.bake(
        surface, sx.Leather.preset("calf"), resolution=512, maps="base_color,roughness,normal,height"
    )
    page = texels(surface, maps.atlas, 512)
    parts = np.bincount(surface.component, minlength=int(surface.component.max()) + 1)
    strap = np.unique(surface.faces[surface.component == parts.argmax()])
    end = strap[surface.vertices[strap, 1].argmax()]
    source, _ = closest_points(surface, surface.vertices[[end]])
    place = page.points.positions(surface)
    straight = np.linalg.norm(place - source.positions(surface)[0], axis=1)
    walked = sx.geodesic_distance(surface, source, page.points)
    pictures = []
    flat = np.broadcast_to(np.array([0, 0, 1], np.float32), maps["normal"].shape)
    for distance in (straight, np.where(np.isfinite(walked), walked, 1e3)):
        color = page.image(banded(distance, 8.0))
        shown = {"base_color": color, "roughness": np.full(color.shape[:2], 0.7, np.float32), "normal": flat}
        pictures.append(render(replace(maps, maps=shown), size=SIZE, view=(60.0, 35.0)))
    save(contact_sheet(pictures, ["through space", "along the surface"], columns=2), "how-distance")


def how_gutter():
    """A page near a seam: what the surface shows, and the gutter that goes on with what lies beyond the cut."""
    surface = load(MESHES / "torus.obj", size="60 mm")
    leather = sx.Leather.preset("goat", cell_size="9 mm", sulcus_width="1.5 mm")
    maps = sx.bake(surface, leather, resolution=256, maps="base_color,roughness,normal,height")
    page = texels(surface, maps.atlas, 256)
    inside = np.zeros(256 * 256, bool)
    inside[page.texel[page.core]] = True
    mapped = page.mapped
    inside = inside.reshape(256, 256)
    height = maps["height"]
    grey = np.clip((height - height.min()) / np.ptp(height), 0, 1)
    bare = np.where(inside, grey, 1.0)
    kept = np.where(mapped, grey, 1.0)
    border = inside & ~np.roll(inside, 1, 0) | inside & ~np.roll(inside, 1, 1)
    column, row = np.argwhere(border)[len(np.argwhere(border)) // 2][::-1]
    first = int(np.clip(row - 24, 0, 208)), int(np.clip(column - 24, 0, 208))
    cut = slice(first[0], first[0] + 48), slice(first[1], first[1] + 48)
    panels = []
    for image in (bare, kept, grey):
        part = np.kron(image[cut], np.ones((9, 9)))
        panels.append((255 * part).astype(np.uint8))
    labels = ["the chart alone", "with its gutter", "the page as baked"]
    save(contact_sheet(panels, labels, columns=3), "how-gutter")


def how_normal():
    """The same relief as the normals tell it, studio and raking, and cut along a line."""
    surface = load(MESHES / "torus.obj", size="60 mm")
    maps = sx.bake(surface, sx.Leather.preset("cattle-pebbled", cell_size="3 mm"), resolution=1024)
    pictures = [render(maps, size=SIZE, light=light, zoom=2.2, floor=False) for light in ("studio", "raking")]
    save(contact_sheet(pictures, ["studio", "raking"], columns=2), "how-normal")


def desk_of(mesh, size, material, **settings):
    """A desk with its first frame drawn."""
    from surftex.preview.desk import Desk
    from surftex.recipe.read import recipe_for

    changes = [f"{key}={value}" for key, value in settings.items()]
    desk = Desk(recipe_for(material, changes=changes), load(MESHES / mesh, size=size), resolution=1024)
    desk.worker.wait()
    return desk


def preview_window():
    """The window: a shoe in calf, a section across its vamp."""
    from surftex.preview.window import Window

    desk = desk_of("shoe.obj", "90 mm", "calf")
    window = Window(desk, (1280, 800), off_screen=True)
    desk.choose(tool="section")
    window.picture()
    for x, y in ((620, 430), (760, 560)):
        window.press(x, y)
    desk.choose(group="sulci")
    save(window.picture(smooth=True), "preview-window")
    window.close()
    desk.close()


def preview_overlays():
    """What can be laid over the look: seams, charts, regions, features."""
    from surftex.preview.scene import Scene

    desk = desk_of("torus.obj", "40 mm", "goat", cell_size=2.5)
    scene, pictures = Scene(desk, SIZE), []
    for names in (("seams",), ("charts",), ("regions",), ("features",)):
        for name in names:
            desk.choose(overlay=name)
        pictures.append(scene.picture(smooth=True))
        for name in names:
            desk.choose(overlay=name)
    save(contact_sheet(pictures, ["seams", "charts", "regions", "features"], columns=4), "preview-overlays")
    scene.close()
    desk.close()


def preview_page():
    """The page in Chromium, through its debugging protocol."""
    from surftex.preview.web import Page
    from tests.preview.browser import Browser

    desk = desk_of("torus.obj", "40 mm", "goat", cell_size=1.6)
    page = Page(desk, Path("goat.toml"))

    async def visit():
        told = asyncio.get_running_loop().create_future()
        task = asyncio.create_task(page.run("127.0.0.1", 0, told.set_result, "picture"))
        with tempfile.TemporaryDirectory() as folder:
            async with Browser(Path(folder)) as browser:
                await browser.open(await told)
                await browser.until("document.querySelector('#view')?.naturalWidth > 0")
                await browser.press(*await browser.place("#chip-cristae"))
                await asyncio.sleep(3)
                data = await browser.picture()
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        return data

    save(np.asarray(Image.open(io.BytesIO(asyncio.run(visit()))).convert("RGB")), "preview-page")
    page.scene.close()
    desk.close()


PICTURES = {
    made.__name__.replace("_", "-"): made
    for made in (how_distance, how_gutter, how_normal, preview_window, preview_overlays, preview_page)
}

if __name__ == "__main__":
    for name in sys.argv[1:] or PICTURES:
        began = time.perf_counter()
        PICTURES[name]()
        print(f"{name}: {time.perf_counter() - began:.0f} s", flush=True)
