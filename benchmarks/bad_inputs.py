"""Nasty mesh files through ``inspect`` and ``bake``, a process each: exit code, processor time, memory, what was said.

``python -m benchmarks.bad_inputs FOLDER [NUMBER ...]``: files of FOLDER whose names begin with a number of two
digits, and two that travel badly: a link to itself, and a name with an ESC. Kernels must be warm.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

MEASURED = """
import json, resource, sys
from surftex.bake.stages import peak_rss_mb
from surftex.cli import main
code = main(sys.argv[2:])
of, below = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
processor = of.ru_utime + of.ru_stime + below.ru_utime + below.ru_stime
open(sys.argv[1], "w").write(json.dumps([processor, max(peak_rss_mb(), below.ru_maxrss * 1024 / 1e6)]))
sys.exit(code)
"""
BAKE = ["--material", "crocodile", "--resolution", "256", "--no-cache"]


@dataclass(frozen=True)
class Row:
    number: int
    command: str
    code: int
    wall_s: float
    processor_s: float
    peak_mb: float
    files: int
    said: str


def rows(folder: Path, numbers: Iterable[int] = ()) -> Iterator[Row]:
    """Each file by each command."""
    wanted = set(numbers)
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        for number, path in files(folder, place):
            if not wanted or number in wanted:
                for command in ("inspect", "bake"):
                    yield measured(number, command, path, place)


def files(folder: Path, place: Path) -> Iterator[tuple[int, Path]]:
    found = [path for path in sorted(folder.iterdir()) if path.name[:2].isdigit() and path.suffix != ".mtl"]
    for path in found:
        yield int(path.name[:2]), next(path.iterdir()) if path.is_dir() and not path.suffix else path
    loop, escape = place / "75_loop.obj", place / "76_e\x1b[31m.obj"
    loop.symlink_to(loop)
    yield 75, loop
    shutil.copy(next(path for path in found if path.name.startswith("50_")), escape)
    yield 76, escape


def measured(number: int, command: str, path: Path, place: Path) -> Row:
    out, spent = place / f"out-{number}", place / "spent.json"
    more = [*BAKE, "--out", str(out)] if command == "bake" else []
    began = time.perf_counter()
    process = subprocess.run(
        [sys.executable, "-c", MEASURED, str(spent), command, str(path), "--size", "300 mm", *more],
        capture_output=True, text=True, timeout=120, env={**os.environ},
    )  # fmt: skip
    wall_s = time.perf_counter() - began
    processor_s, peak_mb = json.loads(spent.read_text())
    count = len(list(out.iterdir())) if out.is_dir() else 0
    said = process.stderr if process.returncode or command == "bake" else process.stdout
    return Row(number, command, process.returncode, wall_s, processor_s, peak_mb, count, said)


if __name__ == "__main__":
    for row in rows(Path(sys.argv[1]), map(int, sys.argv[2:])):
        line = " | ".join(row.said.splitlines()) if row.command == "bake" else ""
        print(f"{row.number:02d} {row.command:8}{row.code:2} {row.processor_s:5.2f} CPU-s {row.wall_s:5.1f} s "
              f"{row.peak_mb:5.0f} MB {row.files} files  {line[:150]}", flush=True)  # fmt: skip
