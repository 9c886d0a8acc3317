"""Exponential function and logarithm in a nanosecond, for weights that are computed by the million.

No tables, no branches: loops over them vectorise.
"""

from surftex.kernels.jit import part

_MOST = 86.0


@part
def exponential(x):
    """Compute e^x to 1e-12 of it, x held within -86 to 86: the series of e^(x/256), squared eight times."""
    r = min(max(x, -_MOST), _MOST) * (1.0 / 256.0)
    series = 1.0 + r * (1.0 / 11.0) * (1.0 + r * (1.0 / 12.0) * (1.0 + r * (1.0 / 13.0)))
    series = 1.0 + r * (1.0 / 8.0) * (1.0 + r * (1.0 / 9.0) * (1.0 + r * (1.0 / 10.0) * series))
    series = 1.0 + r * (1.0 / 5.0) * (1.0 + r * (1.0 / 6.0) * (1.0 + r * (1.0 / 7.0) * series))
    series = 1.0 + r * (1.0 + r * 0.5 * (1.0 + r * (1.0 / 3.0) * (1.0 + r * 0.25 * series)))
    series *= series
    series *= series
    series *= series
    series *= series
    series *= series
    series *= series
    series *= series
    return series * series


@part
def logarithm_of_sum(x):
    """Compute ln x to 1e-12 for x in 1 to 16: a sum of shares of the largest of some numbers."""
    large = x > 5.66
    x = x * 0.25 if large else x
    shift = 2.0 if large else 0.0
    large = x > 2.83
    x = x * 0.5 if large else x
    shift = shift + 1.0 if large else shift
    large = x > 1.42
    x = x * 0.5 if large else x
    shift = shift + 1.0 if large else shift
    s = (x - 1.0) / (x + 1.0)
    q = s * s
    series = 1.0 / 9.0 + q * (1.0 / 11.0 + q * (1.0 / 13.0 + q * (1.0 / 15.0)))
    series = 1.0 + q * (1.0 / 3.0 + q * (1.0 / 5.0 + q * (1.0 / 7.0 + q * series)))
    return shift * 0.6931471805599453 + 2.0 * s * series
