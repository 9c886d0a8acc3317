"""A learnt texture on a surface: a picture of its own, read at any sample."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.charts.surface_image import SurfaceImage
from surftex.charts.surface_lattice import SurfaceLattice
from surftex.materials.composite.model import Composite
from surftex.materials.layers import Layers
from surftex.surface.points import Samples


@dataclass(frozen=True, eq=False)
class CompositePattern:
    """A drawn texture; make one with `Composite.place`.

    Attributes
    ----------
    composite : Composite
        What it is like.
    picture : SurfaceImage
        Channels side by side.
    widths : mapping of str to int
        The channels in their order, and how many numbers each has.
    features : mapping of str to structured array
        ``pixel``: place, levels and label of everything drawn.
    lattice : SurfaceLattice
        Where the pixels lie.
    label : (n,) uint8 or None
        Label of each pixel of a composite: its region.
    """

    composite: Composite
    picture: SurfaceImage
    widths: Mapping[str, int]
    features: Mapping[str, NDArray]
    lattice: SurfaceLattice
    label: NDArray[np.uint8] | None

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that `at` answers with."""
        constant = () if "roughness" in self.widths else ("roughness",)
        region = () if self.label is None else ("region",)
        return (*self.widths, *constant, "specular", *region)

    def at(self, samples: Samples) -> Layers:
        """Evaluate at samples.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.

        Returns
        -------
        layers : Layers
            The channels named by `channels`.
        """
        value = self.picture.at(samples.points, samples.footprint_mm).astype(np.float32)
        value = value.reshape(len(samples), -1)
        found, first = {}, 0
        for name, width in self.widths.items():
            found[name] = value[:, first] if width == 1 else value[:, first : first + width]
            first += width
        if self.label is not None:
            found["region"] = self.label[self.lattice.nearest(samples.points)].astype(np.int32)
        for name in self.channels:
            if name not in found:
                found[name] = np.full(len(samples), getattr(self.composite, name), np.float32)
        return Layers(found)
