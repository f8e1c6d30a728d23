"""volccd.Result as rows, frames, meshes and pickles; settings as a dict; names that are nearly right; the types."""

import copy
import os
import pickle
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest

import volccd
from conftest import CUBE

PACKAGE = Path(volccd.__file__).parent


@pytest.fixture
def result(falling):
    points, moved, cells = falling
    made = volccd.Detector(cells).step(points, moved, ends=True, initial_overlaps=True)
    assert len(made) > 5
    return made


def test_iteration(result):
    rows = list(result)
    assert len(rows) == len(result) and all(isinstance(row, volccd.Contact) for row in rows)
    for i, row in enumerate(rows):
        for name in volccd.Contact._fields:
            assert np.array_equal(getattr(row, name), result.contacts[name][i]), name
    assert result[0].vertices == rows[0].vertices and result[-1].vertices == rows[-1].vertices
    assert min(row.toi for row in result) == result.earliest
    for bad in (len(result), -len(result) - 1):
        with pytest.raises(IndexError):
            result[bad]
    assert [contact for contact in volccd.detect(CUBE, CUBE, [range(8)])] == []


def test_frame(result):
    pandas = pytest.importorskip("pandas")
    frame = result.to_frame()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == len(result)
    assert list(frame.columns) == ["kind", "a", "b", "c", "d", "toi", "nx", "ny", "nz", "px", "py", "pz", "w0", "w1", "w2", "w3",
                                   "at_start", "gap"]
    assert set(frame["kind"]) <= {"VF", "EE"} and (frame["kind"] == "VF").sum() == (result.contacts["kind"] == 0).sum()
    assert np.array_equal(frame[["a", "b", "c", "d"]].to_numpy(), result.contacts["vertices"])
    assert np.array_equal(frame[["px", "py", "pz"]].to_numpy(), result.contacts["point"])
    assert len(volccd.detect(CUBE, CUBE, [range(8)]).to_frame()) == 0


def test_frame_has_the_columns_of_contacts_csv(tmp_path):
    """As far as it has the same."""
    pandas = pytest.importorskip("pandas")
    sequence = volccd.scene("builtin")
    assert volccd.main(["detect", sequence.path, "--steps", "0", "--contacts", str(tmp_path / "c.csv"), "--quiet"]) == 0
    rows = pandas.read_csv(tmp_path / "c.csv", comment="#", float_precision="round_trip")
    (_, found), = sequence.detect([0])
    frame = found.to_frame()
    common = [name for name in frame.columns if name in rows.columns]
    assert len(common) == 13
    ids = sequence.point_ids
    for name in common:
        values = ids[frame[name].to_numpy()] if name in "abcd" else frame[name]
        assert np.array_equal(np.asarray(values), rows[name].to_numpy()), name


def test_meshio(result, tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh = result.to_meshio()
    assert np.array_equal(mesh.points, result.contacts["point"]) and mesh.cells[0].type == "vertex"
    mesh.write(tmp_path / "contacts.vtu")
    read = meshio.read(tmp_path / "contacts.vtu")
    assert np.array_equal(read.point_data["TimeOfImpact"], result.contacts["toi"])
    assert np.array_equal(read.point_data["VertexIds"], result.contacts["vertices"])
    assert np.array_equal(read.point_data["Normal"], result.contacts["normal"])


def test_pyvista(result, monkeypatch):
    """With a stand-in, because Debian 12 has no PyVista."""
    class PolyData:
        def __init__(self, points):
            self.points, self.point_data = points, {}
    monkeypatch.setitem(sys.modules, "pyvista", types.SimpleNamespace(PolyData=PolyData))
    mesh = result.to_pyvista()
    assert np.array_equal(mesh.points, result.contacts["point"])
    assert np.array_equal(mesh.point_data["Gap"], result.contacts["gap"])
    assert set(mesh.point_data) == {"Normal", "TimeOfImpact", "Kind", "AtStart", "VertexIds", "Gap"}


@pytest.mark.parametrize("module, method", [("pandas", "to_frame"), ("meshio", "to_meshio"), ("pyvista", "to_pyvista")])
def test_a_missing_package_is_named(result, monkeypatch, module, method):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=rf"Result\.{method} needs {module} \("):
        getattr(result, method)()


