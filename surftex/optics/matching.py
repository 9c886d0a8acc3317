"""ModelMatch: the parameters of a render model that come nearest to a sampled BRDF, by variable projection.

A model is linear in all but its shape. So its three parts are averaged over every bin for a row of shapes,
once; one matrix product gives what the best linear parameters need, for every BRDF and every shape at once.
The best shape of the row is the global optimum on it; between shapes the same products are interpolated.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.optics.brdf import Bins
from surftex.optics.shaders import Geometry, Shader, shader_named

_PER_BIN = 4
_GOLDEN = (5**0.5 - 1) / 2


@dataclass(frozen=True, eq=False)
class Matches:
    """The model that comes nearest to each of n BRDFs of three channels.

    Attributes
    ----------
    diffuse : (n, 3) float64
        Factor of the diffuse part.
    reflectance : (n,) float64
        At normal incidence (F0), 0 to 1.
    shape : (n,) float64
        As the shader has it.
    residual : (n,) float64
        Root of the squares left, as a share of the BRDF's own.
    """

    diffuse: NDArray[np.float64]
    reflectance: NDArray[np.float64]
    shape: NDArray[np.float64]
    residual: NDArray[np.float64]


def bin_geometry(bins: Bins, per_bin: int = _PER_BIN) -> Geometry:
    """Directions that stand for each bin.

    Parameters
    ----------
    bins : Bins
        Which.
    per_bin : int
        Midpoints along each of a bin's three sides.

    Returns
    -------
    geometry : Geometry
        (bins * per_bin^3,), those of a bin together.
    """
    inner = (np.arange(per_bin) + 0.5) / per_bin
    zenith = (np.arange(bins.zenith)[:, None] + inner) / bins.zenith
    turn = (np.arange(bins.azimuth)[:, None] + inner) / bins.azimuth * np.pi
    u, v, t = np.broadcast_arrays(
        zenith.reshape(bins.zenith, 1, 1, per_bin, 1, 1),
        zenith.reshape(1, bins.zenith, 1, 1, per_bin, 1),
        turn.reshape(1, 1, bins.azimuth, 1, 1, per_bin),
    )
    u, v, t = u.ravel(), v.ravel(), t.ravel()
    c, o, si, so = np.sqrt(1 - u), np.sqrt(1 - v), np.sqrt(u), np.sqrt(v)
    x, y, z = si + so * np.cos(t), so * np.sin(t), c + o
    size = np.sqrt(x * x + y * y + z * z)
    return Geometry(c, o, z / size, (si * x + c * z) / size)


@cache
def bin_parts(name: str, bins: Bins) -> NDArray[np.float64]:
    """Average a model's parts over every bin, for all its shapes.

    Parameters
    ----------
    name : str
        Of the shader.
    bins : Bins
        Which.

    Returns
    -------
    parts : (bins, 3, shapes) float64
        Diffuse, fixed and scaled part.
    """
    shader, geometry = shader_named(name), bin_geometry(bins)
    rows = [
        [part.reshape(bins.count, -1).mean(1) for part in shader.parts(shape, geometry)]
        for shape in shader.shapes
    ]
    return frozen(np.array(rows).transpose(2, 1, 0))


def match(
    shader: Shader,
    bins: Bins,
    brdf: NDArray[np.float64],
    *,
    shape: float | None = None,
    reflectance: float | None = None,
    most: float = 1.0,
    weight: NDArray[np.float64] | None = None,
) -> Matches:
    """Find the model that comes nearest to each BRDF.

    Parameters
    ----------
    shader : Shader
        The model.
    bins : Bins
        How the BRDFs are sampled.
    brdf : (n, 3, bins) float64
        Red, green, blue share shape and reflectance.
    shape, reflectance : float, optional
        To hold fixed, as when the surface is known.
    most : float
        Bound of a reflectance that is not held.
    weight : (bins,) float64, optional
        How much each bin counts; all alike without it.

    Returns
    -------
    matches : Matches
        The global optimum over the shader's shapes, refined between them.
    """
    parts = bin_parts(shader.name, bins)
    if weight is not None:
        root = np.sqrt(weight)
        parts, brdf = parts * root[:, None, None], brdf * root
    logs, steps = np.log(shader.shapes), np.arange(len(shader.shapes))
    products = (brdf.reshape(-1, bins.count) @ parts.reshape(bins.count, -1)).reshape(*brdf.shape[:2], 3, -1)
    products = np.ascontiguousarray(products.transpose(2, 0, 3, 1))
    gram = np.einsum("bps,bqs->pqs", parts, parts)
    energy = (brdf**2).sum((1, 2))

    def at(place: NDArray[np.float64]) -> tuple[NDArray, NDArray, NDArray]:
        """Best linear parameters at places (n,) between shapes: products by a cubic through four shapes."""
        first = np.clip(place.astype(np.int64) - 1, 0, len(logs) - 4)
        x, four = place - first, first[:, None] + np.arange(4)
        ends = -(x - 1) * (x - 2) * (x - 3) / 6, x * (x - 1) * (x - 2) / 6
        weights = np.stack([ends[0], x * (x - 2) * (x - 3) / 2, -x * (x - 1) * (x - 3) / 2, ends[1]], axis=1)
        own = np.einsum("pqns,ns->pqn", gram[:, :, four], weights)[..., None]
        seen = np.take_along_axis(products, four[None, :, :, None], axis=2)
        diffuse, level, cost = _solved(
            np.einsum("pnsc,ns->pnc", seen, weights)[:, :, None], own, reflectance, most
        )
        return diffuse[:, 0], level[:, 0], cost[:, 0]

    if shape is None:
        best = _solved(products, gram[:, :, None], reflectance, most)[2].argmin(1)
        low, high = np.maximum(best - 1.0, 0), np.minimum(best + 1.0, len(logs) - 1.0)
        for _ in range(20):
            left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
            lower = at(left)[2] < at(right)[2]
            low, high = np.where(lower, low, left), np.where(lower, right, high)
        place = (low + high) / 2
    else:
        place = np.full(len(brdf), np.interp(np.log(shape), logs, steps))
    diffuse, level, cost = at(place)
    left = np.sqrt(np.maximum(cost + energy, 0) / energy)
    return Matches(diffuse, level, np.exp(np.interp(place, steps, logs)), left)


def _solved(
    products: NDArray[np.float64], gram: NDArray[np.float64], reflectance: float | None, most: float
) -> tuple[NDArray, NDArray, NDArray]:
    """Best diffuse factors (n, s, c), reflectance (n, s) and cost less the BRDF's own squares (n, s).

    products (3, n, s, c): of the BRDFs with the model's parts; gram (3, 3, n or 1, s): of the parts.
    """
    (d, f, s), channels = products, products.shape[-1]
    dd, df, ds, ff, fs, ss = gram[0, 0], gram[0, 1], gram[0, 2], gram[1, 1], gram[1, 2], gram[2, 2]
    if reflectance is None:
        top = s.sum(-1) - channels * fs - ds / dd * (d.sum(-1) - channels * df)
        level = np.clip(top / np.maximum(channels * (ss - ds * ds / dd), 1e-30), 0, most)
        black = (d < (df + level * ds)[..., None]).any(-1)
        if black.any():
            level[black] = _level_beside_black(
                d[black], s[black].sum(-1), level[black], most,
                *(np.broadcast_to(each, level.shape)[black] for each in (dd, df, ds, fs, ss)),
            )  # fmt: skip
    else:
        level = np.full(d.shape[:2], float(reflectance))
    rest = d - (df + level * ds)[..., None]
    diffuse = np.maximum(rest / dd[..., None], 0)
    cost = (diffuse * (diffuse * dd[..., None] - 2 * rest)).sum(-1) - 2 * f.sum(-1) - 2 * level * s.sum(-1)
    return diffuse, level, cost + channels * (ff + 2 * level * fs + level**2 * ss)


def _level_beside_black(
    d: NDArray[np.float64], s: NDArray[np.float64], level: NDArray[np.float64], most: float,
    dd: NDArray[np.float64], df: NDArray[np.float64], ds: NDArray[np.float64], fs: NDArray[np.float64],
    ss: NDArray[np.float64],
) -> NDArray[np.float64]:  # fmt: skip
    """Reflectance (k,) where channels want less diffuse light than none: they leave the elimination, and may come back.

    d (k, c): products with the diffuse part; s (k,): with the scaled part, all channels together; the rest (k,).
    """
    channels = d.shape[1]
    for _ in range(channels + 2):
        black = d < (df + level * ds)[:, None]
        lit, back = channels - black.sum(-1), np.where(black, 0, d).sum(-1)
        top = s - channels * fs - ds / dd * (back - lit * df)
        level = np.clip(top / np.maximum(channels * ss - lit * ds * ds / dd, 1e-30), 0, most)
    return level
