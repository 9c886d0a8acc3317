"""The command line: each command is a call into `bake` or `preview`, and nothing is computed here."""

from surftex.cli.main import main, process

__all__ = ["main", "process"]
