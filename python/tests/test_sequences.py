"""Sequences, scenes by name, meshes of other packages, and the program give the same contacts."""

import csv
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import volccd

DATA = Path(os.environ.get("VOLCCD_DATA", Path(__file__).resolve().parents[3] / "shared/data"))


@pytest.fixture(scope="module")
def builtin():
    return volccd.scene("builtin")


def test_contents(builtin):
    assert builtin.frame_count == len(builtin) + 1 == len(builtin.times)
    assert np.all(np.diff(builtin.times) > 0)
    assert builtin.points(0).shape == (builtin.point_count, 3) and builtin.points(-1).shape == (builtin.point_count, 3)
    assert builtin.point_ids.tolist() == list(range(builtin.point_count))
    cells = builtin.cells(0)
    assert cells["offsets"][-1] == len(cells["connectivity"]) and len(cells["types"]) == len(cells["objects"])
    assert builtin.metadata["title"] and builtin.velocity(0) is None
    with pytest.raises(volccd.InputError, match="not run on a step"):
        volccd.Sequence(builtin.path).element_ids
    for frame in (builtin.frame_count, -builtin.frame_count - 1):
        with pytest.raises(volccd.InputError, match="frame"):
            builtin.points(frame)


def contacts_of_the_program(sequence, folder, steps):
    file = folder / "contacts.csv"
    subprocess.run([os.environ["VOLCCD_PROGRAM"], "detect", sequence.path, "--pipeline", "VolCCD+", "--steps", steps,
                    "--contacts", file], check=True, stdout=subprocess.DEVNULL)
    with open(file) as rows:
        return list(csv.DictReader(rows))


def test_contacts_are_those_of_the_program(builtin, tmp_path):
    expected = contacts_of_the_program(builtin, tmp_path, "0:3")
    found = []
    for step, result in builtin.detect(range(3)):
        for contact in result.contacts:
            ids = builtin.point_ids[contact["vertices"]].tolist()
            found.append((step, int(contact["kind"]), ids, float(contact["toi"])))
    assert len(found) == len(expected) > 500
    names = list(expected[0])
    for row, (step, kind, ids, toi) in zip(expected, found):
        assert int(row["step"]) == step and row[names[1]].lower() == ("vf", "ee")[kind]
        assert [int(row[name]) for name in names[2:6]] == ids and float(row["toi"]) == toi


def test_cells_and_points_go_into_detect(builtin):
    (_, expected), = builtin.detect([2])
    cells = builtin.cells(3)
    found = volccd.detect(builtin.points(2), builtin.points(3), cells)
    assert np.array_equal(found.contacts["vertices"], expected.contacts["vertices"])
    assert np.array_equal(found.contacts["toi"], expected.contacts["toi"])


def test_steps_in_any_order(builtin):
    forwards = dict((step, len(result)) for step, result in builtin.detect())
    backwards = dict((step, len(result)) for step, result in builtin.detect(reversed(range(len(builtin)))))
    assert forwards == backwards and len(forwards) == len(builtin)
    with pytest.raises(volccd.InputError):
        list(builtin.detect([len(builtin)]))


def test_bad_files(tmp_path):
    for name, error in ((tmp_path / "absent.vtkhdf", volccd.InputError), (__file__, volccd.InputError)):
        with pytest.raises(error) as caught:
            volccd.Sequence(name)
        assert str(name) in str(caught.value) and caught.value.source == str(name)
    with pytest.raises(volccd.ConfigError, match="surface"):
        volccd.Sequence(volccd.scene("builtin").path, shells="thin")


def test_scenes_do_not_simulate_unasked(monkeypatch, tmp_path):
    monkeypatch.setenv("VOLCCD_CACHE", str(tmp_path))
    assert {"builtin", "octopi", "liver-quick"} <= volccd.scenes().keys()
    with pytest.raises(volccd.InputError, match="simulate=True"):
        volccd.scene("octopi")
    with pytest.raises(volccd.ConfigError, match="octopi"):
        volccd.scene("octopy")
    assert not list(tmp_path.iterdir())
    assert len(volccd.scene("builtin")) > 0


