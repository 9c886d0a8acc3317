"""Fixtures that several rooms share."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=60)
settings.load_profile("repeatable")

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    """Keep the results of tests out of the user's cache, and those of the user out of the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SURFTEX_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def meshes() -> Path:
    """The folder of meshes that the project ships."""
    return ROOT / "meshes"


@pytest.fixture(scope="session")
def shared() -> Path:
    """A folder of real-world meshes beside the checkout, named by SURFTEX_SHARED; tests skip without it."""
    folder = Path(os.environ.get("SURFTEX_SHARED", ROOT.parent / "shared"))
    if not (folder / "meshes").is_dir():
        pytest.skip(f"no real-world meshes at {folder}: set SURFTEX_SHARED to a folder that holds meshes/")
    return folder
