"""Layers to maps: height, tangent-space normal, colour, roughness, occlusion, displaced mesh."""
