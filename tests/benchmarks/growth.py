"""How work grows, from its times at several sizes."""

import time

import numpy as np


def exponent(work, sizes):
    """Slope of log seconds over log size; the best of three runs each, on one thread, after one to warm up."""
    work(min(sizes))
    seconds = []
    for size in sizes:
        runs = []
        for _ in range(3):
            start = time.process_time()
            work(size)
            runs.append(time.process_time() - start)
        seconds.append(min(runs))
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
