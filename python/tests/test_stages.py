"""Stages written in Python, in all places where stages run."""

import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import volccd

pytestmark = pytest.mark.usefixtures("clean_registry")


@pytest.fixture(scope="module")
def builtin():
    return volccd.scene("builtin")


class Boxes(volccd.ElementCulling):
    """drops pairs whose swept boxes are apart

    More lines are not shown."""

    name, guarantee = "python-boxes", "conservative"
    options = {"padding": (0.0, "widens the boxes"), "active": True}

    def prepare(self, step):
        low, high = step.element_bounds()
        step.state.steps = getattr(step.state, "steps", 0) + 1
        step.state.low = np.nextafter(low - step.separation - self.padding, -np.inf)
        step.state.high = np.nextafter(high + self.padding, np.inf)

    def cull(self, step, pairs):
        low, high = step.state.low, step.state.high
        a, b = pairs[:, 0], pairs[:, 1]
        apart = (low[a] > high[b]).any(axis=1) | (low[b] > high[a]).any(axis=1)
        return ~apart | (not self.active)


class BoxFilter(volccd.FeatureFilter):
    """drops tests whose swept boxes are apart"""

    name, guarantee = "python-box-filter", "conservative"

    def filter(self, step, kind, vertices, points):
        assert points.shape[1:3] == (4, 3) and points.shape[3] == len(vertices) <= 64
        assert np.array_equal(points[0, :, :, 0], step.x0[vertices[0]])
        assert np.array_equal(points[-1, :, :, 0], step.x1[vertices[0]])
        split = 1 if kind == volccd.VF else 2
        a, b = points[:, :split], points[:, split:]
        low = np.nextafter(a.min(axis=(0, 1)) - step.separation, -np.inf) <= np.nextafter(b.max(axis=(0, 1)), np.inf)
        high = np.nextafter(b.min(axis=(0, 1)) - step.separation, -np.inf) <= np.nextafter(a.max(axis=(0, 1)), np.inf)
        return (low & high).all(axis=0)


class Sampled(volccd.NarrowPhase):
    """looks for a change of the sign of the volume at a hundred times"""

    name, guarantee, time_tolerance = "python-sampled", "approximate", 0.01

    def test(self, step, kind, vertices, points):
        n = len(vertices)
        times = np.linspace(0, 1, 101)
        x = points[0][None] + times[:, None, None, None] * (points[1] - points[0])[None]
        a, b, c = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0], x[:, 3] - x[:, 0]
        volume = np.einsum("tin,tin->tn", np.cross(a, b, axis=1), c)
        change = (volume[:-1] * volume[1:] <= 0)
        toi = np.where(change.any(axis=0), times[change.argmax(axis=0)], np.nan)
        return {"toi": toi, "normal": np.tile([0.0, 0, 1], (n, 1)), "weights": np.tile([1, 0.5, 0.25, 0.25], (n, 1))}


def contacts(sequence, steps=range(3), **options):
    return [result.contacts.copy() for _, result in sequence.detect(steps, **options)]


def same(a, b):
    return len(a) == len(b) and all(np.array_equal(x[name], y[name]) for x, y in zip(a, b) for name in x.dtype.names)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("settings", [
    "element-culling=python-boxes", "element-culling=python-boxes,csat", "feature-filter=python-box-filter",
    ["element-culling=csat,python-boxes", "feature-filter=python-box-filter,feature-kdop"]])
def test_contacts_are_those_of_the_library(builtin, threads, settings):
    volccd.register(Boxes), volccd.register(BoxFilter)
    for pipeline in ("VolCCD+", "VolCCD"):
        assert same(contacts(builtin, pipeline=pipeline, settings=settings, threads=threads), contacts(builtin))


def test_stage_runs_and_is_counted(builtin):
    volccd.register(Boxes)
    # The broad phase has already dropped pairs with disjoint boxes, so that only narrower boxes drop more.
    settings = ["broad-phase=brute-force", "element-culling=python-boxes", "python-boxes.padding=-0.05"]
    (_, result), = builtin.detect([0], settings=settings, threads=2)
    row = result.statistics["stages"][result.statistics["stages"]["name"] == "python-boxes"][0]
    assert row["in"] > row["out"] > 0 and row["seconds"] > 0
    (_, off), = builtin.detect([0], settings=["element-culling=python-boxes", "python-boxes.active=false"])
    row = off.statistics["stages"][off.statistics["stages"]["name"] == "python-boxes"][0]
    assert row["in"] == row["out"]


