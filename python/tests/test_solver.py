"""The solver of docs/into_a_solver.md: both versions do what the page says, and their own checks detect errors."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "examples/python/solver.py"


def rows(text):
    """The rows of the table: time, removed, contacts, shortened, height, energy."""
    return [[float(cell) for cell in line.split()] for line in text.splitlines() if re.fullmatch(r"[\s\d.+-]+", line)
            and line.strip()]


def on_the_page():
    return rows(re.search(r"^    time \[s\].*\n((?:    .*\n)+)", (ROOT / "docs/into_a_solver.md").read_text(), re.M)[1])


def by_python():
    return subprocess.run([sys.executable, "-B", SCRIPT], capture_output=True, text=True, check=True).stdout


def by_cpp():
    if "VOLCCD_SOLVER" not in os.environ:
        pytest.skip("VOLCCD_SOLVER does not name the C++ solver, which the ctest package.solver builds")
    return subprocess.run([os.environ["VOLCCD_SOLVER"]], capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("version", [by_python, by_cpp])
def test_figures(version):
    """Rounding depends on compiler and NumPy, so that later contacts differ a little."""
    found, expected = rows(version()), on_the_page()
    assert len(found) == len(expected) == 11
    for (time, removed, contacts, _, height, energy), page in zip(found, expected):
        assert (time, removed) == (page[0], pytest.approx(page[1], abs=2))
        assert contacts == pytest.approx(page[2], rel=0.1)
        assert height == pytest.approx(page[4], abs=0.01) and energy == pytest.approx(page[5], rel=0.1)
    time, removed, contacts, shortened, *_ = found[-1]
    assert time == 0.3 and removed > 0 and shortened > 0  # all branches of the loop ran, and no time was omitted


@pytest.fixture
def solver_module():
    spec = importlib.util.spec_from_file_location("solver", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_without_the_safe_step_its_check_fails(solver_module, monkeypatch, capsys):
    class Careless:
        """A detector that finds no contacts."""

        def __init__(self, detector):
            self.detector = detector

        def step(self, *points, **options):
            return self.detector.step(*points, t_max=0.0, **options)

    monkeypatch.setattr(solver_module.Solver, "respond", lambda self, time: None)
    solver = solver_module.Solver()
    solver.detector = Careless(solver.detector)
    while solver.good and solver.time < 0.1:
        solver.advance()
    assert not solver.good and re.search(r"[1-9]\d* contacts in the accepted motion", capsys.readouterr().out)


def test_without_response_the_safe_step_keeps_bodies_apart(solver_module, monkeypatch, capsys):
    monkeypatch.setattr(solver_module.Solver, "respond", lambda self, time: None)
    monkeypatch.setattr(solver_module.Solver, "stick", lambda self, contact: None)
    solver = solver_module.Solver()
    for _ in range(20):
        solver.advance()
    shown = capsys.readouterr().out
    assert solver.time < 0.01 and not re.search(r"[1-9]\d* contacts in", shown)  # the bodies stop before they touch
    assert not solver.good and "energy +" in shown  # gravity continues to act


@pytest.mark.filterwarnings("ignore:.*encountered in log")
def test_energy_and_volume_are_checked(solver_module, capsys):
    solver = solver_module.Solver()
    solver.v *= 1.2
    solver.check(solver.x)
    assert not solver.good and "0 contacts in the accepted motion, least volume 1 of" in capsys.readouterr().out
    solver = solver_module.Solver()
    solver.x[solver.cells[0, 0]] += 1.5 * (solver.x[solver.cells[0, 1:]].mean(axis=0) - solver.x[solver.cells[0, 0]])
    solver.check(solver.x)
    assert not solver.good and "least volume -" in capsys.readouterr().out
