"""The mesh we walk on: welded, oriented, immutable; points on it; measures; closed-form shapes for tests."""
