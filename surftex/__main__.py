"""``python -m surftex`` is the command ``surftex``."""

import sys

from surftex.cli import process

if __name__ == "__main__":
    sys.exit(process())
