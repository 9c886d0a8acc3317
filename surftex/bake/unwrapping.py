"""Choosing the unwrap of a bake: the file's own where it will do, a new one where not."""

from concurrent.futures import Future, ThreadPoolExecutor
from threading import Event
from typing import Any

from surftex.bake.stages import Stages
from surftex.charts.atlas import Atlas
from surftex.errors import InputError
from surftex.recipe.model import BakeSettings
from surftex.surface.surface import Surface


class Unwrapping:
    """An unwrap that may run beside other work; leave its ``with`` block to be rid of it.

    xatlas works in a child process, so that placing features and compiling kernels go on meanwhile; uvunwrap
    uses this process' own cores and waits its turn.

    Parameters
    ----------
    surface : Surface
        What to unwrap.
    settings : BakeSettings
        How.
    stages : Stages
        Where its time is noted.
    """

    def __init__(self, surface: Surface, settings: BakeSettings, stages: Stages) -> None:
        self.surface, self.settings, self.stages = surface, settings, stages
        self.cancelled = Event()
        self.pool: ThreadPoolExecutor | None = None
        self.future: Future[Atlas] | None = None
        self.own, self.notes = own_atlas(surface, settings)

    def __enter__(self) -> "Unwrapping":
        from surftex.charts.unwrap import XATLAS_FACES

        small = self.settings.unwrapper == "auto" and len(self.surface.faces) <= XATLAS_FACES
        if self.own is None and (self.settings.unwrapper == "xatlas" or small):
            self.pool = ThreadPoolExecutor(1, "surftex-unwrap")
            self.future = self.pool.submit(self._unwrap, children=True)
        return self

    def __exit__(self, *problem: Any) -> None:
        self.cancelled.set()
        if self.pool is not None:
            self.pool.shutdown(wait=True, cancel_futures=True)

    def atlas(self) -> Atlas:
        """Wait for the unwrap.

        Returns
        -------
        atlas : Atlas
            One that can be baked.
        """
        if self.own is not None:
            return self.own
        return self._unwrap(children=False) if self.future is None else self.future.result()

    def _unwrap(self, *, children: bool) -> Atlas:
        from surftex.charts.unwrap import unwrap

        with self.stages.stage("unwrap", children=children) as tick:

            def told(share: float) -> None:
                if self.cancelled.is_set():
                    raise InterruptedError
                tick(share)

            return unwrap(
                self.surface,
                method=self.settings.unwrapper,
                resolution=self.settings.resolution,
                gutter_px=self.settings.gutter,
                tick=told,
            )


def own_atlas(surface: Surface, settings: BakeSettings) -> tuple[Atlas | None, tuple[str, ...]]:
    """Take the file's own UVs if they are wanted and will do.

    Parameters
    ----------
    surface : Surface
        With or without UVs.
    settings : BakeSettings
        ``uv`` is ``"keep"``, ``"auto"`` or ``"unwrap"``.

    Returns
    -------
    atlas : Atlas or None
        None where a new unwrap is needed.
    notes : tuple of str
        Why the file's own were left.

    Raises
    ------
    InputError
        If they are to be kept and will not do.
    """
    if settings.uv == "unwrap":
        return None, ()
    if surface.corner_uv is None:
        if settings.uv == "keep":
            raise InputError(f"{surface.name} has no UVs to keep; leave uv at auto, or set it to unwrap")
        return None, ()
    from surftex.charts.gate import gate

    atlas = Atlas.of(surface, surface.corner_uv, gutter_px=0)
    problems = gate(surface, atlas, resolution=settings.resolution)
    if not problems:
        return atlas, ()
    if settings.uv == "keep":
        raise InputError(
            f"the UVs of {surface.name} cannot be baked: {'; '.join(problems)}. Leave uv at auto"
        )
    return None, (f"the file's own UVs were not used: {'; '.join(problems)}",)
