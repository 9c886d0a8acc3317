"""Pictures of a result: off-screen stills."""
