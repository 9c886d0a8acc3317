"""The hunt, from the command line."""

import sys

from tests.fuzz.hunt import main

if __name__ == "__main__":
    sys.exit(main())
