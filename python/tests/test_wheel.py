"""python/pyproject.toml, the metadata of a wheel, matches the project. scikit-build-core is not in Debian 12, so
that the test makes its calls of CMake."""

import importlib
import re
import subprocess
from pathlib import Path

import pytest

import volccd

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(volccd.__file__).parents[2]  # the package of the build folder consists of links to the sources


@pytest.fixture(scope="module")
def metadata():
    tomllib = pytest.importorskip("tomllib")  # tomllib needs Python 3.11
    return tomllib.loads((ROOT / "python/pyproject.toml").read_text())


def test_project(metadata):
    project = metadata["project"]
    assert (project["name"], project["version"]) == ("volccd", volccd.__version__)
    assert project["license"]["text"] in (ROOT / "CITATION.cff").read_text()
    oldest = project["requires-python"].removeprefix(">= ").split(".")
    # for the interpreter that is looked for
    assert f"({', '.join(oldest)})" in (ROOT / "python/CMakeLists.txt").read_text()
    for script in project["scripts"].values():
        module, function = script.split(":")
        assert callable(getattr(importlib.import_module(module), function))
    assert "numpy" in project["dependencies"][0]


def test_build(metadata, tmp_path):
    settings = metadata["tool"]["scikit-build"]
    lists = {path: path.read_text() for path in (ROOT / "CMakeLists.txt", ROOT / "python/CMakeLists.txt")}
    text = "".join(lists.values())
    assert (ROOT / "python" / settings["cmake"]["source-dir"]).resolve() == ROOT
    for target in settings["cmake"]["targets"]:
        assert re.search(rf"add_library\({target} ", text), target
    for option in settings["cmake"]["define"]:
        assert re.search(rf"(option|set)\({option} ", text), option
    for component in settings["install"]["components"]:
        subprocess.run(["cmake", "--install", BUILD, "--component", component, "--prefix", tmp_path], check=True,
                       stdout=subprocess.DEVNULL)
    package, = tmp_path.rglob("volccd")
    names = {path.name for path in package.iterdir()}
    assert names == {path.name for path in (ROOT / "python/volccd").iterdir() if path.suffix != ".pyc"
                     and path.name != "__pycache__"} | {Path(volccd._core.__file__).name}
    assert not any(path.is_symlink() for path in package.iterdir())