def test_quadratic_motion_and_separation(falling):
    volccd.register(Boxes), volccd.register(BoxFilter)
    settings = ["element-culling=python-boxes", "feature-filter=python-box-filter"]
    points0, points1, cells = falling
    for options in (dict(middle=points0), dict(separation=0.3), dict(middle=points1, t_max=0.5), dict(first=True)):
        found = volccd.detect(points0, points1, cells, settings=settings, **options)
        assert same([found.contacts], [volccd.detect(points0, points1, cells, **options).contacts]), options


def test_state_lives_from_step_to_step_and_edits_are_seen(falling):
    seen = []

    @volccd.register
    class Watcher(Boxes):
        name = "python-watcher"

        def prepare(self, step):
            super().prepare(step)
            seen.append((step.state.steps, len(step.corners), step.types.tolist(), step.objects.tolist()))

    detector = volccd.Detector(falling[2], objects=[3, 4], settings="element-culling=python-watcher")
    detector.step(*falling[:2])
    detector.edit(remove=[0], add=[("tetra", [[0, 1, 2, 3]])], objects=5)
    detector.edit(new_vertices=2, add=[("wedge", [[0, 1, 2, 3, 8, 9]])])
    x = np.vstack([falling[0], [[9, 9, 9], [9, 9, 8]]])
    detector.step(x, x)
    assert seen == [(1, 2, [10, 10], [3, 4]), (2, 3, [10, 10, 13], [5, 4, 0])]


def test_narrow_phase(builtin, falling):
    volccd.register(Sampled)
    result = volccd.detect(*falling, settings="narrow-phase=python-sampled")
    first = result.contacts[(result.contacts["vertices"] == [3, 4, 5, 6]).all(axis=1)][0]
    assert abs(first["toi"] - 0.5) < 0.011 and first["normal"].tolist() == [0, 0, 1]
    assert first["weights"].tolist() == [1, 0.5, 0.25, 0.25] and first["point"].tolist() == [0, 0, 0]
    with pytest.raises(volccd.ConfigError, match="separation"):
        volccd.detect(*falling, separation=0.1, settings="narrow-phase=python-sampled")


def test_verify_finds_a_stage_that_loses_contacts(builtin):
    volccd.register(Boxes)
    good = volccd.verify(builtin, range(2), fcl=False, settings="element-culling=python-boxes", threads=2)
    ran, = [one for one in good.steps[0]["pipelines"] if one["pipeline"] == "VolCCD+ element-culling=python-boxes"]
    assert good and "python-boxes" in ran["statistics"]["stages"]["name"]

    @volccd.register
    class Careless(volccd.ElementCulling):
        name, guarantee = "python-careless", "conservative"

        def cull(self, step, pairs):
            return pairs[:, 0] % 7 != 0

    volccd.add_pipeline("Careless", settings="element-culling=python-careless")
    verdict = volccd.verify(builtin, range(2), fcl=False)
    assert not verdict and verdict.differing == ["Careless"]
    lost = [one for one in verdict.steps[1]["pipelines"] if one["pipeline"] == "Careless"][0]
    assert len(lost["missing"]) > 0 and lost["missing"].dtype == volccd.contact_dtype


@pytest.mark.parametrize("threads", [1, 2])
def test_exceptions_come_through(builtin, threads):
    @volccd.register
    class Broken(volccd.ElementCulling):
        name = "python-broken"

        def cull(self, step, pairs):
            raise ZeroDivisionError("in the stage")

    with pytest.raises(ZeroDivisionError, match="in the stage"):
        contacts(builtin, settings="element-culling=python-broken", threads=threads)


@pytest.mark.parametrize("returned", [None, 1, [True], np.ones(3, bool), np.ones((4, 1), bool), np.ones(1) * 0.5,
                                      "keep", np.array([256]), np.array([-1])])
def test_wrong_verdicts_are_refused(falling, returned):
    @volccd.register
    class Wrong(volccd.ElementCulling):
        name = "python-wrong"

        def cull(self, step, pairs):
            return returned

    with pytest.raises(volccd.ConfigError, match="python-wrong.*cull"):
        volccd.detect(*falling, settings="element-culling=python-wrong")


@pytest.mark.parametrize("returned", [{"normal": np.zeros((1, 3))}, {"toi": np.zeros((2, 2))}, np.zeros(65)])
def test_wrong_answers_are_refused(falling, returned):
    @volccd.register
    class Wrong(volccd.NarrowPhase):
        name = "python-wrong"

        def test(self, step, kind, vertices, points):
            return returned

    with pytest.raises(volccd.ConfigError, match="python-wrong.*test"):
        volccd.detect(*falling, settings="narrow-phase=python-wrong")


