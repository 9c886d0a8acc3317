"""Generators of the meshes in this folder: `python -m meshes.make` writes every file again."""
