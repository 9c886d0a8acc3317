"""Recipe to maps: the walk downhill, its report."""