def test_pickles(result):
    for protocol in (2, pickle.HIGHEST_PROTOCOL):
        for again in (pickle.loads(pickle.dumps(result, protocol)), copy.copy(result), copy.deepcopy(result)):
            assert isinstance(again, volccd.Result) and len(again) == len(result)
            for name in ("contacts", "ends", "initial_overlaps"):
                mine, other = getattr(result, name), getattr(again, name)
                assert mine.dtype == other.dtype and len(mine) == len(other)
                assert all(np.array_equal(mine[field], other[field]) for field in mine.dtype.names)
            assert again.earliest == result.earliest
            assert again.statistics["contacts"] == len(result)
            assert np.array_equal(again.statistics["stages"], result.statistics["stages"])
    empty = volccd.detect(CUBE, CUBE, [range(8)])
    assert pickle.loads(pickle.dumps(empty)).earliest == np.inf


def test_a_pickle_of_another_version_is_refused(result):
    restore, arrays = result.__reduce__()
    other = np.zeros(3, [("kind", "u1")])
    with pytest.raises(volccd.InputError, match="contacts: pickled by another version"):
        restore(other, *arrays[1:])


def test_results_of_other_processes(tmp_path):
    code = "import volccd, pickle, sys; (_, r), = volccd.scene('builtin').detect([1]); pickle.dump(r, open(sys.argv[1], 'wb'))"
    subprocess.run([sys.executable, "-c", code, tmp_path / "r"], check=True)
    with open(tmp_path / "r", "rb") as file:
        again = pickle.load(file)
    (_, here), = volccd.scene("builtin").detect([1])
    assert np.array_equal(again.contacts["toi"], here.contacts["toi"])


def test_settings_as_a_dict(falling):
    settings = {"csat.axis": "optimal", "feature-filter": ["feature-kdop", "coplanarity"], "flood": None,
                "static-assignment.x": True}
    as_list = ["csat.axis=optimal", "feature-filter=feature-kdop,coplanarity", "flood=none"]
    del settings["static-assignment.x"]
    a, b = (volccd.Detector(falling[2], settings=given).facts for given in (settings, as_list))
    assert a["stages"] == b["stages"]
    assert ("feature-filter", "coplanarity") in [stage[:2] for stage in a["stages"]]
    assert len(volccd.detect(*falling, settings={"kdop-bvh.leaf_size": 4})) == len(volccd.detect(*falling))
    volccd.add_pipeline("ByDict", settings={"csat.axis": "face"}, description="x")
    try:
        assert "ByDict" in volccd.pipelines()
    finally:
        volccd.unregister("ByDict")
    with pytest.raises(volccd.ConfigError, match="settings: csat.axis: .* is no text"):
        volccd.detect(*falling, settings={"csat.axis": {"a": 1}})


@pytest.mark.parametrize("call, says", [
    (lambda *a: volccd.detect(*a, pipeline="VolCDD"), "did you mean 'VolCCD'"),
    (lambda *a: volccd.detect(*a, settings="element-culling=csatt"), "did you mean 'csat'"),
    (lambda *a: volccd.detect(*a, settings="csat.axes=optimal"), "did you mean 'axis'"),
    (lambda *a: volccd.detect(*a, settings="csat.axis=optmal"), "did you mean 'optimal'"),
    (lambda *a: volccd.detect(*a, settings="element-cullings=csat"), "did you mean 'element-culling'"),
    (lambda *a: volccd.detect(*a, pairs="itner"), "did you mean 'inter'"),
    (lambda *a: volccd.detect(*a, edges="triangulate"), "did you mean 'triangulated'"),
    (lambda *a: volccd.detect(*a, seperation=1), r"volccd\.detect\(\) has no argument 'seperation'; did you mean 'separation'"),
    (lambda *a: volccd.Detector(a[2], tickness=1), r"volccd\.Detector\(\) has no argument 'tickness'; did you mean 'thickness'"),
    (lambda *a: volccd.Detector(a[2]).step(a[0], a[1], frist=True), r"Detector\.step\(\) .*did you mean 'first'"),
    (lambda *a: volccd.scene("builtin", shels="solid"), r"volccd\.Sequence\(\) has no argument 'shels'; did you mean 'shells'"),
    (lambda *a: volccd.scene("bultin"), "did you mean 'builtin'"),
    (lambda *a: volccd.detect(*a, zzz=1), "has no argument 'zzz'$"),
])
def test_names_that_are_nearly_right(falling, call, says):
    with pytest.raises((volccd.Error, TypeError), match=says):
        call(*falling)


