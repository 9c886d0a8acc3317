"""The page: nothing without the token, and a slider moved in a real browser changes the picture."""

import asyncio
import os
import signal
import statistics
import subprocess
import sys
import time

import numpy as np
import pytest

from surftex.errors import WorkError
from surftex.preview.desk import Desk
from surftex.recipe.read import recipe_from_text
from surftex.surface.shapes import sphere
from surftex.surface.surface import Surface
from tests.preview.browser import Browser, found

pytest.importorskip("trame", reason="the page needs trame: pip install 'surftex[web]'")

RECIPE = """
surftex = 1
[bake]
unwrapper = "uvunwrap"
[[layer]]
preset = "calf"
cell_size = 2.0
wrinkle_density = 0.0
"""


def opened(folder):
    """A page with its desk, which must be closed."""
    from surftex.preview.web import Page

    desk = Desk(recipe_from_text(RECIPE), sphere(6.0, subdivisions=3), resolution=256)
    assert desk.worker.wait()
    try:
        made = Page(desk, folder / "made.toml")
    except WorkError as problem:
        desk.close()
        pytest.skip(f"nothing to draw on: {problem}")
    yield made
    made.scene.close()
    desk.close()


@pytest.fixture
def page(tmp_path):
    yield from opened(tmp_path)


@pytest.fixture(scope="module")
def idle(tmp_path_factory):
    """A page that nobody visits."""
    yield from opened(tmp_path_factory.mktemp("idle"))


def served(page, visit):
    """Serve a page, and visit it."""

    async def both():
        told = asyncio.get_running_loop().create_future()
        task = asyncio.create_task(page.run("127.0.0.1", 0, told.set_result, "a-token-of-a-test"))
        try:
            return await visit(await asyncio.wait_for(told, 60))
        finally:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    return asyncio.run(both())


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_without_the_token_there_is_nothing(page):
    import aiohttp

    async def visit(address):
        root = address.partition("?")[0]
        async with aiohttp.ClientSession() as stranger:
            for path in ("", "index.html", "ws", "assets/", "?token=", "?token=a-token-of-a-tesu"):
                async with stranger.get(root + path, allow_redirects=False) as answer:
                    assert answer.status == 403, path
                    assert "html" not in await answer.text()
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await stranger.ws_connect(root + "ws")
        async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as friend:
            async with friend.get(address) as answer:
                assert answer.status == 200
                assert "token" not in str(answer.url)
                assert "<html" in (await answer.text()).lower()
            async with friend.get(root + "index.html", headers={"Origin": "http://else.where"}) as answer:
                assert answer.status == 403
            port = root.rstrip("/").rpartition(":")[2]  # another preview of this browser keeps its own
            assert [cookie.key for cookie in friend.cookie_jar] == [f"surftex-{port}"]

    served(page, visit)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_slider_moved_in_a_browser_changes_the_picture(page, tmp_path, capsys):
    if found() is None:
        with capsys.disabled():
            sys.stdout.write("\nNO CHROMIUM HERE: the preview's page was not tried in a browser\n")
        pytest.skip("no chromium: apt-get install chromium")

    async def visit(address):
        async with Browser(tmp_path / "profile") as stranger:
            await stranger.open(address.partition("?")[0])
            await stranger.until("document.body && document.body.textContent.includes('403')")
        async with Browser(tmp_path / "browser") as browser:
            await browser.open(address)
            await browser.until("document.querySelector('#view')?.naturalWidth > 0")
            await browser.press(*await browser.place("#chip-cristae"))
            slider = ".v-slider:has(#slider-crista_height)"
            await browser.until(f"!!document.querySelector('{slider}')")
            await asyncio.sleep(0.5)
            taken = []
            for share in (0.9, 0.2, 0.7, 0.4):
                await browser.ask("window.before = document.querySelector('#view').src")
                start = time.perf_counter()
                await browser.press(*await browser.place(slider, share))
                await browser.until("document.querySelector('#view').src !== window.before")
                taken.append(time.perf_counter() - start)
                height = page.desk.session.value("crista_height")
                top = next(each for each in page.desk.session.controls() if each.key == "crista_height").high
                assert height == pytest.approx(share * top, abs=0.06 * top)
            await browser.press(*await browser.place("#undo"))
            await browser.until("document.querySelector('#message').textContent.length > 0")
            await browser.press(*await browser.place("#save"))
            await browser.until("document.querySelector('#message').textContent.includes('saved')")
            async with Browser(
                tmp_path / "second", (700, 900)
            ) as second:  # and neither resizes the picture of the other again and again
                await second.open(address)
                await second.until("document.querySelector('#view')?.naturalWidth > 0")
                await asyncio.sleep(1.5)
                await browser.ask(
                    "window.seen = 0, document.querySelector('#view').onload = () => window.seen++"
                )
                await asyncio.sleep(1.5)
                assert await browser.ask("window.seen") <= 1
            return taken, await browser.picture()

    taken, picture = served(page, visit)
    assert (tmp_path / "made.toml").exists()
    with capsys.disabled():
        sys.stdout.write(
            f"\nslider to picture in the browser: median {1000 * statistics.median(taken):.0f} ms\n"
        )
    assert np.median(taken) < 5.0
    assert len(picture) > 10_000


