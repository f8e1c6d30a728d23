"""volccd.distributed: ranks find the contacts of the whole mesh. Run with --rank by mpirun, once for each number of
ranks."""

import shutil
import subprocess
import sys

import numpy as np
import pytest
import volccd

EXACT = {"inclusion.undecided": "exact"}
FIRST_ID = 10**12  # ids of vertices and elements need 64 bits


def block(n):
    """Points and hexahedra of a cube of n x n x n cells."""
    grid = np.stack(np.meshgrid(*3 * [np.arange(n + 1)], indexing="ij"), -1).reshape(-1, 3)
    at = np.arange((n + 1) ** 3).reshape(3 * [n + 1])
    corners = [at[i:n + i, j:n + j, k:n + k].ravel()
               for i, j, k in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))]
    return grid.astype(float), np.stack(corners, -1)


def scene():
    """Two blocks that pass through each other, turned so that nothing is in line."""
    a, cells_a = block(3)
    b, cells_b = block(3)
    turn = np.linalg.qr(np.array([[1, 0.3, 0.2], [-0.25, 1, 0.15], [0.1, -0.2, 1]]))[0]
    b = b @ turn.T * np.sign(np.diag(turn)) + (0.3, 0.4, 3)
    points = np.concatenate([a, b])
    moved = points.copy()
    moved[len(a):] -= (0.1, 0.2, 1.3)
    cells = np.concatenate([cells_a, cells_b + len(a)])
    return points, moved, cells, np.repeat([0, 1], [len(cells_a), len(cells_b)])


class Part:
    """What a rank gives: some elements, and some vertices, without order in space."""

    def __init__(self, comm, points, cells, objects):
        random = np.random.default_rng(5)
        mine = random.integers(comm.size, size=len(cells)) == comm.rank
        self.own = np.flatnonzero(random.integers(comm.size, size=len(points)) == comm.rank)
        rows = np.concatenate([self.own, np.setdiff1d(np.unique(cells[mine]), self.own)])
        row_of = np.zeros(len(points), np.int64)
        row_of[rows] = np.arange(len(rows))
        self.mesh = (row_of[cells[mine]].reshape(-1, 8), rows + FIRST_ID, len(self.own))
        self.of_elements = {"objects": objects[mine], "ids": np.flatnonzero(mine) + FIRST_ID}


def gathered(comm, contacts):
    parts = comm.allgather(contacts)
    contacts = np.concatenate(parts)
    return contacts[np.lexsort((*contacts["vertices"].T[::-1], contacts["kind"]))]


def check_same(comm, contacts, whole, what):
    found = gathered(comm, contacts)
    assert len(found) == len(whole), (what, len(found), len(whole))
    assert np.array_equal(found["vertices"] - FIRST_ID, whole["vertices"].astype(np.int64)), what
    for name in ("kind", "toi", "normal", "point", "weights", "at_start", "gap"):
        assert found[name].tobytes() == whole[name].tobytes(), (what, name)


def run_rank():
    from mpi4py import MPI
    from volccd.distributed import Detector
    comm = MPI.COMM_WORLD
    points, moved, cells, objects = scene()
    part = Part(comm, points, cells, objects)
    detector = Detector(comm, *part.mesh, **part.of_elements, settings=EXACT)

    def both(what, x0=points, x1=moved, middle=None, **options):
        whole = volccd.detect(x0, x1, cells, objects=objects, settings=EXACT, separation=detector.separation, threads=1,
                              middle=middle, **options)
        own = [None if x is None else x[part.own] for x in (x0, x1, middle)]
        result = detector.step(*own, **options)
        check_same(comm, result.contacts, whole.contacts, what)
        return result, whole

    result, whole = both("linear", initial_overlaps=True)
    assert len(whole) > 100, len(whole)
    assert comm.allreduce(result.rank["contacts"]) == len(whole), (result.rank, len(whole))
    overlaps = np.concatenate(comm.allgather(result.initial_overlaps)) - FIRST_ID
    assert sorted(map(tuple, overlaps.tolist())) == sorted((int(a), int(b)) for a, b in whole.initial_overlaps.tolist())
    assert np.array_equal(objects[result.contacts["elements"] - FIRST_ID], result.contacts["objects"])

    touched = np.isin(whole.contacts["vertices"], part.own).any(axis=1)
    mine = detector.to_owners()
    assert np.array_equal(mine["vertices"] - FIRST_ID, whole.contacts["vertices"][touched].astype(np.int64))

    both("quadratic", middle=(points + moved) / 2 + 0.1 * np.sin(points))
    first, _ = both("first", first=True)
    assert comm.allreduce(len(first)) == 1
    detector.separation = 0.05
    both("separation")
    detector.separation = 0.0

    detector = Detector(comm, *part.mesh, **part.of_elements, settings=EXACT, separation=0.05, lists=(0.01, 10))
    reused = 0
    for i in range(20):
        parts = [points + (moved - points) * t / 20 for t in (i, i + 1)]
        result, _ = both(f"substep {i} with lists", *parts)
        reused += result.statistics["reused_steps"]
    assert reused > 5, reused
    detector = Detector(comm, *part.mesh, **part.of_elements, settings=EXACT)

    keep = np.arange(len(cells)) % 5 != 3
    cells, objects = cells[keep], objects[keep]
    part = Part(comm, points, cells, objects)
    detector.set_mesh(*part.mesh, **part.of_elements)
    both("after an edit", moved, points)

    last = comm.size - 1
    wrong = part.own.astype(float) if comm.rank == last else points[part.own]
    with pytest.raises(volccd.Error, match=f"rank {last} of {comm.size}: .*points0"):
        detector.step(wrong, moved[part.own])
    with pytest.raises(volccd.Error, match=f"rank {last} of {comm.size}: .*nonsense"):
        Detector(comm, *part.mesh, **part.of_elements, pipeline="nonsense" if comm.rank == last else "VolCCD+")
    both("after errors")
    Detector(comm, *part.mesh).step(points[part.own], moved[part.own])  # ids are numbered by the ranks
    sys.stdout.write(f"rank {comm.rank} of {comm.size} agrees\n")


@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_ranks_find_the_contacts_of_the_whole(ranks):
    pytest.importorskip("mpi4py", reason="python3-mpi4py is not installed")
    if not shutil.which("mpirun"):
        pytest.skip("there is no mpirun")
    command = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(ranks), sys.executable, "-B", __file__, "--rank"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count(f"of {ranks} agrees") == ranks


def test_without_mpi4py_it_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    with pytest.raises(volccd.ConfigError, match="python3-mpi4py"):
        volccd.distributed.Detector(None, [[0, 1, 2, 3]], range(4))


if __name__ == "__main__" and "--rank" in sys.argv:
    run_rank()
