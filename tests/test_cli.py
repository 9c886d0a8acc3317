"""The command, as a user runs it: in a process of its own, judged by exit code, stdout, stderr and files."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from surftex.cli import main
from surftex.cli.say import out
from surftex.surface.shapes import cylinder, plane, sphere

COMMAND = [sys.executable, "-m", "surftex"]
QUICK = ["--material", "calf", "--set", "cell_size=3 mm", "--set", "wrinkle_density=0", "--set", "pore_density=0",
         "--set", "pocket_depth=0", "--resolution", "64", "--units", "mm"]  # fmt: skip


def surftex(*arguments, folder=None, **options):
    process = subprocess.run(
        [*COMMAND, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=300, **options
    )
    assert "Traceback" not in process.stderr
    return process


def refused(*arguments, folder=None, code=2):
    process = surftex(*arguments, folder=folder)
    assert process.returncode == code, process.stderr
    assert process.stdout == ""
    assert process.stderr.startswith("surftex: ")
    assert process.stderr.count("\n") == 1
    return process.stderr.removeprefix("surftex: ").strip()


def write_obj(path: Path, surface, scale=1.0):
    rows = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in surface.vertices * scale]
    if surface.corner_uv is not None:
        rows += [f"vt {u:.9g} {v:.9g}" for u, v in surface.corner_uv.reshape(-1, 2)]
        rows += [
            "f " + " ".join(f"{v + 1}/{3 * i + k + 1}" for k, v in enumerate(face))
            for i, face in enumerate(surface.faces)
        ]
    else:
        rows += ["f " + " ".join(str(v + 1) for v in face) for face in surface.faces]
    path.write_text("\n".join(rows) + "\n")


@pytest.fixture
def ball(tmp_path):
    write_obj(tmp_path / "ball.obj", sphere(15.0, subdivisions=3))
    return tmp_path


def test_help_and_version_are_printed():
    for arguments in ([], ["--help"], ["bake", "--help"]):
        process = surftex(*arguments)
        assert process.returncode == 0
        assert "exit codes: 0 done" in process.stdout
        assert process.stderr == ""
    assert surftex("--version").stdout.startswith("surftex 0.")


def test_a_bake_writes_everything_it_lists(ball):
    process = surftex("bake", "ball.obj", *QUICK, folder=ball)
    assert process.returncode == 0, process.stderr
    folder = ball / "ball-calf"
    names = {path.name for path in folder.iterdir()}
    assert {"ball.glb", "ball_base_color.png", "ball_roughness.png", "ball_normal.png", "ball_height.exr", "features.npz",
            "report.json"} <= names  # fmt: skip
    report = json.loads((folder / "report.json").read_text())
    assert set(report["outputs"]) == names - {"report.json"}
    assert report["mesh"]["units"] == "mm"
    assert report["features"]["cell"] > 50
    assert process.stdout.startswith(f"ball-calf: {len(names)} files; 64 x 64")
    assert {path.name for path in ball.iterdir()} == {"ball.obj", "ball-calf"}

    said = refused("bake", "ball.obj", *QUICK, folder=ball)
    assert "ball-calf holds" in said
    assert "--overwrite" in said
    quiet = surftex("bake", "ball.obj", *QUICK, "--overwrite", "-q", folder=ball)
    assert (quiet.returncode, quiet.stdout, quiet.stderr) == (0, "", "")
    again = json.loads((folder / "report.json").read_text())
    assert again["outputs"] == report["outputs"]  # same seed, same bytes


def test_json_is_the_report_and_nothing_else(ball):
    process = surftex(
        "bake", "ball.obj", *QUICK, "--json", "-v", "--maps", "height", "--seed", "9", folder=ball
    )
    report = json.loads(process.stdout)
    assert report == json.loads((ball / "ball-calf" / "report.json").read_text())
    assert report["seed"] == 9
    assert set(report["outputs"]) == {"ball.glb", "ball_height.exr", "features.npz"}
    stages = [line for line in process.stderr.splitlines() if line.endswith(" s")]
    assert any(line.startswith("surftex: baking: ") for line in stages)


@pytest.mark.slow
def test_a_bake_from_saved_features_gives_the_same_files(ball):
    assert surftex("bake", "ball.obj", *QUICK, "--out", "a", folder=ball).returncode == 0
    again = surftex(
        "bake",
        "ball.obj",
        *QUICK,
        "--out",
        "b",
        "--features",
        "a/features.npz",
        "--threads",
        "1",
        "--tile",
        "20",
        folder=ball,
    )
    assert again.returncode == 0, again.stderr
    first, second = (json.loads((ball / name / "report.json").read_text())["outputs"] for name in ("a", "b"))
    assert first == second


def test_a_recipe_with_its_own_mesh(ball):
    (ball / "my.toml").write_text(
        "surftex = 1\nseed = 3\n[mesh]\npath = 'ball.obj'\nsize = '20 mm'\n[bake]\nresolution = 64\nmaps = ['height']\n"
        "[fields]\nup = { gradient = [0, 0, 1] }\n[[layer]]\npreset = 'sakurai-12a'\ncell_size = 2\n"
        "[[layer]]\npreset = 'sakurai-12a'\ncell_size = 3\nmask = 'smoothstep(0.3, 0.7, up)'\n"
    )
    process = surftex("bake", "my.toml", "--out", "out", "--json", "--displaced", "--materialx", "--usd-format", "usdc",
                      folder=ball)  # fmt: skip
    assert process.returncode == 0, process.stderr
    report = json.loads(process.stdout)
    assert report["seed"] == 3
    assert report["mesh"]["area_mm2"] == pytest.approx(np.pi * 400, rel=0.02)
    assert {"cell", "layer2_cell"} <= set(report["features"])
    assert {"ball_displaced.glb", "ball.mtlx", "ball.usdc"} <= set(report["outputs"])
    assert (report["recipe"]["bake"]["usd"], report["recipe"]["bake"]["materialx"]) == (True, True)
    again = surftex("bake", "my.toml", "--out", "out", "--usd-format", "usdc", folder=ball)
    assert again.returncode == 2


MISTAKES = [
    (["bake"], "the following arguments are required: MESH|RECIPE.toml; see surftex bake --help"),
    (["bakee"], "unknown command 'bakee'; did you mean bake?"),
    (["bake", "ball.obj"], "a mesh needs a material"),
    (
        ["preview", "ball.obj", "--web", "--port", "65536"],
        "--port 65536: a port is 0, for any that is free, to 65535",
    ),
    (["bake", "ball.obj", "--material", "claf"], "there is no preset 'claf'; did you mean calf?"),
    (["preview", "ball.obj", "--material", "zzz"], "there is no preset 'zzz'; surftex presets lists them"),
    (["bake", "ball.obj", "--material", "none.toml"], "the recipe 'none.toml' does not exist"),
    (["bake", "none.obj", "--material", "calf"], "none.obj"),
    (
        ["bake", "ball.obj", "--material", "calf", "--resolutoin", "64"],
        "unknown option --resolutoin; did you mean --resolution?",
    ),
    (["bake", "ball.obj", "--material", "calf", "--resolution", "big"], "'big' is not a whole number"),
    (
        ["bake", "ball.obj", "--material", "calf", "--resolution", "4"],
        "resolution: 4: should be greater than or equal to 16",
    ),
    (
        ["bake", "ball.obj", "--material", "calf", "--set", "cell_sise=2"],
        "cell_sise: unknown key; did you mean cell_size?",
    ),
    (
        ["bake", "ball.obj", "--material", "calf", "--maps", "hieght"],
        "unknown map 'hieght'; did you mean height?",
    ),
    (["bake", "ball.obj", "--material", "calf", "--size", "3 parsec"], "unknown unit 'parsec'"),
    (["bake", "ball.obj", "--material", "calf", "--units", "km"], "invalid choice: 'km'"),
    (["bake", "ball.obj", "--material", "calf", "--part", "lid"], "lid"),
    (
        ["bake", "ball.obj", "--material", "calf", "--units", "mm", "--texels-per-mm", "3"],
        "texels_per_mm spreads an unwrap over tiles",
    ),
    (["bake", "ball.obj", "--material", "calf", "--units", "mm", "--uv", "keep"], "no UVs"),
    (["bake", "ball.obj", "--material", "calf", "--units", "m", "--max-features", "9"], "layer: "),
    (["bake", "ball.obj", "--material", "calf", "--threads", "0"], "threads is 0"),
    (
        ["bake", "ball.obj", "--material", "calf", "--features", "ball.obj"],
        "ball.obj: is no features file, such as",
    ),
    (["bake", "ball.obj", "--material", "calf", "--out", "ball.obj"], "ball.obj is a file; name a folder"),
    (["bake", "bad.toml"], "bad.toml:3: layer.cell_sise: unknown key; did you mean cell_size?"),
    (["bake", "bad.toml", "--material", "calf"], "names its own materials"),
    (
        ["bake", "outside.toml"],
        "outside.toml:2: mesh.path: '../ball.obj' leaves the recipe's folder; allow it with",
    ),
    (["inspect", "."], "is a folder"),
    (["inspect", "bad.toml"], "unknown format '.toml'"),
    (["presets", "claf"], "did you mean calf?"),
    (["cache"], "one of the arguments --warm --clear --where --size is required"),
    (["render", "ball.obj", "-o", "a.png", "--picture-size", "big"], "'big' is no size"),
    (["analyse", "none.exr"], "none.exr"),
]


@pytest.mark.parametrize(
    ("arguments", "says"), MISTAKES, ids=[" ".join(arguments) for arguments, _ in MISTAKES]
)
def test_a_mistake_is_one_line_and_code_2(ball, arguments, says, monkeypatch, capsys):
    (ball / "bad.toml").write_text("[[layer]]\npreset = 'calf'\ncell_sise = 2\n")
    (ball / "outside.toml").write_text("[mesh]\npath = '../ball.obj'\n[[layer]]\npreset = 'calf'\n")
    before = sorted(ball.iterdir())
    monkeypatch.chdir(ball)
    handler = signal.getsignal(signal.SIGTERM)
    code = main([*arguments, *(["-q"] if arguments[0] == "bake" and len(arguments) > 2 else [])])
    signal.signal(signal.SIGTERM, handler)
    printed, said = capsys.readouterr()
    assert (code, printed) == (2, "")
    assert said.startswith("surftex: ")
    assert said.count("\n") == 1
    assert says in said
    assert sorted(ball.iterdir()) == before


def test_control_characters_never_reach_the_terminal(ball):
    said = refused("inspect", "no\x1b[2J\nsuch.obj", folder=ball)
    assert "\x1b" not in said
    assert "\\x1b" in said


def test_what_is_printed_holds_no_control_characters_and_json_reads_as_before(capsys):
    text = "a\x1b[31m\x9b\u202e\U000e0001\nb"
    out(text)
    out(json.dumps({"out": text}, ensure_ascii=False))
    plain, written = capsys.readouterr().out.rstrip("\n").rsplit("\n", 1)
    assert plain == "a\\u001b[31m\\u009b\\u202e\\udb40\\udc01\nb"
    assert written.isprintable()
    assert json.loads(written)["out"] == text


@pytest.mark.slow
def test_presets_are_listed_and_printed_as_recipes_that_bake(ball):
    shelf = json.loads(surftex("presets", "--json").stdout)
    assert {"calf", "ostrich", "crocodile", "sakurai-12a"} <= set(shelf["leather"])
    listed = surftex("presets").stdout
    assert all(name in listed for name in shelf["leather"])
    printed = surftex("presets", "sakurai-12a").stdout
    (ball / "mine.toml").write_text(printed)
    options = ["--units", "mm", "--resolution", "64", "--set", "cell_size=3", "--json"]
    mine = json.loads(surftex("bake", "ball.obj", "--material", "mine.toml", *options, folder=ball).stdout)
    shelf_own = json.loads(
        surftex("bake", "ball.obj", "--material", "sakurai-12a", *options, folder=ball).stdout
    )
    assert mine["outputs"] == shelf_own["outputs"]
    assert (ball / "ball-mine").is_dir()


def test_inspect_says_what_a_mesh_is_and_what_a_bake_costs(tmp_path):
    write_obj(tmp_path / "tube.obj", cylinder(20.0, 60.0))
    process = surftex("inspect", "tube.obj", "--units", "mm", "--json", folder=tmp_path)
    facts = json.loads(process.stdout)
    assert facts["border_loops"] == 2
    assert facts["area_mm2"] == pytest.approx(2 * np.pi * 20 * 60, rel=0.01)
    assert [page["resolution"] for page in facts["cost"]["pages"]] == [1024, 2048, 4096, 8192]
    density = facts["cost"]["pages"][0]["texels_per_mm"]
    assert density == pytest.approx(1024 * (0.62 / facts["area_mm2"]) ** 0.5, rel=1e-3)
    text = surftex("inspect", "tube.obj", "--units", "mm", folder=tmp_path).stdout
    assert "borders: 2" in text
    assert "4096 x 4096" in text
    assert (
        "scale a mesh whose unit is wrong"
        in surftex("inspect", "tube.obj", "--units", "m", folder=tmp_path).stdout
    )


def test_inspect_says_what_a_bake_makes_of_own_uvs(tmp_path, capsys):
    sheet = plane(30.0, 30.0, cells=6)
    uv = 0.05 + 0.9 * sheet.corner_uv
    small = uv.copy()
    small[3] = small[3].mean(axis=0)
    plans = {
        "a bake keeps them": uv,
        "72 of 72 faces are mirrored in the file's own UVs; they are baked so that they look right": uv
        * [-1, 1]
        + [1, 0],
        "a bake unwraps anew: 1 of 72 faces have no area on the page; the first is face 3; --uv keep keeps them all the same, "
        "with a warning": small,
        "a bake unwraps anew: 100.0 % of the area is stretched more than 4 times; --uv keep is refused": uv
        * [1, 0.2],
    }
    for says, own in plans.items():
        write_obj(tmp_path / "sheet.obj", replace(sheet, corner_uv=own))
        assert main(["inspect", str(tmp_path / "sheet.obj"), "--units", "m"]) == 0
        printed = capsys.readouterr().out
        assert f"  {says}" in printed
        assert "unit of the file: metres" in printed
    write_obj(tmp_path / "sheet.obj", replace(sheet, corner_uv=(uv * [-1, 0.2] + [1, 0])))
    assert main(["inspect", str(tmp_path / "sheet.obj"), "--units", "m"]) == 0
    assert "are mirrored" not in capsys.readouterr().out  # nothing follows where none are kept
    page = next(row for row in printed.splitlines() if "8192 x 8192" in row)
    assert page.endswith(" MB, and 4,094 MB in temporary files")


def test_own_uvs_are_kept_and_a_guess_of_the_unit_is_a_warning(tmp_path):
    write_obj(tmp_path / "sheet.obj", plane(30.0, cells=6), scale=0.01)
    options = [each for each in QUICK if each not in ("--units", "mm")]
    process = surftex("bake", "sheet.obj", *options, "--json", folder=tmp_path)
    report = json.loads(process.stdout)
    assert report["unwrap"]["unwrapper"] == "own"
    assert "surftex: warning: the file names no unit" in process.stderr
    assert any("unit" in warning for warning in report["warnings"])


def started(*arguments, folder):
    return subprocess.Popen(
        [*COMMAND, *map(str, arguments)],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize(
    ("number", "stage"),
    [
        (signal.SIGINT, "reading the mesh"),
        (signal.SIGINT, "placing features"),
        (signal.SIGTERM, "placing features"),
    ],
    ids=["ctrl-c while unwrapping", "ctrl-c while baking", "terminated while baking"],
)
def test_an_interrupted_bake_leaves_nothing(tmp_path, number, stage):
    write_obj(tmp_path / "ball.obj", sphere(40.0, subdivisions=5))
    options = [*QUICK, "--set", "cell_size=0.8", "--resolution", "8192", "--threads", "1", "-v"]
    process = started("bake", "ball.obj", *options, folder=tmp_path)
    said = ""
    while stage not in said:
        line = process.stderr.readline()
        assert line, said
        said += line
    time.sleep(0.5)
    process.send_signal(number)
    begun = time.monotonic()
    out, rest = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in said + rest
    assert rest.splitlines()[-1] == "surftex: interrupted; nothing was written"
    assert out == ""
    assert time.monotonic() - begun < 30
    assert [path.name for path in tmp_path.iterdir()] == ["ball.obj"]


def test_a_reader_that_has_seen_enough_is_no_failure():
    script = f"{sys.executable} -m surftex presets | head -n 1; exit ${{PIPESTATUS[0]}}"
    process = subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=60)
    assert process.returncode == 0
    assert process.stdout == "leather:\n"
    assert process.stderr == ""


def test_closed_streams_do_not_matter(ball):
    for redirect in (">&-", "2>&-", ">&- 2>&-"):
        script = f"{sys.executable} -m surftex presets {redirect}"
        assert subprocess.run(["bash", "-c", script], capture_output=True, timeout=60).returncode == 0
    process = subprocess.run(
        ["bash", "-c", f"{sys.executable} -m surftex inspect none.obj 2>&-"], capture_output=True, timeout=60
    )
    assert process.returncode == 2
    assert process.stdout == b""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_disk_is_code_3():
    with Path("/dev/full").open("w") as full:
        process = subprocess.run(
            [*COMMAND, "presets"], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60
        )
    assert process.returncode == 3
    assert process.stderr == "surftex: cannot write to stdout: No space left on device\n"


def test_an_unexpected_failure_is_one_line_and_code_3(ball):
    script = (
        "import sys, surftex.cli.presets as room\n"
        "def fail(options): raise ZeroDivisionError('half a thing')\n"
        "room.run = fail\n"
        "from surftex.cli import main\n"
        "sys.exit(main(['presets', *sys.argv[1:]]))"
    )
    process = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert process.returncode == 3
    assert process.stderr == "surftex: unexpected failure: ZeroDivisionError: half a thing; -v shows where\n"
    process = subprocess.run([sys.executable, "-c", script, "-v"], capture_output=True, text=True, timeout=60)
    assert process.returncode == 3
    assert "Traceback" in process.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="a process there ends otherwise")
@pytest.mark.parametrize(
    ("happens", "code", "told"),
    [
        ("exec('raise KeyboardInterrupt')", 130, "surftex: interrupted; nothing was written\n"),
        ("atexit.register(signal.raise_signal, signal.SIGINT)", 0, ""),
        ("atexit.register(signal.raise_signal, signal.SIGTERM)", 0, ""),
    ],
)
def test_a_process_ends_with_the_code_of_its_result(tmp_path, happens, code, told):
    """Not by a signal that came while Python executed a text, or after the result."""
    (tmp_path / "late.py").write_text(
        "import atexit, signal, sys, surftex.cli.presets as room\n"
        f"def run(options): {happens}\n"
        "room.run = run\n"
        "sys.argv[1:] = ['presets']\n"
        "from surftex.cli import process\n"
        "sys.exit(process())"
    )
    done = subprocess.run([sys.executable, "-m", "late"], cwd=tmp_path, capture_output=True, text=True, timeout=60,
                          env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (*sys.path, tmp_path)))})  # fmt: skip
    assert (done.returncode, done.stderr) == (code, told)


def test_the_cache_is_told_and_emptied(tmp_path):
    kept = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kernels"), "SURFTEX_CACHE_DIR": str(tmp_path)}
    where = surftex("cache", "--where", env=kept).stdout.split()
    assert where == [str(tmp_path / "kernels"), str(tmp_path / "results")]
    assert "0 results" in surftex("cache", "--size", env=kept).stdout
    script = (
        "import numpy as np; from surftex.fields.noise import Noise; from surftex.randomness import stream\n"
    )
    script += "Noise(stream(1, 'a'), 1.0).at(np.zeros((1, 3)))"
    subprocess.run([sys.executable, "-c", script], env=kept, check=True, timeout=120)
    compiled = list((tmp_path / "kernels").rglob("*.nbc"))
    assert compiled
    other = tmp_path / "kernels" / f"kernels_{'0' * 40}" / compiled[0].name
    own = [tmp_path / "results" / "thesis.txt", tmp_path / "kernels" / "warm-up.txt", other]
    for path in own:
        path.parent.mkdir(exist_ok=True)
        path.write_text("of somebody else")
    assert "files deleted" in surftex("cache", "--clear", env=kept).stdout
    assert sorted(path for path in tmp_path.rglob("*") if path.is_file()) == sorted(own)
    for path in own:
        path.unlink()
    other.parent.rmdir()
    assert "kernels: 0 files deleted" in surftex("cache", "--clear", env=kept).stdout
    assert not (tmp_path / "kernels").exists()
    assert not (tmp_path / "results").exists()


HEAVY = [
    "numba",
    "scipy",
    "igl",
    "potpourri3d",
    "pyvista",
    "trimesh",
    "xatlas",
    "uvunwrap",
    "matplotlib",
    "vtk",
]


@pytest.mark.parametrize(
    "code", ["import surftex", "from surftex.cli.options import make_parser; make_parser()"]
)
def test_nothing_heavy_is_imported_before_it_is_needed(code):
    script = f"{code}\nimport sys\nprint([name for name in {[*HEAVY, 'numpy', 'pydantic', 'rich']} if name in sys.modules])"
    process = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    assert process.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("arguments", "most_s"), [(["-c", "import surftex"], 0.3), (["-m", "surftex", "--help"], 0.4)]
)
def test_starting_is_fast(arguments, most_s):
    took = []
    for _ in range(7):
        begun = time.perf_counter()
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True, timeout=60)
        took.append(time.perf_counter() - begun)
    assert min(took) <= most_s
