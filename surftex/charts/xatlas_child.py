"""The process that xatlas runs in: reads a mesh file of arrays, writes charts. It imports nothing of surftex.

Called as ``python xatlas_child.py INPUT.npz OUTPUT.npz``. xatlas holds the interpreter lock and cannot be
stopped, so its process can be killed instead.
"""

import sys


def main(source: str, target: str) -> None:
    """Unwrap one mesh.

    Parameters
    ----------
    source : str
        npz with `vertices` (n, 3) float32 and `faces` (m, 3) uint32.
    target : str
        npz to write: `corner_uv` (m, 3, 2) float64 in texels of xatlas' page, unmirrored, packed anyhow.
    """
    import numpy as np
    import xatlas

    with np.load(source) as data:
        vertices, faces = data["vertices"], data["faces"]
    atlas = xatlas.Atlas()
    atlas.add_mesh(vertices, faces)
    charts, packing = xatlas.ChartOptions(), xatlas.PackOptions()
    charts.fix_winding = True
    packing.rotate_charts = False
    packing.rotate_charts_to_axis = False
    packing.resolution = 1024
    packing.padding = 1
    atlas.generate(charts, packing)
    _, indices, uv = atlas[0]
    corner_uv = uv.astype(np.float64)[indices.reshape(-1, 3)] * [atlas.width, atlas.height]
    np.savez(target, corner_uv=corner_uv)


def _die_with_parent() -> None:
    """Ask Linux to end this process when its parent ends, however that happens."""
    if sys.platform == "linux":
        import ctypes
        import signal

        ctypes.CDLL(None).prctl(1, signal.SIGKILL)


if __name__ == "__main__":
    _die_with_parent()
    main(*sys.argv[1:3])
