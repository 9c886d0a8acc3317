"""``surftex match``: what it writes, what it refuses, and that an interruption costs little."""

import dataclasses
import json
import re
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
        (["--nodes", "melanin=90"], "number of melanin nodes is 90; it goes from 1 to 33"),
        (["--nodes", "melanin"], "'melanin' sets nothing; write --nodes melanin=8,blood=6"),
        (["--paths", "3"], "paths is 3; it goes from 100 to 100000000"),
        (["--beam-paths", "1000000000"], "beam_paths is 1000000000; it goes from 0 to 100000000"),
        (["--nodes", "melanin=2,melanin=3"], "melanin is set twice, to 2 and 3; keep one"),
        (["--nodes", "melanin=2", "--nodes", "melanin=3"], "melanin is set twice, to 2 and 3; keep one"),
        (["--node", "melanin=2"], "unknown option --node; did you mean --nodes?"),
        (["--set", "fold=0.2", "--set", "fold=0.3"], "fold is set twice, to 0.2 and 0.3; keep one"),
        (["--lock-surface", "--fit-reflectance"], "lock_surface keeps the reflectance of the surface"),
        (["--threads", "0"], "threads is 0; it takes at least 1"),
        (["--seed", "-1"], "seed is -1; it takes at least 0"),
        (["--out", "/proc/x.npz"], "/proc/x.npz: cannot write in /proc"),
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


def test_without_the_cache_nothing_is_kept(folder, monkeypatch):
    from surftex.cli import main

    monkeypatch.chdir(folder)
    assert main(["match", *SMALL, "-q", "--no-cache"]) == 0
    assert [each.name for each in folder.iterdir()] == ["skin-ggx-lambert.npz"]
    assert (folder / "skin-ggx-lambert.npz").read_bytes() == make_table(SAME, threads=1).to_bytes()


def test_an_interruption_without_the_cache_promises_nothing(folder, monkeypatch, capsys):
    from surftex.bake import matching
    from surftex.cli import main

    def cut(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.chdir(folder)
    monkeypatch.setattr(matching, "make_table", cut)
    assert main(["match", *SMALL, "-q", "--no-cache"]) == 130
    assert "nothing is kept" in capsys.readouterr().err
    assert main(["match", *SMALL, "-q"]) == 130
    assert "the same command goes on from them" in capsys.readouterr().err


def test_nodes_may_be_named_one_by_one(folder, monkeypatch, capsys):
    from surftex.cli import main

    monkeypatch.chdir(folder)
    few = [part for text in SMALL[1].split(",") for part in ("--nodes", text)]
    assert main(["match", *few, *SMALL[2:], "--json"]) == 0
    said = capsys.readouterr()
    report = json.loads(said.out)
    assert report["entries"] == 16
    assert [text.split(",")[0] for text in report["warnings"]] == [
        "pheomelanin has one node",
        "oxygenation has one node",
    ]
    assert all(f"warning: {text}" in said.err for text in report["warnings"])


@pytest.mark.parametrize("facing", ["0", "4"])
@pytest.mark.parametrize("shader", ["ggx-lambert", "principled", "ashikhmin-shirley"])
def test_gloss_never_stands_for_diffuse_light(folder, monkeypatch, capsys, shader, facing):
    """With the reflectance matched too: colours of usual skin, near those of a match that holds it; the bound is told."""
    from surftex.cli import main

    few = ["--nodes", "pheomelanin=1,melanin=2,epidermis_cm=1,stratum_corneum_cm=1,blood=2,oxygenation=1",
           "--paths", "2000", "--beam-paths", "0", "--step-nm", "50", "--shader", shader, "--facing", facing]  # fmt: skip
    monkeypatch.chdir(folder)
    assert main(["match", *few, "-o", "free.npz", "--fit-reflectance", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert main(["match", *few, "-o", "held.npz", "-q"]) == 0
    free, held = (load_table(folder / f"{name}.npz").values[..., :5] for name in ("free", "held"))
    assert free[..., 3].max() <= 0.08
    pale = (slice(None), 0)  # melanin 0.002
    assert free[pale][..., :3] == pytest.approx(held[pale][..., :3], abs=0.06)
    told = [text for text in report["warnings"] if text.startswith("reflectance ends at its bound, 0.08, in")]
    assert len(told) == 1
    assert "of 4 entries" in told[0]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"seed": 1.5}, "seed is 1.5; it takes a whole number"),
        ({"paths": "many"}, "paths is 'many'; it takes one number"),
        ({"nodes": {"melanin": "two"}}, "number of melanin nodes is 'two'; it takes one number"),
        (
            {"nodes": ["melanin"]},
            "parameters of skin come by name, such as {'melanin': 0.02}; this is a list",
        ),
        ({"facing": None}, "facing is None; it takes one number"),
    ],
)
def test_a_wrong_setting_is_refused(wrong, message):
    with pytest.raises(InputError, match=re.escape(message)):
        Making(**wrong)


def test_a_table_that_cannot_be_read_is_told_by_its_own_class(folder):
    for path in (folder / "none.npz", folder, None, 3):
        with pytest.raises(InputError) as caught:
            load_table(path)
        assert type(caught.value) is InputError
        assert "\n" not in str(caught.value)


def test_a_damaged_table_tells_what_does_not_fit(folder):
    table = make_table(Making(nodes=dict.fromkeys(PARAMETERS, 1), paths=100, beam_paths=0, step_nm=50.0))
    settings = table.settings | {"nodes": table.settings["nodes"] | {"melanin": 2}}
    (folder / "a.npz").write_bytes(dataclasses.replace(table, settings=settings).to_bytes())
    with pytest.raises(
        InputError, match=re.escape("it holds (1, 1, 1, 1, 1, 1, 8) numbers, and its settings say (1, 2,")
    ):
        load_table(folder / "a.npz")
    (folder / "b.npz").write_bytes(dataclasses.replace(table, values=table.values * np.nan).to_bytes())
    with pytest.raises(InputError, match="8 of its 8 numbers are not finite"):
        load_table(folder / "b.npz")
    settings = table.settings | {"nodes": dict.fromkeys(PARAMETERS, 0)}
    none = dataclasses.replace(table, values=np.zeros((0, 0, 0, 0, 0, 0, 8)), settings=settings)
    with pytest.raises(InputError, match="is damaged"):
        type(table).from_bytes(none.to_bytes())
