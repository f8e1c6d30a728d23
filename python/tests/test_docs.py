"""All code for users runs: docstrings, docs/python.md, the notebook, the stubs."""

import ast
import doctest
import inspect
import json
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import volccd
from volccd import _arguments, _detect, _meshes, _records, _results, _sequences, _stages

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.usefixtures("clean_registry")


@pytest.mark.parametrize("module", [volccd, _arguments, _detect, _meshes, _records, _results, _sequences, _stages])
def test_docstrings(module):
    assert doctest.testmod(module).failed == 0


def test_everything_public_is_documented():
    for name in volccd.__all__:
        thing = getattr(volccd, name)
        if not inspect.isclass(thing) and not inspect.isfunction(thing):
            continue
        assert thing.__doc__, name
        if inspect.isclass(thing):
            for attribute, value in vars(thing).items():
                if not attribute.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
                    assert value.__doc__, f"{name}.{attribute}"


def blocks(language, page="docs/python.md"):
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)


def test_page():
    """All blocks of code, one after another, as one program."""
    pages = blocks("python")
    assert len(pages) > 8
    names, folder = {"__name__": "page"}, os.getcwd()
    os.chdir(ROOT)
    try:
        for page in pages:
            exec(compile(page, "docs/python.md", "exec"), names)
    finally:
        os.chdir(folder)


def test_readme():
    block, = blocks("python", "README.md")
    names = {}
    exec(compile(block, "README.md", "exec"), names)
    assert len(names["again"]) >= 104


def test_stages_of_the_page_keep_their_promises():
    """`check` of the program passes for the classes of the documentation, without a warning of NumPy."""
    names = {"np": __import__("numpy"), "volccd": volccd}
    source = "\n".join(blocks("python"))
    for definition in re.findall(r"^@volccd\.register\nclass .*?(?=\n\n\S|\Z)", source, re.DOTALL | re.MULTILINE):
        exec(definition, names)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for stage in ("python-spheres", "python-feature-boxes"):
            assert volccd.main(["check", stage, "--trials", "200"]) == 0, stage


def test_script_of_the_page(tmp_path):
    script, = [page for page in blocks("py")]
    file = tmp_path / "with_boxes.py"
    file.write_text(script)
    listed = subprocess.run([sys.executable, "-B", file, "stages"], text=True, capture_output=True)
    assert listed.returncode == 0 and "boxes" in listed.stdout, listed.stderr
    checked = subprocess.run([sys.executable, "-B", "-W", "error", file, "check", "boxes", "--trials", "200"], text=True,
                             capture_output=True)
    assert (checked.returncode, checked.stderr) == (0, ""), checked.stdout + checked.stderr


def test_notebook():
    """The code cells run as plain Python, without a notebook server."""
    notebook = json.loads((ROOT / "examples/python/falling_block.ipynb").read_text())
    assert notebook["nbformat"] == 4
    names = {"__name__": "notebook"}
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) >= 5
    for number, cell in enumerate(cells):
        exec(compile(cell, f"cell {number}", "exec"), names)
    assert 0 < min(names["safe"]) < 1 and names["x"][names["falling"]][:, 2].min() > 1  # it came near, and not in


def parameters(node):
    a = node.args
    return [arg.arg for arg in (*a.posonlyargs, *a.args, *a.kwonlyargs)] + ([a.kwarg.arg] if a.kwarg else [])


def check_signature(node, function, name):
    assert parameters(node) == list(inspect.signature(function).parameters), name


@pytest.mark.parametrize("module", [volccd, volccd.distributed], ids=lambda module: module.__name__)
def test_stubs(module):
    tree = ast.parse(Path(module.__file__).with_suffix(".pyi").read_text())
    names = set()
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            names.add(node.name)
            check_signature(node, getattr(module, node.name), node.name)
        elif isinstance(node, ast.ClassDef):
            names.add(node.name)
            stubbed = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
            type_ = getattr(module, node.name)
            for item in node.body:
                if isinstance(item, ast.FunctionDef):
                    value = inspect.getattr_static(type_, item.name)
                    if inspect.isfunction(value):
                        check_signature(item, value, f"{node.name}.{item.name}")
            public = {n for n, v in vars(type_).items() if not n.startswith("_") and inspect.isfunction(v)}
            assert public <= stubbed, f"{node.name}: {public - stubbed}"
        elif isinstance(node, ast.AnnAssign):
            names.add(node.target.id)
        elif isinstance(node, ast.ImportFrom):
            names |= {alias.asname for alias in node.names if alias.asname}
    assert set(module.__all__) <= names, set(module.__all__) - names
