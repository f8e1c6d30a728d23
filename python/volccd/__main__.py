"""python3 -m volccd: the program."""

import sys

from ._stages import main

if __name__ == "__main__":
    sys.exit(main())