INTERRUPTED_BAKE = """
import volccd
try:
    print("ready", flush=True)
    volccd.scene("octopi", simulate=True, threads=1)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_ctrl_c_ends_a_simulation(tmp_path):
    child = subprocess.Popen([sys.executable, "-B", "-c", INTERRUPTED_BAKE], stdout=subprocess.PIPE, text=True,
                             env={**os.environ, "VOLCCD_CACHE": str(tmp_path)})
    assert child.stdout.readline() == "ready\n"
    try:
        child.wait(1)
    except subprocess.TimeoutExpired:
        child.send_signal(signal.SIGINT)
    try:
        assert child.communicate(timeout=60)[0] == "interrupted\n"
    finally:
        child.kill()


@pytest.mark.parametrize("name", ["ls-dyna-projectile", "rod-twist"])
def test_real_sequences(name):
    if not (DATA / f"{name}.vtkhdf").exists():
        pytest.skip(f"{name} is not there: put the shared data beside the project, or set VOLCCD_DATA")
    sequence = volccd.Sequence(DATA / f"{name}.vtkhdf")
    (_, found), = sequence.detect([0])
    assert len(found) > 0 and found.statistics["contacts"] == len(found)


def test_motions_and_objects(builtin):
    path = builtin.path
    (_, straight), = builtin.detect([2])
    (_, curved), = volccd.Sequence(path, motion="quadratic").detect([2])
    assert len(curved) > 0 and not np.array_equal(curved.contacts["toi"], straight.contacts["toi"])
    with pytest.raises(volccd.InputError, match="velocit"):
        volccd.Sequence(path, motion="tentative")
    (_, between), = volccd.Sequence(path, objects="components").detect([2], pairs="inter")
    assert 0 < len(between) <= len(straight)


def test_thickened_shells_of_a_file():
    if not (DATA / "openradioss-airbag.vtkhdf").exists():
        pytest.skip("openradioss-airbag is not there: put the shared data beside the project, or set VOLCCD_DATA")
    sequence = volccd.Sequence(DATA / "openradioss-airbag.vtkhdf", shells="solid")
    assert sequence.thickness(0).shape == sequence.cells(0)["types"].shape
    (_, result), = sequence.detect([60])
    (_, kept), = sequence.detect([60], shell_neighbours=True)
    stem = kept.contacts["vertices"] // 3
    second = np.where(kept.contacts["kind"] == volccd.VF, 1, 2)
    neighbours = np.zeros(len(kept), bool)
    for i in range(4):
        for j in range(i + 1, 4):
            neighbours |= (i < second) & (second <= j) & (stem[:, i] == stem[:, j])
    assert 0 < neighbours.sum() < len(kept)
    assert np.array_equal(result.contacts, kept.contacts[~neighbours])
    assert volccd.verify(sequence, [0], fcl=False, threads=2)


def test_verify(builtin):
    verdict = volccd.verify(builtin, range(2), fcl=False)
    assert verdict and verdict.clean and not verdict.differing and len(verdict.steps) == 2
    assert verdict.steps[0]["contacts"] == 104
    names = {one["pipeline"] for one in verdict.steps[0]["pipelines"]}
    assert {"NavCCD", "HashCCD", "VolCCD", "VolCCD+"} <= names


def test_meshio(falling):
    meshio = pytest.importorskip("meshio")
    points0, points1, cells = falling
    expected = volccd.detect(points0, points1, cells)
    before = meshio.Mesh(points0, [("tetra", cells)])
    for after in (meshio.Mesh(points1, [("tetra", cells)]), points1):
        assert np.array_equal(volccd.detect(before, after).contacts["toi"], expected.contacts["toi"])
    assert len(volccd.Detector(before).step(points0, points1)) == len(expected)
    faces = [[c[[0, 1, 2]], c[[0, 1, 3]], c[[0, 2, 3]], c[[1, 2, 3]]] for c in cells[1:]]
    two = meshio.Mesh(points0, [("tetra", cells[:1]), ("polyhedron4", faces)])
    assert len(volccd.detect(two, points1)) == len(expected)


class FakeGrid:
    """The attributes of pyvista.UnstructuredGrid that are used."""

    def __init__(self, points, cells):
        self.points, self.n_cells = points, len(cells)
        self.celltypes = np.full(len(cells), 10, np.uint8)
        self.cell_connectivity, self.offset = cells.ravel(), np.arange(0, 4 * len(cells) + 1, 4)


def test_pyvista(falling):
    points0, points1, cells = falling
    expected = volccd.detect(points0, points1, cells)
    found = volccd.detect(FakeGrid(points0, cells), FakeGrid(points1, cells))
    assert np.array_equal(found.contacts["toi"], expected.contacts["toi"])
    assert len(volccd.Detector(FakeGrid(points0, cells)).step(points0, points1)) == len(expected)
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.UnstructuredGrid({10: cells}, points0)
    assert len(volccd.detect(grid, points1)) == len(expected)
