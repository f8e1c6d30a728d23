"""volccd.detect and volccd.Detector: contacts, forms of cells, options, edits, errors, threads, Ctrl-C."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import volccd
from conftest import CUBE, CUBE_FACES, POINTS, TETRAHEDRA


def equal(a, b):
    return all(np.array_equal(a[name], b[name]) for name in volccd.contact_dtype.names)


def test_contact_in_the_middle(falling):
    result = volccd.detect(*falling)
    first = result.contacts[result.contacts["toi"].argmin()]
    assert first["kind"] == volccd.VF and first["vertices"].tolist() == [3, 4, 5, 6]
    assert 0.5 - 1e-9 < first["toi"] <= 0.5 and result.earliest == first["toi"]
    assert np.allclose(first["normal"], [0, 0, -1]) and np.allclose(first["point"], [0, 0, 1])
    assert first["weights"][0] == 1 and np.isclose(first["weights"][1:].sum(), 1)
    assert not first["at_start"]


def test_statistics(falling):
    result = volccd.detect(*falling)
    s = result.statistics
    assert s["contacts"] == len(result) == len(result.contacts) > 1
    assert s["steps"] == 1 and s["seconds"] > 0 and s["earliest_toi"] == result.earliest
    assert s["stages"].dtype.names[:4] == ("role", "name", "in", "out")
    assert "broad-phase" in s["stages"]["role"] and "inclusion" in s["stages"]["name"]
    assert s["vf_tests"] + s["ee_tests"] == s["stages"][s["stages"]["role"] == "narrow-phase"]["in"][0]


def test_lists_have_the_contacts_of_fresh_steps(falling):
    points, moved, cells = falling
    substeps = [points + (moved - points) * k / 20 for k in range(21)]
    fresh, listed = volccd.Detector(cells, separation=0.1), volccd.Detector(cells, separation=0.1, lists=(0.01, 8))
    reused = found = 0
    for a, b in zip(substeps, substeps[1:]):
        expected, result = fresh.step(a, b), listed.step(a, b)
        assert np.array_equal(expected.contacts, result.contacts)
        reused += result.statistics["reused_steps"]
        found += len(result)
    assert reused >= 16 and found > 0
    volccd.Detector(cells, lists="auto").step(points, moved)
    for bad in ("on", (-1, 2), (1, float("nan"))):
        with pytest.raises(volccd.ConfigError, match="lists"):
            volccd.Detector(cells, lists=bad)


def test_gaps(falling):
    points, moved, cells = falling
    result = volccd.Detector(cells, separation=0.2).step(points, points + (moved - points) * 0.49, ends=True)
    assert len(result.ends) == len(result) > 0
    assert (result.contacts["gap"] <= 0.2 * (1 + 1e-6)).all()
    assert np.allclose(np.linalg.norm(result.ends["first"] - result.ends["second"], axis=1), result.ends["gap"])
    assert len(volccd.Detector(cells, separation=0.1).step(points, moved).ends) == 0


def test_arrays_outlive_the_result(falling):
    contacts = volccd.detect(*falling).contacts
    copy = contacts.copy()
    gc.collect()
    volccd.detect(*falling)
    assert equal(contacts, copy) and contacts.base is not None


def test_all_pipelines_find_the_same(falling):
    expected = volccd.detect(*falling, "BruteForce").contacts
    for name in ("NavCCD", "HashCCD", "VolCCD", "VolCCD+"):
        assert equal(volccd.detect(*falling, name).contacts, expected), name


def test_threads_find_the_same(falling):
    assert equal(volccd.detect(*falling, threads=1).contacts, volccd.detect(*falling, threads=2).contacts)


def test_first_separation_and_t_max(falling):
    all_of_them = volccd.detect(*falling)
    assert len(volccd.detect(*falling, first=True)) == 1
    assert volccd.detect(*falling, first=True).earliest == all_of_them.earliest
    assert abs(volccd.detect(*falling, separation=0.2).earliest - 0.4) < 1e-6
    assert len(volccd.detect(*falling, t_max=0.4)) == 0


def test_quadratic_motion(falling):
    points0, points1, cells = falling
    middle = points0.copy()  # the point accelerates from rest: z = 2 - 2 t^2 reaches 1 at sqrt(1/2)
    assert abs(volccd.detect(points0, points1, cells, middle=middle).earliest - 0.5 ** 0.5) < 1e-6


def test_objects_and_filters(falling):
    two = dict(objects=[0, 1])
    assert len(volccd.detect(*falling, **two, pairs="inter")) == len(volccd.detect(*falling))
    assert len(volccd.detect(*falling, **two, pairs="intra")) == 0
    assert len(volccd.detect(*falling, **two, exclude=[(0, 1)])) == 0
    with pytest.raises(volccd.ConfigError, match="inter"):
        volccd.detect(*falling, pairs="some")


NUMBERS = [  # arguments of which a part would be lost by a cast or a broadcast, and what the message says
    (dict(objects=[0, 2**32]), r"objects\[1\]: 4294967296 is not within"),
    (dict(objects=[0, 2**70]), r"objects\[1\]: 1180591620717411303424 is not within"),
    (dict(objects=np.array([0, 2**31], np.uint64)), r"objects\[1\]: 2147483648 is not within"),
    (dict(objects=[1.0, 1.9]), r"objects\[1\]: 1.9 is not an integer"),
    (dict(objects=[np.nan, 1]), r"objects\[0\]: nan is not an integer"),
    (dict(objects=[np.inf, 1]), r"objects\[0\]: inf is not within"),
    (dict(objects=[0]), r"objects: has the shape \(1,\) instead of \(2,\)"),
    (dict(objects=[[0, 1]]), r"objects: has the shape \(1, 2\)"),
    (dict(objects=[True, False]), "objects: values of type bool"),
    (dict(objects=["0", "1"]), "objects: values of type <U1"),
    (dict(objects=[0, None]), r"objects\[1\]: None is not a number"),
    (dict(ids=[0.5, 1.5]), r"ids\[0\]: 0.5 is not an integer"),
    (dict(ids=[0, 2.0**63]), r"ids\[1\]: 9.2\d+e\+18 is not within"),
    (dict(exclude=[(0, 1), (1.5, 2)]), r"exclude\[1, 0\]: 1.5 is not an integer"),
    (dict(exclude=[0, 1]), r"exclude: has the shape \(2,\)"),
    (dict(thickness=[True, True]), "thickness: values of type bool"),
    (dict(thickness=["0.1", "0.2"]), "thickness: values of type <U3"),
    (dict(thickness=[0.1]), r"thickness: has the shape \(1,\) instead of \(2,\)"),
    (dict(middle=POINTS + 1j), "middle: values of type complex128"),
]


@pytest.mark.parametrize("wrong, says", NUMBERS, ids=[says for _, says in NUMBERS])
def test_numbers_that_do_not_fit_are_refused(falling, wrong, says):
    with pytest.raises(volccd.InputError, match=says):
        volccd.detect(*falling, pairs="inter", **wrong)


def test_exact_integers_of_any_type_are_accepted(falling):
    expected = len(volccd.detect(*falling))
    for objects in (np.array([0, 1], np.uint64), [0.0, 1.0], np.array([0, 1], np.float32), [-2**31, 2**31 - 1]):
        assert len(volccd.detect(*falling, objects=objects, ids=objects, pairs="inter")) == expected
    assert len(volccd.detect(falling[0], falling[1], falling[2].astype(float))) == expected
    with pytest.raises(volccd.ConfigError, match="threads: 1.5"):
        volccd.detect(*falling, threads=1.5)


def test_initial_overlaps():
    points = np.concatenate([CUBE, CUBE * 0.5 + 0.25])
    cells = {"hexahedron": [list(range(8)), list(range(8, 16))]}
    result = volccd.detect(points, points, cells, initial_overlaps=True)
    assert result.initial_overlaps.tolist() == [(0, 1)] and result.initial_overlaps["b"][0] == 1
    assert len(volccd.detect(points, points, cells).initial_overlaps) == 0


def test_settings(falling):
    result = volccd.detect(*falling, settings=["narrow-phase=exact", "csat.axis=face"])
    assert "exact" in result.statistics["stages"]["name"]
    assert volccd.Detector(TETRAHEDRA, settings="csat.axis=face").facts["guarantee"] in ("conservative", "exact")
    with pytest.raises(volccd.ConfigError, match="csat"):
        volccd.detect(*falling, settings=["csta.axis=face"])


FORMS = {
    "array": TETRAHEDRA, "list": TETRAHEDRA.tolist(), "int32": TETRAHEDRA.astype(np.int32),
    "pairs": [("tetra", TETRAHEDRA)], "numbers": [(10, TETRAHEDRA)],
    "blocks": [("tetra", TETRAHEDRA[:1]), ("tetrahedron", TETRAHEDRA[1:])],
    "dict": {"tetra": TETRAHEDRA}, "vtk": volccd.vtk_cells(TETRAHEDRA.ravel(), [0, 4, 8], [10, 10]),
    "faces": [("polyhedron", [[cell[[0, 1, 2]], cell[[0, 1, 3]], cell[[0, 2, 3]], cell[[1, 2, 3]]]
                              for cell in TETRAHEDRA])],
}


@pytest.mark.parametrize("form", FORMS)
def test_forms_of_cells(falling, form):
    assert equal(volccd.detect(*falling[:2], FORMS[form]).contacts, volccd.detect(*falling).contacts)


@pytest.mark.parametrize("name, count", [("hexahedron", 8), ("wedge", 6), ("pyramid", 5), ("tetra", 4), ("quad", 4),
                                         ("triangle", 3)])
def test_types_of_elements(name, count):
    shapes = {"hexahedron": CUBE, "wedge": CUBE[[0, 1, 3, 4, 5, 7]], "pyramid": CUBE[[0, 1, 2, 3, 4]],
              "tetra": CUBE[[0, 1, 3, 4]], "quad": CUBE[:4], "triangle": CUBE[:3]}
    shape = shapes[name] * 0.5 + [0.2, 0.3, 2]
    floor = [[-2, -2, 0], [4, -2, 0], [-2, 4, 0]]
    points = np.concatenate([shape, floor])
    moved = points.copy()
    moved[:count, 2] -= 4
    result = volccd.detect(points, moved, [(name, [range(count)]), ("triangle", [[count, count + 1, count + 2]])])
    assert abs(result.earliest - 0.5) < 1e-6
    if count != 4:  # 4 columns are tetrahedra
        assert volccd.detect(points[:count], moved[:count], [list(range(count))]).statistics["contacts"] == 0


def test_polyhedron_is_the_hexahedron():
    points = np.concatenate([CUBE, CUBE + [0.25, 0.125, 3]])
    moved = points.copy()
    moved[8:, 2] -= 4
    hexahedra = [list(range(8)), list(range(8, 16))]
    polyhedra = [[[v + 8 * k for v in face] for face in CUBE_FACES] for k in (0, 1)]
    a = volccd.detect(points, moved, {"hexahedron": hexahedra}).contacts
    b = volccd.detect(points, moved, {"polyhedron": polyhedra}).contacts
    assert len(a) > 10 and equal(a, b)


def test_thickened_shells():
    points = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 1], [2, 1, 1], [1, 2, 1]], float)
    moved = points.copy()
    moved[3:, 2] -= 2
    cells = [[0, 1, 2], [3, 4, 5]]
    assert abs(volccd.detect(points, moved, cells).earliest - 0.5) < 1e-6
    result = volccd.detect(points, moved, cells, thickness=0.2)
    assert abs(result.earliest - 0.4) < 1e-6
    assert result.contacts["vertices"].max() >= 6  # vertices of the solids: 3 v, 3 v + 1, 3 v + 2
    detector = volccd.Detector(cells, thickness=[0.2, 0.1])
    assert abs(detector.step(points, moved).earliest - 0.425) < 1e-6
    assert detector.edit(remove=[1], add=[[3, 4, 5]], thickness=0.3).tolist() == [2]
    assert abs(detector.step(points, moved).earliest - 0.375) < 1e-6
    with pytest.raises(volccd.InputError, match="thickness"):
        detector.edit(add=[[0, 1, 5]])


def test_detector_edits(falling):
    points0, points1, cells = falling
    detector = volccd.Detector(cells, ids=[10, 20])
    expected = detector.step(points0, points1).contacts.copy()
    assert len(detector.edit(remove=[20])) == 0
    assert detector.element_count == 1 and len(detector.step(points0, points1)) == 0
    assert detector.edit(add=[[4, 5, 6, 7]], objects=3).tolist() == [21]
    assert sorted(detector.element_ids) == [10, 21]
    assert equal(detector.step(points0, points1).contacts, expected)
    detector.edit(new_vertices=1, add=[[0, 1, 2, 8]], remove=10)
    assert detector.vertex_count == 9
    points0, points1 = np.vstack([points0, [[0, 0, 1]]]), np.vstack([points1, [[0, 0, 1]]])
    assert detector.step(points0, points1).contacts["vertices"].max() == 8


def test_edit_removes_by_ids_or_mask(falling):
    for remove, left in (([False, True], [7, -1]), (np.array([True, False]), [-1, 9]), ([7.0], [-1, 9]), (9, [7, -1]),
                         ([], [7, 9]), ([False, False], [7, 9])):
        detector = volccd.Detector(falling[2], ids=[7, 9])
        detector.edit(remove=remove)
        assert detector.element_ids.tolist() == left
    with pytest.raises(volccd.InputError, match=r"remove: the mask has the shape \(1,\) instead of \(2,\)"):
        detector.edit(remove=[True])
    with pytest.raises(volccd.InputError, match=r"remove\[0\]: 0.9 is not an integer"):
        detector.edit(remove=[0.9])
    detector.edit(remove=[False, True])
    with pytest.raises(volccd.InputError, match=r"remove\[1\]: the mask selects an empty slot"):
        detector.edit(remove=[False, True])
    assert detector.element_ids.tolist() == [7, -1]


def test_refused_edit_changes_nothing(falling):
    detector = volccd.Detector(falling[2])
    expected = detector.step(*falling[:2]).contacts.copy()
    for wrong in (dict(remove=[5]), dict(remove=[0, 0]), dict(add=[[0, 1, 2, 99]]), dict(add=[[0, 1, 2, 2]]),
                  dict(add=[[0, 1, 2, 5]], ids=[1])):
        with pytest.raises(volccd.InputError):
            detector.edit(**wrong)
        assert equal(detector.step(*falling[:2]).contacts, expected), wrong


def test_layouts_of_points(falling):
    points0, points1, cells = falling
    expected = volccd.detect(points0, points1, cells).contacts
    assert equal(volccd.detect(np.asfortranarray(points0), points1.astype(np.float32), cells).contacts, expected)
    assert equal(volccd.detect(points0.tolist(), np.repeat(points1, 2, axis=0)[::2], cells).contacts, expected)


def test_errors_have_their_categories(falling):
    points0, points1, cells = falling
    assert issubclass(volccd.InputError, volccd.Error) and issubclass(volccd.InputError, ValueError)
    assert issubclass(volccd.ConfigError, volccd.Error)
    points1[2, 1] = np.nan
    with pytest.raises(volccd.InputError) as caught:
        volccd.detect(points0, points1, cells)
    assert (caught.value.source, caught.value.dataset, caught.value.index) == ("motion", "x1", 2)
    for wrong in (points0[:, :2], points0[:5], points0.ravel()):
        with pytest.raises(volccd.InputError):
            volccd.detect(points0, wrong, cells)
    with pytest.raises(volccd.ConfigError, match="VolCCD"):
        volccd.detect(points0, points0, cells, "NoSuchPipeline")
    for wrong in (dict(separation=-1), dict(separation=np.inf), dict(t_max=2), dict(edges="some"), dict(threads=-1),
                  dict(threads=10**6)):
        with pytest.raises(volccd.ConfigError):
            volccd.detect(points0, points0, cells, **wrong)


@pytest.mark.parametrize("cells", [
    [[0, 1, 2, 99]], [[0, 1, 2, -1]], [[0, 1, 2, 2]], [[0, 1]], [[0.5, 1, 2, 3]],
    [("octahedron", [[0]])], {"tetra": [[0, 1, 2]]},
    volccd.vtk_cells([0, 1, 2, 3], [0, 5], [10]), volccd.vtk_cells([0, 1, 2, 3], [0, 4, 4], [10]),
    volccd.vtk_cells([0, 1, 2, 3], [0, 4], [7]), [(10.5, [[0, 1, 2, 3]])], [("polyhedron", [[[0, 1, 2], [0, 1, 3]]])],
])
def test_bad_cells(cells):
    with pytest.raises(volccd.InputError):
        volccd.detect(POINTS, POINTS, cells)


def test_cell_types_are_not_wrapped():
    with pytest.raises(volccd.InputError, match=r"types\[0\]: 266 is not within 0 .. 255"):
        volccd.vtk_cells([0, 1, 2, 3], [0, 4], [266])
    cells = volccd.vtk_cells([0, 1, 2, 3], [0, 4], [10])
    with pytest.raises(volccd.InputError, match=r"offsets\[1\]: 4.5 is not an integer"):
        volccd.detect(POINTS, POINTS, {**cells, "offsets": [0, 4.5]})


def test_no_cells():
    assert len(volccd.detect(POINTS, POINTS, np.zeros((0, 4), int))) == 0


def grid(n, shift):
    """Hexahedra of a cube of n^3 cells, with their motion."""
    axis = np.arange(n + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3) / n + shift
    number = np.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)
    corner = lambda i, j, k: number[i:i + n, j:j + n, k:k + n].ravel()
    return points, np.stack([corner(*o) for o in [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
                                                  (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]], 1)


def colliding_grids(n):
    a, cells = grid(n, [0, 0, 0])
    b, _ = grid(n, [0.03, 0.04, 1.1])
    points = np.concatenate([a, b])
    moved = points.copy()
    moved[len(a):, 2] -= 0.6
    return points, moved, np.concatenate([cells, cells + len(a)])


def test_two_detectors_in_two_threads():
    points, moved, cells = colliding_grids(6)
    expected = volccd.detect(points, moved, {"hexahedron": cells}).contacts.copy()
    found = [None, None]

    def work(i):
        detector = volccd.Detector({"hexahedron": cells}, threads=1)
        for _ in range(3):
            found[i] = detector.step(points, moved).contacts

    threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    [t.start() for t in threads], [t.join() for t in threads]
    assert len(expected) > 100 and equal(found[0], expected) and equal(found[1], expected)


def test_gil_is_released_and_one_detector_serves_one_thread():
    points, moved, cells = colliding_grids(8)
    detector = volccd.Detector({"hexahedron": cells}, pipeline="BruteForce", threads=1)
    done, ticks = threading.Event(), 0
    thread = threading.Thread(target=lambda: (detector.step(points, moved), done.set()))
    thread.start()
    refused = False
    while not done.wait(0.001):
        ticks += 1
        if ticks == 20:
            with pytest.raises(volccd.Error, match="another thread"):
                detector.step(points, moved)
            refused = True
    thread.join()
    assert refused and ticks > 20


LONG_STEP = """
import sys, time
sys.path.insert(0, {tests!r})
import volccd
from test_detect import colliding_grids
points, moved, cells = colliding_grids(22)  # takes ten seconds or more
detector = volccd.Detector({{"hexahedron": cells}}, pipeline="BruteForce", threads=2)
print("ready", flush=True)
try:
    detector.step(points, moved)
    print("finished")
except KeyboardInterrupt:
    print("interrupted")
    few, few_moved, few_cells = colliding_grids(2)
    print(len(volccd.detect(few, few_moved, {{"hexahedron": few_cells}})) > 0)
"""


def test_ctrl_c():
    code = LONG_STEP.format(tests=os.path.dirname(__file__))
    child = subprocess.Popen([sys.executable, "-B", "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(1)  # the interruption then comes within the step
    child.send_signal(signal.SIGINT)
    start = time.monotonic()
    try:
        assert child.communicate(timeout=60)[0].split() == ["interrupted", "True"]
    finally:
        child.kill()
    assert time.monotonic() - start < 5
