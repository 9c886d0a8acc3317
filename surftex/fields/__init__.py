"""Numbers at points: profiles, noise anchored on the surface, mask expressions, images on the surface."""
