"""`geodesic_distance`: how far it is along the surface, by the solver that fits.

* ``exact``: windows, exact to 1e-10; its work grows with the faces within reach, at worst with their square.
* ``heat``: two sparse solves on the whole mesh [1]_; first order: 8 % off at one edge length, 1 % at fifty.

References
----------
.. [1] Crane, Weischedel, Wardetzky. Geodesics in Heat. ACM TOG 32 (2013).
"""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.geodesics.windows import flood_points, nearest
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface
from surftex.words import sort_of

EXACT_EDGES = 20.0
"""Up to this radius in mean edge lengths windows are both faster and better than heat."""

EXACT_WINDOWS = 5e6
"""Expected windows, a quarter of faces to the power 1.5 for each source, up to which they are used at any radius."""


def geodesic_distance(
    surface: Surface,
    sources: SurfacePoints,
    at: SurfacePoints,
    radius: float | None = None,
    *,
    method: Literal["auto", "exact", "heat"] = "auto",
    threads: int | None = None,
) -> NDArray[np.float64]:
    """Measure the walking distance from the nearest of some sources.

    Parameters
    ----------
    surface : Surface
        May have borders and several components.
    sources : SurfacePoints
        At least one place to start from, anywhere on the surface.
    at : SurfacePoints
        n places to measure.
    radius : float, optional
        Millimetres to look; without it as far as the surface goes.
    method : {"auto", "exact", "heat"}
        "auto" is exact within twenty mean edge lengths, and wherever that takes no more than seconds; heat beyond.
    threads : int, optional
        None means every core; the result does not depend on it.

    Returns
    -------
    distance_mm : (n,) float64
        inf where it is farther than `radius`, or where no path leads.

    Raises
    ------
    SurfaceError
        If a point lies on a face that does not exist.
    InputError
        If there is no source, the radius is not positive, or the method is unknown.
    WorkError
        If the exact method is asked for more than it can do.
    """
    if not isinstance(surface, Surface):
        raise InputError(f"surface is {sort_of(surface)}; make a Surface of it first: surftex.load(...)")
    for name, points in (("sources", sources), ("at", at)):
        if not isinstance(points, SurfacePoints):
            raise InputError(
                f"{name} is {sort_of(points)}; it takes SurfacePoints(face, barycentric), or what "
                "surftex.surface.closest.closest_points finds"
            )
    if method not in ("auto", "exact", "heat"):
        raise InputError(f"method is {method!r}; it takes 'auto', 'exact' or 'heat'")
    if len(sources) == 0:
        raise InputError("there are no sources to measure from")
    if radius is not None and not radius > 0:
        raise InputError(f"radius is {radius}; it takes a positive length in mm, or None")
    sources.check_on(surface)
    at.check_on(surface)
    reach = np.inf if radius is None else float(radius)
    if method == "auto":
        near = reach <= EXACT_EDGES * surface.mean_edge_mm
        faces = len(surface.faces) * min(1.0, np.pi * reach**2 / surface.area_mm2)
        small = 0.25 * len(sources) * faces**1.5 <= EXACT_WINDOWS
        method = "exact" if near or small else "heat"
    if method == "heat":
        from surftex.geodesics.heat import HeatSolver

        distance = HeatSolver(surface).distance(sources, at)
        return np.where(distance <= reach, distance, np.inf)
    wanted = np.zeros(len(surface.faces), bool)
    wanted[at.face] = True
    records = flood_points(surface, sources, reach, wanted=wanted, threads=threads)
    return nearest(records, at, 1, threads=threads)[1][:, 0]
