"""examples/dolfinx: a solver on one rank and on two."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).resolve().parents[2] / "examples/dolfinx/colliding_cubes.py"

# Found and not imported: that would start MPI here, and mpirun does not start from within.
missing = [name for name in ("dolfinx", "mpi4py", "matplotlib") if not importlib.util.find_spec(name)]


def velocities(ranks, picture):
    command = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(ranks), sys.executable, "-B", EXAMPLE,
               "--cells", "4", "--picture", picture]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=240,
                          env={**os.environ, "OMP_NUM_THREADS": "1"})
    assert done.returncode == 0, done.stdout + done.stderr
    assert "touched, parted, never overlapped, and momentum was conserved" in done.stdout
    return [float(v) for v in re.search(r"ranks, \d+ steps: velocities (\S+) and (\S+)", done.stdout).groups()]


@pytest.mark.skipif(bool(missing) or not shutil.which("mpirun"), reason=f"not installed: {', '.join(missing) or 'mpirun'}")
def test_one_rank_and_two(tmp_path):
    one, two = (velocities(ranks, tmp_path / f"{ranks}.png") for ranks in (1, 2))
    # The contacts of the same positions are the same; sums over elements and ranks are rounded in another order.
    assert one == pytest.approx(two, rel=1e-6)
    assert all((tmp_path / f"{ranks}.png").read_bytes().startswith(b"\x89PNG") for ranks in (1, 2))