def test_a_click_is_found_where_the_picture_is(idle, monkeypatch):
    """The page may hold the picture with borders at its sides, or above and below."""
    wide, high = idle.scene.size
    seen = []
    monkeypatch.setattr(idle.scene, "place", lambda x, y: seen.append((x, y)))
    idle.desk.tool = "spots"
    idle._pressed(wide + 10, high, 2 * wide + 20, 2 * high)  # twice as large, 10 pixels more at either side
    idle._pressed(wide / 4, 50 + high / 4, wide / 2, 100 + high / 2)
    np.testing.assert_allclose(seen, [(wide / 2, high / 2 - 1)] * 2)
    idle._pressed(5, high, 2 * wide + 20, 2 * high)
    idle._pressed(5, 5, 0, 0)
    assert len(seen) == 2


def test_what_a_page_may_not_or_can_no_longer_ask_is_passed_over(idle, tmp_path):
    desk = idle.desk
    before = idle.scene.picture(), desk.session.recipe
    idle._do("save", str(tmp_path / "elsewhere.toml"))
    idle._do("close")
    idle._set("crown_height_of_another_layer", -1, 1.0)
    idle._choose("group", "of another layer")
    idle._choose("__class__", "turn")
    idle._moved(idle.scene.turn)(float("nan"), 1.0)
    idle._moved(idle.scene.zoom)(float("nan"))
    idle._sized(float("nan"), 1.0)
    assert not (tmp_path / "elsewhere.toml").exists()
    assert desk.session.recipe == before[1]
    np.testing.assert_array_equal(idle.scene.picture(), before[0])


def test_the_wheel_comes_near_but_never_through_and_there_is_a_way_back(idle):
    scene, radius = idle.scene, 6.0
    camera, before = scene.plotter.camera, idle.scene.picture()
    for _ in range(100):
        scene.zoom(-300)
    away = np.linalg.norm(camera.GetPosition())
    assert radius < away < 1.1 * radius
    for _ in range(200):
        scene.zoom(300)
    assert away < np.linalg.norm(camera.GetPosition()) < 1000
    scene.reset_camera()
    np.testing.assert_array_equal(scene.picture(), before)


def test_what_was_refused_stays_to_be_read_while_work_goes_on(idle):
    desk = idle.desk
    desk.do("set", "cell_size", 2.5, 0)
    desk.do("set", "direction", "nosuch", 0)
    assert desk.worker.wait()
    assert "nosuch" in desk.message
    desk.do("undo")
    assert desk.worker.wait()
    assert "nosuch" not in desk.message


def test_the_name_of_a_mesh_is_shown_and_not_run(tmp_path):
    from surftex.preview.web import Page

    name = "<b>{{ 1 + 1 }}</b>"
    ball = sphere(6.0, subdivisions=2)
    desk = Desk(
        recipe_from_text(RECIPE), Surface.from_arrays(ball.vertices, ball.faces, name=name), resolution=64
    )
    try:
        made = Page(desk, tmp_path / "made.toml")
    except WorkError as problem:
        desk.close()
        pytest.skip(f"nothing to draw on: {problem}")
    assert name not in made.layout.html
    assert made.server.state.name == name
    made.scene.close()
    desk.close()


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="requests to end are told otherwise elsewhere")
def test_the_page_ends_when_asked(meshes, tmp_path):
    command = [sys.executable, "-m", "surftex", "preview", str(meshes / "torus.obj"), "--units", "mm", "--web",
               "--resolution", "64"]  # fmt: skip
    (tmp_path / "torus-calf.toml").touch()
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    )
    address = process.stdout.readline()
    if not address:
        pytest.skip(f"nothing to draw on: {process.communicate()[1]}")
    assert address.startswith("http://127.0.0.1:")
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert said.splitlines()[0].startswith("surftex: note: torus-calf.toml is there, and save replaces it")
    assert "surftex: note: calf is shown; --material names another, and surftex presets lists them" in said
    assert said.splitlines()[-1] == "surftex: the page is closed"


def test_without_trame_it_says_how_to_get_it(monkeypatch):
    from surftex.preview.web import check_web

    monkeypatch.setitem(sys.modules, "trame.app", None)
    with pytest.raises(WorkError, match=r"surftex\[web\]"):
        check_web()
