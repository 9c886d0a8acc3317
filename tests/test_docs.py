"""The docs: links lead somewhere, commands can be typed, recipes can be read, reference pages are those of the code."""

import re
import shlex

import pytest

from surftex.cli.options import parsed
from surftex.recipe.read import recipe_from_text
from tests.conftest import ROOT

PAGES = sorted([*(ROOT / "docs").glob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"])
REFERENCE = ("reference-materials.md", "reference-commands.md", "reference-python.md")


def blocks(text, kind):
    return re.findall(rf"^```{kind}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_are_there(page):
    text = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
        if "://" not in target:
            assert (page.parent / target).exists(), f"{page.name}: {target}"


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