def test_registration():
    with pytest.raises(volccd.ConfigError, match="csat"):
        volccd.register(type("Taken", (Boxes,), {"name": "csat"}))
    with pytest.raises(volccd.ConfigError, match="guarantee"):
        volccd.register(type("Bold", (Boxes,), {"name": "bold", "guarantee": "certain"}))
    with pytest.raises(volccd.ConfigError, match="derived"):
        volccd.register(object)
    with pytest.raises(volccd.ConfigError, match="default"):
        volccd.register(type("Odd", (Boxes,), {"name": "odd", "options": {"list": [1]}}))
    assert not {"bold", "odd"} & {stage["name"] for stage in volccd.stages()}
    volccd.register(Boxes)
    volccd.register(type("Again", (Boxes,), {"guarantee": "exact"}))
    row, = [stage for stage in volccd.stages() if stage["name"] == "python-boxes"]
    assert row["guarantee"] == "exact" and row["role"] == "element-culling"
    assert row["options"]["padding"] == {"default": "0.0", "allowed": "a number", "description": "widens the boxes"}
    volccd.add_pipeline("Mine", settings=["element-culling=python-boxes", "python-boxes.padding=0.5"])
    assert "Mine" in volccd.pipelines()
    with pytest.raises(volccd.ConfigError, match="pipeline Mine: no stage 'python-boxes'"):
        volccd.unregister("python-boxes")
    with pytest.raises(volccd.ConfigError, match="pipeline Yours: no stage 'python-bxoes'"):
        volccd.add_pipeline("Yours", settings="element-culling=python-bxoes")
    assert "Yours" not in volccd.pipelines()
    volccd.unregister("Mine"), volccd.unregister("python-boxes")
    assert "Mine" not in volccd.pipelines()


def test_options_are_checked(falling):
    volccd.register(Boxes)
    for setting, word in (("python-boxes.padding=wide", "number"), ("python-boxes.active=1", "true or false"),
                          ("python-boxes.size=1", "padding")):
        with pytest.raises(volccd.ConfigError, match=word):
            volccd.detect(*falling, settings=["element-culling=python-boxes", setting])


def test_a_running_detector_keeps_its_stage(falling):
    volccd.register(Boxes)
    detector = volccd.Detector(falling[2], settings="element-culling=python-boxes")
    volccd.unregister("python-boxes")
    assert len(detector.step(*falling[:2])) == len(volccd.detect(*falling))


def test_registration_beside_a_run(builtin):
    volccd.register(Boxes)
    done = threading.Event()
    found = []

    def work():
        found.extend(contacts(builtin, settings="element-culling=python-boxes", threads=2))
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.is_set():
        volccd.register(type("Again", (Boxes,), {}))
    thread.join()
    assert same(found, contacts(volccd.scene("builtin")))


PROGRAM = """
import sys
sys.path.insert(0, {tests!r})
import volccd
from test_stages import Boxes
volccd.register(Boxes)
volccd.add_pipeline("Boxes", settings="element-culling=python-boxes", description="boxes in Python")
sys.exit(volccd.main(sys.argv[1:]))
"""


def program(*arguments, **environment):
    code = PROGRAM.format(tests=os.path.dirname(__file__))
    return subprocess.run([sys.executable, "-B", "-c", code, *map(str, arguments)], text=True, capture_output=True,
                          env={**os.environ, **environment})


def test_program_lists_and_verifies(builtin):
    stages = program("stages")
    assert stages.returncode == 0 and "python-boxes" in stages.stdout and "boxes in Python" in stages.stdout
    verify = program("verify", builtin.path, "--steps", "0:2", "--no-fcl", "--threads", 2)
    assert verify.returncode == 0 and "clean" in verify.stdout, verify.stdout + verify.stderr
    wrong = program("detect", builtin.path, "--set", "python-boxes.padding=wide", "--pipeline", "Boxes")
    assert wrong.returncode == 2 and "number" in wrong.stderr


def test_program_checks_the_stage():
    check = program("check", "python-boxes", "--trials", 100)
    assert check.returncode == 0 and "all promises kept" in check.stdout, check.stdout + check.stderr


def test_program_takes_the_stage_into_a_table(builtin, tmp_path):
    run = program("experiment", "run", "projectile", "--pipelines", "Boxes", "--quick", "-o", tmp_path,
                  VOLCCD_DATA=str(tmp_path))  # without the LS-DYNA run, the built-in sequence is used
    assert run.returncode == 0, run.stdout + run.stderr
    assert "Boxes" in run.stdout
    rows = volccd.read_record(tmp_path / "projectile.json")["rows"]
    assert any("Boxes" in str(row) for row in rows)


def test_signals_of_python_are_kept(builtin):
    before = signal.getsignal(signal.SIGINT)
    assert volccd.main(["detect", builtin.path, "--steps", "0"]) == 0 and volccd.main(["no-such-command"]) == 2
    assert signal.getsignal(signal.SIGINT) is before
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
        for _ in range(10**6):
            pass
