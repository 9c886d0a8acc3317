"""Choosing the unwrap of a bake: the file's own where it will do, a new one where not."""

from concurrent.futures import Future, ThreadPoolExecutor
from threading import Event
from typing import Any

from surftex.bake.remembering import remembered_unwrap
from surftex.bake.stages import Stages
from surftex.charts.atlas import Atlas
from surftex.errors import InputError
from surftex.recipe.model import BakeSettings
from surftex.surface.surface import Surface


def own_uv_plan(surface: Surface, settings: BakeSettings) -> dict[str, Any] | None:
    """Tell what a bake would do with the file's own UVs.

    Parameters
    ----------
    surface : Surface
        Any.
    settings : BakeSettings
        Size of the page, and whether it may have several tiles.

    Returns
    -------
    plan : dict or None
        None where there are none; ``auto``: "keep" or "unwrap", ``keep``: "keep" or "refuse", as ``--uv auto`` and
        ``--uv keep`` would; ``why``: list of str, what speaks against them; ``mirrored``: what follows, or None.
    """
    from surftex.charts.gate import gate

    if surface.corner_uv is None:
        return None
    report = gate(surface, Atlas.of(surface, surface.corner_uv), settings.resolution, udim=settings.udim)
    return {
        "auto": "keep" if report.passed else "unwrap",
        "keep": "refuse" if report.problems else "keep",
        "why": [*report.problems, *report.flaws],
        "mirrored": report.mirrored(len(surface.faces)) if report.mirrored_faces else None,
    }


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
    threads : int, optional
        None means every core.
    remember : bool
        Take the unwrap of an earlier run where there is one, and keep this one.
    """

    def __init__(
        self, surface: Surface, settings: BakeSettings, stages: Stages, threads: int | None = None,
        *, remember: bool = False,
    ) -> None:  # fmt: skip
        self.remember = remember
        self.surface, self.settings, self.stages, self.threads = surface, settings, stages, threads
        self.cancelled = Event()
        self.pool: ThreadPoolExecutor | None = None
        self.future: Future[Atlas] | None = None
        self.own: Atlas | None = None
        self.notes: tuple[str, ...] = ()

    def __enter__(self) -> "Unwrapping":
        from surftex.charts.unwrap import XATLAS_FACES

        self._keep_own()
        one = self.settings.texels_per_mm is None
        small = one and self.settings.unwrapper == "auto" and len(self.surface.faces) <= XATLAS_FACES
        if self.own is None and ((one and self.settings.unwrapper == "xatlas") or small):
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

    def _keep_own(self) -> None:
        """Take the file's own UVs if they are wanted and will do; note why not."""
        uv = self.settings.uv
        spread = self.settings.texels_per_mm is not None
        if uv == "unwrap" or (uv == "auto" and (spread or self.surface.corner_uv is None)):
            return
        from surftex.charts.gate import USE_UNWRAP, keep_own

        with self.stages.stage("own uv"):
            try:
                self.own = keep_own(
                    self.surface,
                    resolution=self.settings.resolution,
                    udim=self.settings.udim,
                    insist=uv == "keep",
                    threads=self.threads,
                )
            except InputError as problem:
                if uv == "keep":
                    raise
                self.notes = (f"unwrapped anew: {str(problem).removesuffix(USE_UNWRAP)}",)

    def _unwrap(self, *, children: bool) -> Atlas:
        from surftex.charts.unwrap import unwrap

        with self.stages.stage("unwrap", children=children) as tick:

            def told(share: float) -> None:
                if self.cancelled.is_set():
                    raise InterruptedError
                tick(share)

            def work() -> Atlas:
                return unwrap(
                    self.surface,
                    method=self.settings.unwrapper,
                    resolution=self.settings.resolution,
                    gutter_px=self.settings.gutter,
                    texels_per_mm=self.settings.texels_per_mm,
                    tick=told,
                )

            if not self.remember:
                return work()
            return remembered_unwrap(self.surface, self.settings, work, lambda: told(0.0))