def test_cells_of_a_sequence_bring_objects_and_ids():
    sequence = volccd.scene("builtin")
    cells = sequence.cells(1)
    assert len(set(cells["objects"].tolist())) > 1
    detector = volccd.Detector(cells, sequence.point_count)
    assert np.array_equal(np.sort(detector.element_ids), np.sort(cells["ids"]))
    x0, x1 = sequence.points(0), sequence.points(1)
    (_, inter), = sequence.detect([0], pairs="inter")
    assert len(inter) > 0
    assert np.array_equal(volccd.detect(x0, x1, cells, pairs="inter").contacts["toi"], inter.contacts["toi"])
    assert len(volccd.detect(x0, x1, cells, pairs="inter", objects=0)) == 0  # an argument takes precedence
    plain = volccd.vtk_cells(cells["connectivity"], cells["offsets"], cells["types"])
    assert len(volccd.detect(x0, x1, plain, pairs="inter")) == 0


SAMPLE = """
import numpy as np
import volccd

x = np.zeros((8, 3))
result = volccd.detect(x, x, [[0, 1, 2, 3]], settings={"csat.axis": "optimal", "feature-filter": ["coplanarity"]})
first: volccd.Contact = result[0]
times = [contact.toi for contact in result]
total: float = sum(times) + first.gap
for step, one in volccd.Sequence("run.vtkhdf").detect(range(2), pairs="inter"):
    number: int = step + len(one)
frame = result.to_frame()
detector = volccd.Detector([[0, 1, 2, 3]], lists=(0.1, 2))
detector.separation = 0.5


@volccd.register
class Boxes(volccd.ElementCulling):
    name, guarantee = "boxes", "conservative"
"""
WRONG = {"result[0].tio": 'no attribute "tio"', "volccd.detect(x, x, seperation=1)": "seperation",
         "volccd.detect(x, x, pairs='iner')": "incompatible type", "number = result.earliest + ''": "operand"}


def test_types_by_mypy(tmp_path):
    pytest.importorskip("mypy", reason="install python3-mypy")
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
    options = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]

    def check(name, text):
        (tmp_path / name).write_text(text)
        return subprocess.run([*options, tmp_path / name], env=environment, capture_output=True, text=True)

    done = check("good.py", SAMPLE)
    assert done.returncode == 0, done.stdout + done.stderr
    for line, says in WRONG.items():
        done = check("wrong.py", SAMPLE + line + "\n")
        assert done.returncode == 1 and says in done.stdout, (line, done.stdout)


def test_stubs_by_mypy(tmp_path):
    """mypy compares the stubs with what is there at run time."""
    pytest.importorskip("mypy", reason="install python3-mypy")
    allowed, config = tmp_path / "allowed", tmp_path / "mypy.ini"
    # Modules without stubs; and a class of pybind11, which nobody makes.
    allowed.write_text("volccd\\._.*\nvolccd\\.__main__\nvolccd\\.Result\nvolccd\\.Result\\.__init__\n")
    modules = ",".join(f"volccd.{file.stem}" for file in PACKAGE.glob("_*.py") if file.stem != "__init__")
    config.write_text(f"[mypy]\nignore_missing_imports = True\n[mypy-{modules}]\nignore_errors = True\n")
    done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "volccd", "--ignore-missing-stub", "--allowlist", allowed,
                           "--ignore-unused-allowlist", "--mypy-config-file", config],
                          env={**os.environ, "MYPYPATH": str(PACKAGE.parent)}, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
