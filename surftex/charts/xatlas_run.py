"""xatlas with a budget of time, progress and cancel: it runs in a child process that can be killed."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from surftex.errors import WorkError
from surftex.kernels.pool import Tick


def xatlas_charts(
    vertices: NDArray[np.float32],
    faces: NDArray[np.int32],
    *,
    budget_s: float,
    tick: Tick | None = None,
) -> NDArray[np.float64]:
    """Cut and flatten a mesh by xatlas.

    Parameters
    ----------
    vertices : (n, 3) float32
        Of size one or so.
    faces : (m, 3) int
        Triangles.
    budget_s : float
        Seconds of wall time; the child is killed beyond.
    tick : callable, optional
        Told the share of the budget that is used up; may raise to cancel, which kills the child.

    Returns
    -------
    corner_uv : (m, 3, 2) float64
        Charts, each at a scale of its own along u and v.

    Raises
    ------
    WorkError
        If the child fails or runs out of time, with the reason.
    """
    if not sys.executable:
        raise WorkError(
            "xatlas needs a Python interpreter to run beside this one, and sys.executable is empty"
        )
    with tempfile.TemporaryDirectory(prefix="surftex-") as folder:
        source, target, log = (Path(folder) / name for name in ("mesh.npz", "charts.npz", "log.txt"))
        np.savez(source, vertices=vertices, faces=faces.astype(np.uint32))
        script = Path(__file__).with_name("xatlas_child.py")
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        with log.open("wb") as noise:
            child = subprocess.Popen(
                [sys.executable, str(script), str(source), str(target)],
                stdin=subprocess.DEVNULL,
                stdout=noise,
                stderr=noise,
                env=environment,
            )
            started = time.monotonic()
            try:
                while True:
                    try:
                        code = child.wait(timeout=0.1)
                        break
                    except subprocess.TimeoutExpired:
                        used = (time.monotonic() - started) / budget_s
                        if used >= 1:
                            raise WorkError(f"xatlas was not done after {budget_s:g} s") from None
                        if tick:
                            tick(used)
            finally:
                if child.poll() is None:
                    child.kill()
                    child.wait()
        if code != 0 or not target.exists():
            lines = log.read_text(errors="replace").strip().splitlines()
            raise WorkError(f"xatlas failed with code {code}" + (f": {lines[-1]}" if lines else ""))
        with np.load(target) as data:
            return data["corner_uv"]
