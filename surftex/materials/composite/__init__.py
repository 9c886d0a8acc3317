"""Composite: a texture learnt from a photograph, drawn on the surface itself."""
