"""Leather: convex plates parted by furrows, with cracks, wrinkles, pores and crowns."""
