"""Light leaving a surface: GGX over Lambert, lit by lamps with shadows, mirroring boxes blurred by roughness."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.kernels.pool import slices
from surftex.preview.studio import Lamps, Studio, mirrored

_MAP_PX = 1024
_GRAZING = np.float32(0.12)
"""Least cosine between what shades and the eye."""
_HORIZON = np.float32(0.01)
"""Least height of what is mirrored above the plane of the mesh."""


@dataclass(frozen=True, eq=False)
class Lit:
    """A scene with its lamps lit.

    Attributes
    ----------
    studio : Studio
        The lamps' kind.
    lamps : Lamps
        Where they are.
    up : (3,) float64
        Where the ceiling is.
    centre : (3,) float64
        Middle of the scene.
    scale : float
        Shadow pixels in a millimetre.
    depth : (l, s, s) float32
        What each lamp sees.
    """

    studio: Studio
    lamps: Lamps
    up: NDArray[np.float64]
    centre: NDArray[np.float64]
    scale: float
    depth: NDArray[np.float32]

    def gather(
        self, point: NDArray[np.float64], normal: NDArray[np.float32], facing: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Collect light at points.

        Parameters
        ----------
        point : (n, 3) float
            Millimetres.
        normal : (n, 3) float
            That shade.
        facing : (n, 3) float
            Shading normals of the mesh itself, without its normal map.

        Returns
        -------
        light : (n, g) float32
            Irradiance over pi, from each box and from the room.
        seen : (n, g) float32
            Share of it that is in sight.
        """
        from surftex.kernels.view import lamp_light

        groups = len(self.studio.boxes) + 1
        light, seen = np.zeros((len(point), groups), np.float32), np.zeros((len(point), groups), np.float32)
        place = np.ascontiguousarray(point - self.centre, dtype=np.float32)
        normal, facing = (np.ascontiguousarray(v, dtype=np.float32) for v in (normal, facing))
        slack = 1.6 / self.scale

        def work(first: int, last: int) -> None:
            lamp_light(
                place[first:last], normal[first:last], facing[first:last], self.lamps.frame, self.lamps.share,
                self.lamps.group, self.scale, self.depth, slack, light[first:last], seen[first:last],
            )  # fmt: skip

        slices(work, len(place), size=32768)
        count = np.bincount(self.lamps.group, minlength=groups).astype(np.float32)
        count[-1] *= 0.5
        return light, np.minimum(seen / count, 1)


def lit(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int32],
    studio: Studio,
    lamps: Lamps,
    up: NDArray[np.float64],
    shown: NDArray[np.float64],
) -> Lit:
    """Draw the shadows.

    Parameters
    ----------
    vertices : (n, 3) float64
        Of everything that throws one.
    faces : (m, 3) int32
        Triangles.
    studio : Studio
        The lamps' kind.
    lamps : Lamps
        Where they are.
    up : (3,) float
        Where the ceiling is.
    shown : (p, 3) float64
        Points that are to be lit: shadows are drawn as finely as these lie close together.

    Returns
    -------
    lit : Lit
        Ready to gather.
    """
    from surftex.kernels.view import lamp_depths

    centre = 0.5 * (shown.min(axis=0) + shown.max(axis=0))
    place = np.ascontiguousarray(vertices - centre)
    radius = max(float(np.linalg.norm(shown - centre, axis=1).max()), 1e-6)
    scale = 0.49 * _MAP_PX / radius
    depth = np.full((len(lamps.frame), _MAP_PX, _MAP_PX), -1e30, np.float32)
    faces = np.ascontiguousarray(faces, dtype=np.int32)
    slices(
        lambda a, b: lamp_depths(place, faces, lamps.frame[a:b], scale, depth[a:b]), len(lamps.frame), size=4
    )
    return Lit(studio, lamps, up, centre, scale, depth)


