"""The page: nothing without the token, and a slider moved in a real browser changes the picture."""

import asyncio
import statistics
import sys
import time

import numpy as np
import pytest

from surftex.errors import WorkError
from surftex.preview.desk import Desk
from surftex.recipe.read import recipe_from_text
from surftex.surface.shapes import sphere
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


@pytest.fixture
def page(tmp_path):
    from surftex.preview.web import Page

    desk = Desk(recipe_from_text(RECIPE), sphere(6.0, subdivisions=3), resolution=256)
    assert desk.worker.wait()
    try:
        made = Page(desk, tmp_path / "made.toml")
    except WorkError as problem:
        desk.close()
        pytest.skip(f"nothing to draw on: {problem}")
    yield made
    made.scene.close()
    desk.close()


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
            return taken, await browser.picture()

    taken, picture = served(page, visit)
    assert (tmp_path / "made.toml").exists()
    with capsys.disabled():
        sys.stdout.write(
            f"\nslider to picture in the browser: median {1000 * statistics.median(taken):.0f} ms\n"
        )
    assert np.median(taken) < 5.0
    assert len(picture) > 10_000


def test_without_trame_it_says_how_to_get_it(monkeypatch):
    from surftex.preview.web import check_web

    monkeypatch.setitem(sys.modules, "trame.app", None)
    with pytest.raises(WorkError, match=r"surftex\[web\]"):
        check_web()
