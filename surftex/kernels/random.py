"""Counter-based random numbers inside kernels: the same numbers as `surftex.randomness.Stream.uniform`."""

import numpy as np

from surftex.kernels.jit import kernel

_STEP, _FIRST, _SECOND = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xBF58476D1CE4E5B9),
    np.uint64(0x94D049BB133111EB),
)


@kernel
def uniform(key, counter):
    """Draw number `counter` of the stream `key` (uint64 both), in [0, 1)."""
    mixed = key + (counter + np.uint64(1)) * _STEP
    mixed = (mixed ^ (mixed >> np.uint64(30))) * _FIRST
    mixed = (mixed ^ (mixed >> np.uint64(27))) * _SECOND
    mixed = mixed ^ (mixed >> np.uint64(31))
    return np.float64(mixed >> np.uint64(11)) * 2.0**-53
