"""Drives a batch from Python, with a callback: `python examples/drive_a_batch.py JOBS.toml`.

Every finished job is told with its seams and its size on disk; a job that fails does not stop the others. Run again, it
does what is missing.
"""

import json
import sys
from pathlib import Path

from surftex.bake.batch import JobResult, run_batch
from surftex.bake.executors import local_workers
from surftex.errors import SurftexError
from surftex.recipe.batch import load_batch


def told(result: JobResult, count: int, total: int) -> None:
    """Say how a job ended."""
    start = f"{count} of {total}: {result.name}: {result.state}"
    if result.state in ("failed", "not started"):
        print(f"{start}: {result.reason}")
        return
    folder = Path(result.folder)
    report = json.loads((folder / "report.json").read_text("utf-8"))
    size = sum(file.stat().st_size for file in folder.iterdir()) / 2**20
    print(f"{start}, {result.wall_s:.1f} s, seams {report['seam']['rms']:.4f} of the range, {size:.1f} MiB")


def main() -> int:
    """Do the jobs, and give the command's exit code."""
    if len(sys.argv) != 2:
        print(f"usage: {sys.argv[0]} JOBS.toml", file=sys.stderr)
        return 2
    try:
        with local_workers() as workers:
            return run_batch(load_batch(sys.argv[1]), workers, keep_going=True, told=told).exit_code
    except SurftexError as problem:
        print(problem, file=sys.stderr)
        return problem.exit_code


if __name__ == "__main__":
    raise SystemExit(main())
