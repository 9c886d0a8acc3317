"""`Worker`: draws recipes in the background, the newest one only: a first look, then the whole; older work is ended."""

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import SurftexError
from surftex.kernels.pool import Stopped
from surftex.preview.live import Frame, Live
from surftex.recipe.model import Recipe


class Worker:
    """Draws what was asked for last.

    Parameters
    ----------
    live : Live
        The page.
    shown : callable
        ``shown(frame)`` is called for every frame, in the worker's thread.
    troubled : callable
        ``troubled(text)`` is called with one line where a recipe cannot be drawn.
    """

    def __init__(self, live: Live, shown: Callable[[Frame], None], troubled: Callable[[str], None]) -> None:
        self.live, self._shown, self._troubled = live, shown, troubled
        self._changed = threading.Condition()
        self._stop = threading.Event()
        self._asked: tuple[Recipe, NDArray[np.float64]] | None = None
        self._working, self._ended = False, False
        self.share = 1.0
        """Finished share of the work at hand."""
        self._thread = threading.Thread(target=self._run, name="surftex-preview", daemon=True)
        self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether there is work at hand."""
        return self._working or self._asked is not None

    def ask(self, recipe: Recipe, place_mm: NDArray[np.float64]) -> None:
        """Ask for a recipe; whatever was asked for before is given up.

        Parameters
        ----------
        recipe : Recipe
            What to draw.
        place_mm : (3,) float
            What is looked at, in the frame of `Surface.vertices`: drawn first.
        """
        with self._changed:
            self._asked = (recipe, np.asarray(place_mm, np.float64))
            self._stop.set()
            self._changed.notify_all()

    def wait(self, seconds: float = 600.0) -> bool:
        """Wait until there is nothing left to do.

        Parameters
        ----------
        seconds : float
            At most.

        Returns
        -------
        done : bool
            False where time ran out.
        """
        with self._changed:
            return self._changed.wait_for(lambda: not self.busy, seconds)

    def close(self) -> None:
        """End the work and the thread."""
        with self._changed:
            self._ended = True
            self._stop.set()
            self._changed.notify_all()
        self._thread.join(30)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._working = False
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._ended or self._asked is not None)
                if self._ended or self._asked is None:
                    return
                (recipe, place), self._asked = self._asked, None
                self._working, self._stop = True, threading.Event()
                stop = self._stop
            try:
                self._draw(recipe, place, stop)
            except Stopped:
                continue
            except SurftexError as problem:
                self._troubled(str(problem))
            except Exception as problem:  # noqa: BLE001  (a window must outlive what it shows)
                self._troubled(f"{type(problem).__name__}: {problem}")

    def _draw(self, recipe: Recipe, place: NDArray[np.float64], stop: threading.Event) -> None:
        self.share = 0.0
        if self.live.effort(recipe) == "placed":
            first = self.live.first_look(recipe, place, stop=stop)
            if first is not None:
                self._shown(first)

        def tick(share: float) -> None:
            self.share = share
            if stop.is_set():
                raise Stopped

        frame: Any = self.live.draw(recipe, stop=stop, tick=tick)
        self.share = 1.0
        if not stop.is_set():
            self._shown(frame)
