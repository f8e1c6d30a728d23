"""python3 -m volccd: the program."""

import sys

from ._stages import main

sys.exit(main())
