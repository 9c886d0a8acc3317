"""The docs: links lead somewhere, commands can be typed, recipes can be read, reference pages are those of the code."""

import re
import shlex
from importlib import import_module
from pathlib import Path

import pytest

from surftex.cli.options import parsed
from surftex.recipe.read import recipe_from_text
from tests.conftest import ROOT

PAGES = sorted(
    [
        *ROOT.glob("*.md"),
        *(page for room in ("docs", "meshes", "notebooks") for page in (ROOT / room).glob("*.md")),
    ]
)
REFERENCE = ("reference-materials.md", "reference-commands.md", "reference-python.md", "reference-recipe.md")


def prose(page):
    """A page without its code."""
    return re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)


def headings(page):
    """The anchors that a page has, as GitHub makes them of its headings."""
    titles = re.findall(r"^#+ +(.+?) *$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def blocks(text, kind):
    return re.findall(rf"^```{kind}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_are_there(page):
    for target, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)]*))?\)", prose(page)):
        if "://" in target:
            continue
        file = page.parent / target if target else page
        assert file.exists(), f"{page.name}: {target}"
        assert not anchor or anchor in headings(file), f"{page.name}: {target}#{anchor}"


def test_every_picture_of_the_gallery_has_the_command_that_makes_it():
    makers, shown, known, at = {}, [], None, ""
    for line in prose(ROOT / "docs" / "gallery.md").splitlines():
        if line.startswith("## "):
            known, at = None, line
        for module, names in re.findall(r"`python -m docs\.(\w+) ([a-z0-9-]+`(?:, `[a-z0-9-]+`)*)", line):
            source = import_module(f"docs.{module}")
            known = Path(str(source.__file__)).read_text("utf-8")
            makers.setdefault(module, []).extend(re.findall(r"[a-z0-9-]+", names))
            assert set(makers[module]) <= set(source.PICTURES), line
        for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", line):
            assert known is not None, f"{at}: {picture} has no command above it"
            stem = Path(picture).stem
            assert re.search(rf'["/]{stem}[".]|{stem.rpartition("-")[0]}-\{{', known), (
                f"{at}: nothing there makes {picture}"
            )
            shown.append(stem)
    assert len(shown) == len(set(shown)) > 30
    for module, names in makers.items():
        left = set(import_module(f"docs.{module}").PICTURES) - set(names)
        assert left <= {"skin-colours"}, f"{module}: {left} is not in the gallery"  # stands in skin-optics.md


def test_every_picture_is_shown_somewhere():
    text = "".join(page.read_text("utf-8") for page in [*PAGES, *(ROOT / "docs").glob("*.py")])
    lost = [file.name for file in (ROOT / "docs" / "pictures").iterdir() if file.name not in text]
    assert not lost


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_can_be_typed(page):
    for block in blocks(page.read_text("utf-8"), ""):
        for line in block.splitlines():
            if line.startswith("surftex ") and "[" not in line and "..." not in line:
                parsed(shlex.split(line, comments=True)[1:])


@pytest.mark.parametrize("page", ["tutorial.md", "recipe.md"])
def test_recipes_can_be_read(page):
    for block in blocks((ROOT / "docs" / page).read_text("utf-8"), "toml"):
        if "[[layer]]" in block:
            assert recipe_from_text(block, allow_outside=True).layer


@pytest.mark.parametrize("name", REFERENCE)
def test_reference_is_that_of_the_code(name):
    from docs.make_reference import page

    kept = (ROOT / "docs" / name).read_text("utf-8")
    assert kept == page(name), "the code has changed: run `python -m docs.make_reference`"


def test_the_readme_names_every_preset():
    from surftex.recipe.layer import all_presets

    text = (ROOT / "README.md").read_text("utf-8")
    told = set(re.findall(r"[\w-]+", text[text.index("## Presets") : text.index("## Shape it live")]))
    names = {name for shelf in all_presets().values() for name in shelf}
    assert {name for name in names if not name.startswith("sakurai-12")} <= told
