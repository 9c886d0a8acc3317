"""``surftex match``: what it writes, what it refuses, and that an interruption costs little."""

import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from surftex.errors import InputError
from surftex.optics import load_table, lookup
from surftex.optics.making import Making, make_table
from surftex.optics.tissue import PARAMETERS

SMALL = ["--nodes", "pheomelanin=1,melanin=2,epidermis_cm=2,stratum_corneum_cm=2,blood=2,oxygenation=1",
         "--paths", "300", "--beam-paths", "200", "--step-nm", "50"]  # fmt: skip
SAME = Making(
    nodes={"pheomelanin": 1, "melanin": 2, "epidermis_cm": 2, "stratum_corneum_cm": 2, "blood": 2, "oxygenation": 1},
    paths=300, beam_paths=200, step_nm=50.0,
)  # fmt: skip


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SURFTEX_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path


def match(folder, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "surftex", "match", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=200,
    )


def test_a_table_is_written_and_found_again(folder):
    first = match(folder, *SMALL, "--json")
    assert first.returncode == 0, first.stderr
    report = json.loads(first.stdout)
    assert report["entries"] == 16
    assert report["pieces_of_earlier_runs"] == 0
    data = (folder / "skin-ggx-lambert.npz").read_bytes()
    assert data == make_table(SAME, threads=1).to_bytes()
    again = match(folder, *SMALL, "--out", "again.npz", "--threads", "1")
    assert "4 of 4 pieces are of an earlier run" in again.stderr
    assert (folder / "again.npz").read_bytes() == data
    look = lookup({"melanin": [0.01, 0.3]}, table=load_table(folder / "again.npz"))
    assert (look.base_color[0] > look.base_color[1]).all()


@pytest.mark.parametrize(("blow", "code"), [(signal.SIGINT, 130), (signal.SIGKILL, -signal.SIGKILL)])
def test_a_stopped_run_leaves_no_table_and_is_gone_on_from(folder, blow, code):
    counts = dict.fromkeys(PARAMETERS, 1) | {"epidermis_cm": 4}
    nodes = ",".join(f"{name}={count}" for name, count in counts.items())
    slow = ["--nodes", nodes, "--paths", "4000", "--beam-paths", "0", "--step-nm", "50"]
    process = subprocess.Popen(
        [sys.executable, "-m", "surftex", "match", *slow, "--threads", "1"],
        cwd=folder,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    kept = folder / "cache" / "results"
    for _ in range(12000):
        if kept.is_dir() and any(len(each.name) == 64 for each in kept.iterdir()):
            break
        time.sleep(0.005)
    process.send_signal(blow)
    _, said = process.communicate(timeout=60)
    assert process.returncode == code, said
    assert ("the same command goes on" in said) == (blow == signal.SIGINT)
    assert not [each.name for each in folder.iterdir() if each.name != "cache"]
    again = match(folder, *slow, "--json")
    assert again.returncode == 0, again.stderr
    assert 1 <= json.loads(again.stdout)["pieces_of_earlier_runs"] < 5
    whole = make_table(Making(nodes=counts, paths=4000, beam_paths=0, step_nm=50.0))
    assert (folder / "skin-ggx-lambert.npz").read_bytes() == whole.to_bytes()


def test_pieces_that_are_there_are_not_done_again():
    kept = {}
    whole = make_table(SAME, kept=kept)
    kept.pop(sorted(kept)[1])
    asked = []
    part = make_table(SAME, kept=kept, tick=asked.append)
    assert np.array_equal(whole.values, part.values)
    assert sorted(asked) == asked
    assert len(asked) < 15


PHONG = """
import numpy as np
from surftex.optics.shaders.shader import Shader

def parts(exponent, geometry):
    lobe = (exponent + 2) / (8 * np.pi) * geometry.half**exponent
    return np.full_like(lobe, 1 / np.pi), np.zeros_like(lobe), lobe

SHADER = Shader(
    name="blinn", caption="Blinn and Phong's lobe over Lambert", shapes=np.geomspace(1.0, 1e4, 96), parts=parts,
    shape_of=lambda width: 2 / width**2 - 2, roughness=lambda exponent: (2 / (exponent + 2)) ** 0.25,
    color=lambda diffuse, reflectance: diffuse,
)
"""


def test_a_new_render_model_is_one_file(folder, monkeypatch, capsys):
    from surftex.cli import main
    from surftex.optics.shaders import SHADERS

    names: dict = {}
    exec(compile(PHONG, "blinn.py", "exec"), names)
    monkeypatch.setitem(SHADERS, "blinn", names["SHADER"])
    monkeypatch.chdir(folder)
    assert main(["match", "--shader", "blinn", "-q", *SMALL]) == 0, capsys.readouterr().err
    table = load_table(folder / "skin-blinn.npz")
    assert table.settings["shader"] == "blinn"
    look = lookup({"melanin": [0.01, 0.3]}, table=table)
    assert (look.base_color[0] > look.base_color[1]).all()
    # The fold of the surface: seen best on dark skin; on light skin so few paths leave most to the diffuse part.
    assert np.abs(look.roughness - 0.35**0.5)[1] < 0.1
    assert np.abs(look.roughness - 0.35**0.5)[0] < 0.25


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (["--shader", "phong"], "there is no shader 'phong'; known are ggx-lambert, principled, ashikhmin-shirley"),
        (["--engine", "mcml"], "there is no engine 'mcml'; known are biospec, volume"),
        (["--nodes", "melanine=3"], "skin has no parameter 'melanine'; known are"),
        (["--nodes", "melanin=90"], "nodes of melanin are 90; they go from 1 to 33"),
        (["--nodes", "melanin"], "'melanin' sets nothing; write --nodes melanin=8,blood=6"),
        (["--paths", "3"], "paths is 3; it takes at least 100"),
        (["--shader", "ggx-disney"], "no shader 'ggx-disney'; known are ggx-lambert, principled, ashikhmin-shirley"),
        (["--set", "fold=2"], "fold is 2; it goes from 0 to 0.9"),
        (["--set", "papillary_cm=-1"], "papillary_cm is -1; it goes from 0.001 to 1"),
        (["--set", "haemoglobin_g_per_l=nan"], "haemoglobin_g_per_l is nan; it goes from 0 to 400"),
        (["--set", "facets=flat"], "facets is 'flat'; known are ggx, biospec"),
        (["--facing", "-1"], "facing is -1; it goes from 0 to 10"),
        (["--out", "."], ". is a folder; name the table too, such as skin.npz"),
        (["--set", "base_albdo=1"], "tissue has no 'base_albdo'"),
        (["--step-nm", "0"], "step_nm is 0; it goes from 1 to 50"),
        (["--out", "nowhere/skin.npz"], "there is no folder nowhere"),
        (["--out", "skin.exr"], "a table of skin is an .npz; name it skin.npz"),
    ],
)  # fmt: skip
def test_a_wrong_option_is_refused(folder, wrong, message, capsys, monkeypatch):
    from surftex.cli import main

    monkeypatch.chdir(folder)
    assert main(["match", *wrong]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
    assert not list(folder.iterdir())


def test_a_file_that_is_there_stays(folder):
    (folder / "skin-ggx-lambert.npz").write_bytes(b"mine")
    process = match(folder, *SMALL)
    assert process.returncode == 2
    assert "--overwrite" in process.stderr
    assert (folder / "skin-ggx-lambert.npz").read_bytes() == b"mine"
    with pytest.raises(InputError, match="is no table of skin"):
        load_table(folder / "skin-ggx-lambert.npz")
