"""What sits where: points, Poisson-disk sites, Voronoi regions and graphs, curves; and who is near a sample."""
