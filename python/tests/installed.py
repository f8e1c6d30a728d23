"""Run with the installed package on PYTHONPATH: the package is complete, and is not that of the build folder."""

import sys
from pathlib import Path

import volccd

prefix = Path(sys.argv[1]).resolve()
here = Path(volccd.__file__)
assert here.is_relative_to(prefix) and not here.is_symlink(), f"{here} is not in {prefix}"
assert Path(volccd._core.__file__).is_relative_to(prefix)
assert (here.parent / "__init__.pyi").is_file() and (here.parent / "py.typed").is_file()
points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, -1, 2], [2, -1, 2], [-1, 2, 2], [0, 0, 3]]
moved = [[x, y, z - 2 * (i > 3)] for i, (x, y, z) in enumerate(points)]
assert abs(volccd.detect(points, moved, [[0, 1, 2, 3], [4, 5, 6, 7]]).earliest - 0.5) < 1e-9
assert volccd.main(["--version"]) == 0
