"""Compiled loops over arrays, and nothing else: no checks, no objects, no printing. The one door to numba."""