def shaded(
    scene: Lit,
    material: NDArray[np.float32],
    point: NDArray[np.float64],
    normal: NDArray[np.float32],
    facing: NDArray[np.float32],
    to_eye: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Shade points.

    Parameters
    ----------
    scene : Lit
        The lamps.
    material : (n, 13) float32
        As in `surftex.preview.bodies`; the last is the length of the blended normal: a short one is rough.
    point : (n, 3) float
        Millimetres.
    normal : (n, 3) float32
        Unit vectors that shade.
    facing : (n, 3) float32
        Unit shading normals of the mesh itself, without its normal map.
    to_eye : (n, 3) float32
        Unit vectors to the camera.

    Returns
    -------
    color : (n, 3) float32
        Linear radiance.
    """
    base, occlusion, roughness, metallic = material[:, :3], material[:, 3:4], material[:, 4], material[:, 5:6]
    f0 = material[:, 6:9] * (1 - metallic) + base * metallic
    shorter = np.clip(material[:, 12], 0.05, 1.0)
    alpha = np.sqrt(np.clip(roughness, 0.03, 1) ** 4 + np.minimum((1 - shorter) / shorter, 0.5))
    alpha = np.minimum(alpha, 1.0).astype(np.float32)
    normal = _towards(normal, to_eye)
    light, seen = scene.gather(point, normal, facing)
    colors = np.array([box.color for box in scene.studio.boxes] + [(1.0, 1.0, 1.0)], np.float32)
    open_room = (light * np.array([1.0] * len(scene.studio.boxes) + [0.0], np.float32)) @ colors
    open_room *= np.sqrt(occlusion)
    diffuse = open_room + light[:, -1:] * colors[-1] * occlusion
    normal = _mirroring(normal, facing, to_eye)
    cosine = np.clip((normal * to_eye).sum(axis=1), 0.03, 1.0)
    mirror = 2 * (normal * to_eye).sum(axis=1)[:, None] * normal - to_eye
    blurred = mirrored(scene.studio, scene.lamps, scene.up, mirror.astype(np.float32), 0.06 + 1.15 * alpha)
    shine = np.zeros_like(diffuse)
    for number, radiance in enumerate(blurred):
        cover = seen[:, number] if number < len(scene.studio.boxes) else seen[:, number] * occlusion[:, 0]
        shine += (radiance * cover)[:, None] * colors[number]
    scale, offset = _environment(cosine, alpha)
    specular = (f0 * scale[:, None] + offset[:, None]) * shine * np.minimum(1, occlusion + 0.3)
    rest = 1 - np.clip(f0 + (1 - f0) * (1 - cosine[:, None]) ** 5 * (1 - 0.8 * alpha[:, None]), 0, 1)
    return (base * (1 - metallic) * diffuse * rest + specular) * np.float32(scene.studio.exposure)


def _towards(normal: NDArray[np.float32], to_eye: NDArray[np.float32]) -> NDArray[np.float32]:
    """Turn normals back to the eye: a relief of a normal map turns away from a grazing one, which sees its near side."""
    normal = normal + np.maximum(_GRAZING - (normal * to_eye).sum(axis=1), 0)[:, None] * to_eye
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def _mirroring(
    normal: NDArray[np.float32], facing: NDArray[np.float32], to_eye: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Turn normals that mirror what lies within the mesh towards the mesh's own, until they mirror its horizon.

    With the angle t between both, and the eye at x, z in their plane, the mirror's height is x sin 2t + z cos 2t.
    """
    facing = _towards(facing, to_eye)
    height = (facing * to_eye).sum(axis=1)
    least, upright = np.minimum(_HORIZON, 0.9 * height), (normal * facing).sum(axis=1)
    low = np.flatnonzero(2 * (normal * to_eye).sum(axis=1) * upright - height < least)
    side = normal[low] - upright[low, None] * facing[low]
    side /= np.maximum(np.linalg.norm(side, axis=1), 1e-6)[:, None]
    x, z = (side * to_eye[low]).sum(axis=1), height[low]
    turn = 0.5 * (np.arctan2(x, z) + np.arccos(least[low] / np.hypot(x, z)))[:, None]
    turned = normal.copy()
    turned[low] = np.sin(turn) * side + np.cos(turn) * facing[low]
    return turned


def _environment(
    cosine: NDArray[np.float32], alpha: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Share of an even surrounding that GGX mirrors: factor of F0, and what grazing adds (Karis' fit)."""
    roughness = np.sqrt(alpha)
    r0, r1, r2, r3 = (
        1 - roughness,
        -0.0275 * roughness + 0.0425,
        -0.572 * roughness + 1.04,
        0.022 * roughness - 0.04,
    )
    a = np.minimum(r0 * r0, np.exp2(-9.28 * cosine)) * r0 + r1
    return (-1.04 * a + r2).astype(np.float32), np.maximum(1.04 * a + r3, 0).astype(np.float32)
