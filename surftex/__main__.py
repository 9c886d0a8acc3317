"""``python -m surftex`` is the command ``surftex``."""

import sys

from surftex.cli import main

if __name__ == "__main__":
    sys.exit(main())
