"""Texture models from pictures: statistics, learning, synthesis on a lattice, labels, knitting, erosion, metrics."""
