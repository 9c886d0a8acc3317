"""What a result looks like: off-screen stills and contact sheets."""
