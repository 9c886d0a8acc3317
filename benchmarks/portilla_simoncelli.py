"""Portilla and Simoncelli's texture model, as plenoptic has it: the peer that draws from statistics, and copies nothing either.

plenoptic needs PyTorch, so it is no dependency: `SURFTEX_PLENOPTIC` names a Python that has it (in a folder of its own:
``python3 -m venv peer && peer/bin/pip install plenoptic``). This file runs there too, as a script: exemplar in, picture out.

References
----------
Portilla, Simoncelli. A Parametric Texture Model based on Joint Statistics of Complex Wavelet Coefficients. IJCV 40 (2000).
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ITERATIONS = 150
"""Steps of the optimiser, each with up to 10 evaluations; more change the loss by little."""


def peer():
    """The Python that has plenoptic, or None."""
    return os.environ.get("SURFTEX_PLENOPTIC")


def draw(exemplar, seed=0):
    """A grey picture as large as its exemplar, and the CPU seconds of drawing it, imports left out."""
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "given.npy", Path(folder) / "made.npz"
        np.save(given, exemplar)
        quiet = {**os.environ, "TQDM_DISABLE": "1"}
        subprocess.run([str(peer()), __file__, given, made, str(seed)], check=True, env=quiet)
        with np.load(made) as found:
            return found["picture"], float(found["cpu_s"])


def main(given, made, seed):
    """Read an exemplar, write a picture."""
    import time

    import plenoptic
    import torch

    plenoptic.set_seed(int(seed))
    image = torch.from_numpy(np.load(given).astype(np.float32) / 255)[None, None]
    start = time.process_time()
    model = plenoptic.models.PortillaSimoncelli(tuple(image.shape[-2:]))
    loss = plenoptic.loss.portilla_simoncelli_loss_factory(model, image)
    drawn = plenoptic.Metamer(image, model, loss_function=loss)
    drawn.setup(
        (torch.rand_like(image) - 0.5) * 0.1 + image.mean(),
        optimizer=torch.optim.LBFGS,
        optimizer_kwargs={
            "max_iter": 10, "max_eval": 10, "history_size": 100, "line_search_fn": "strong_wolfe", "lr": 1,
        },
    )  # fmt: skip
    drawn.synthesize(max_iter=ITERATIONS)
    picture = np.clip(np.rint(255 * drawn.metamer.detach().numpy()[0, 0]), 0, 255).astype(np.uint8)
    np.savez(made, picture=picture, cpu_s=time.process_time() - start)


if __name__ == "__main__":
    main(*sys.argv[1:])
