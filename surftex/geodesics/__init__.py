"""Distances and straight lines on a surface: local exact windows, heat, point to point, tracing, directions."""
