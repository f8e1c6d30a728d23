#!/usr/bin/env python3
"""Holds the source tree to its module order.

A folder is a module, and a module includes only what the table below allows it: everything under it, nothing above it or
beside it. Also checked: detail/ headers are used by their own module alone, the libraries that CMake links agree with the
includes, every header has `#pragma once`, no header has grown long without a reason, third-party headers stay where they
belong, and the library has no thread_local data. Prints `file:line: problem` for each finding.

Example:
  scripts/check_layers.py               check the tree that this script lies in
  scripts/check_layers.py --root DIR    check another one

Exit code: 0 nothing found, 1 findings.
"""

import argparse
import re
import sys
from pathlib import Path

# For each module, the modules that it may include; it may always include itself.
LAYERS = {}


def module(name, *below):
    """Enters a module, which may include the modules `below` and all that these may include."""
    allowed = []
    for other in below:
        allowed += [m for m in [*LAYERS[other], other] if m not in allowed]
    LAYERS[name] = allowed


module("core")
module("numerics", "core")
module("mesh", "numerics")
module("query", "mesh")
module("broadphase", "query")
module("culling", "query")
module("narrowphase", "query")
module("pipelines", "broadphase", "culling", "narrowphase")
module("distributed", "pipelines")
module("distributed/mpi", "distributed")
module("io", "pipelines")
module("capi", "pipelines")
module("paper2011", "io")
module("peers", "pipelines")
module("oracle/cases", "culling", "narrowphase")
module("oracle/judge", "pipelines", "oracle/cases")
module("oracle", "pipelines")
module("simulation", "io")
module("experiments", "io", "paper2011", "simulation", "oracle/judge", "distributed")
module("pictures", "experiments")
module("report", "pictures")
module("program", "report", "peers")
module("program/volccd_mpi", "program", "distributed/mpi")

# The rooms of a module, from the lowest to the highest; "" is the module's own folder with its detail/. A room includes
# only what is not above it.
ROOMS = {
    "query": ["", "roles"],
    "culling": ["", "csat", "assignment", "o_set", "stars", "flood", "filters"],
    "narrowphase": ["", "exact", "inclusion", "cubic", "overlap"],
    "io": ["", "hdf5", "sequence"],
}
MAX_DETAIL_FILES = 12

PROGRAM = ["paper2011", "peers", "oracle", "oracle/cases", "oracle/judge", "simulation", "experiments", "pictures", "report",
           "program", "program/volccd_mpi"]
# `capi` stores messages of errors by thread, as nothing of the library for C++ may.
BINDINGS = ["capi"]
LIBRARY = [name for name in LAYERS if name not in PROGRAM + BINDINGS]
# Folders that use the modules, and are not modules themselves.
USERS = {"tests": list(LAYERS), "examples": LIBRARY + ["program"],
         "python": LIBRARY + ["paper2011", "peers", "experiments", "program"]}

# Files of experiments/ that may use the judges, for `volccd verify` only.
ORACLE_USERS = re.compile(r"^experiments/((.*/)?verify[^/]*|verify/.*)$")

# For each prefix of third-party headers: the folders that may include them, and whether public headers may do so, too;
# otherwise only sources, detail/ and -inl.hpp may.
THIRD_PARTY = {
    "tbb/": (["core", "peers"], False),  # only the executor creates threads; Embree's threads are oneTBB's
    # one binary serves every CPU, so that vector widths are never in an interface
    "hwy/": (["numerics", "mesh", "query", "broadphase", "culling", "narrowphase", "simulation", "oracle/cases"],
             False),
    "hdf5.h": (["io", "experiments"], False),
    "mpi.h": (["distributed/mpi", "program/volccd_mpi"], True),  # a rank is made from the caller's communicator
    "fcl/": (["oracle", "peers"], False),
    "embree3/": (["peers"], False),
    "BulletCollision/": (["peers"], False),
    "CGAL/": (["peers"], False),
    "ccd/": (["oracle", "culling", "broadphase"], False),
    "png.h": (["pictures"], False),
    "zlib.h": (["report"], False),
    "gtest/": ([], False),
    "pybind11/": ([], False),  # only python/ may include it
    "Python.h": ([], False),
}

MAX_HEADER_LINES = 200
# Headers that may be longer, each with its reason.
LONG_HEADERS = {
    "narrowphase/inclusion/detail/motion_piece-inl.hpp": "definitions, not declarations: a source file but for inlining",
    "tests/broadphase/support.hpp": "one oracle and its collectors, read together by every broad-phase test",
}

SOURCE_SUFFIXES = {".hpp", ".cpp", ".h"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
THREAD_LOCAL = re.compile(r"^(?!\s*//).*\bthread_local\b")
MODULE_CALL = re.compile(r"^\s*volccd_module\((\w+)([^)]*)\)", re.MULTILINE)
# Libraries that the executable of a module links in addition.
EXECUTABLE_CALL = re.compile(r"^\s*target_link_libraries\(volccd_executable([^)]*)\)", re.MULTILINE)


def owner(path):
    """Module or user folder of a path relative to the root (posix text), or None."""
    for name in sorted([*LAYERS, *USERS], key=len, reverse=True):
        if path.startswith(name + "/"):
            return name
    return None


def may_use_detail(path, header_module):
    """detail/ is for the module itself, modules in folders of its folder, its own tests, and benchmarks. The adaptors of
    other libraries read elements and write pairs as the broad phases do."""
    return (path.startswith((f"{header_module}/", f"tests/{header_module}/", "tests/benchmarks/"))
            or (header_module == "broadphase" and path.startswith("peers/")))


def room(path, module):
    folder = path[len(module) + 1:].rpartition("/")[0].split("/")[0]
    return "" if folder == "detail" else folder


def room_problem(path, target):
    """Problem with an include between rooms of one module, or None."""
    module = owner(path)
    if module != owner(target) or module not in ROOMS:
        return None
    rooms, user, used = ROOMS[module], room(path, module), room(target, module)
    if rooms.index(user) >= rooms.index(used):
        return None
    return f"{module}/{user} may not include {module}/{used} (<volccd/{target}>)"


def is_interface(path):
    """Public headers. An -inl.hpp is included by sources only."""
    return path.endswith(".hpp") and not path.endswith("-inl.hpp") and "/detail/" not in path


def check_project_include(path, target, root):
    """Problem with including <volccd/target> from path, or None."""
    if not (root / target).is_file():
        return f"<volccd/{target}> does not exist"
    user, module = owner(path), owner(target)
    if module is None or module in USERS:
        return f"<volccd/{target}> is not part of a module"
    if problem := room_problem(path, target):
        return problem
    if "/detail/" in target and not may_use_detail(path, module):
        return f"<volccd/{target}> is a detail of {module}"
    if target.endswith("-inl.hpp") and is_interface(path):
        return f"<volccd/{target}> is compiled once for each instruction set: it may not be in a public header"
    if module == user or module in {**LAYERS, **USERS}.get(user, []):
        return None
    if module == "oracle" and ORACLE_USERS.match(path):
        return None
    return f"{user} may not include {module} (<volccd/{target}>)"


def check_third_party(path, target):
    user = owner(path)
    if user in USERS:
        return None
    for prefix, (modules, in_headers) in THIRD_PARTY.items():
        if not target.startswith(prefix):
            continue
        if user not in modules:
            return f"{user} may not include <{target}>"
        if is_interface(path) and not in_headers:
            return f"<{target}> may not be in a public header"
    return None


def links(root):
    """module -> modules that its CMake target links, directly or through others."""
    names = {"volccd_" + module.split("/")[-1]: module for module in LAYERS}
    direct = {}
    for module in LAYERS:
        listing = root / module / "CMakeLists.txt"
        text = listing.read_text() if listing.is_file() else ""
        for name, arguments in MODULE_CALL.findall(re.sub(r"#.*", "", text)):
            if name == module.split("/")[-1]:
                arguments += " ".join(EXECUTABLE_CALL.findall(text))
                direct[module] = {names[word] for word in arguments.split() if word in names} - {module}
    closure = {}
    for module in direct:
        seen, todo = set(), [module]
        while todo:
            for other in direct.get(todo.pop(), ()):
                if other not in seen:
                    seen.add(other)
                    todo.append(other)
        closure[module] = seen
    return direct, closure


def check_links(root, used, closure, direct):
    for module, others in sorted(direct.items()):
        for other in sorted(others):
            if other not in LAYERS[module] and not (module == "experiments" and other == "oracle"):
                yield f"{module}/CMakeLists.txt:1: {module} may not link {other}"
    for (module, other), place in sorted(used.items()):
        if module in closure and other != module and other not in closure[module]:
            yield f"{place}: {module} includes {other}, but its CMake target does not link it"


def check_header(path, lines, long_headers):
    # An -inl.hpp is included once for each instruction set by Highway, and has an include guard of its own kind.
    if not path.endswith("-inl.hpp") and not any(re.match(r"\s*#\s*pragma\s+once\b", line) for line in lines):
        yield f"{path}:1: no #pragma once"
    if len(lines) > MAX_HEADER_LINES and path not in long_headers:
        yield (f"{path}:{len(lines)}: {len(lines)} lines, more than {MAX_HEADER_LINES}: split it, "
               "or list it in LONG_HEADERS with the reason")


def check_detail_sizes(root):
    for folder in sorted({path.parent for module in LAYERS for path in (root / module).rglob("detail/*") if path.is_file()}):
        count = sum(path.suffix in SOURCE_SUFFIXES for path in folder.iterdir())
        if count > MAX_DETAIL_FILES:
            yield f"{folder.relative_to(root).as_posix()}:1: {count} files, more than {MAX_DETAIL_FILES}: make rooms"


def check(root, long_headers):
    """All findings of a tree, and how many files and includes were looked at."""
    findings, used, files, includes = list(check_detail_sizes(root)), {}, 0, 0
    for folder in [*[m for m in LAYERS if "/" not in m], *USERS]:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in SOURCE_SUFFIXES or not file.is_file():
                continue
            path = file.relative_to(root).as_posix()
            lines = file.read_text(encoding="utf-8").splitlines()
            files += 1
            if file.suffix != ".cpp":
                findings += check_header(path, lines, long_headers)
            for number, line in enumerate(lines, 1):
                if owner(path) in LIBRARY and THREAD_LOCAL.match(line):
                    findings.append(f"{path}:{number}: thread_local: keep scratch in a workspace or with the caller")
                match = INCLUDE.match(line)
                if not match:
                    continue
                includes += 1
                quote, target = match.groups()
                place = f"{path}:{number}"
                if target.startswith("volccd/"):
                    target = target[len("volccd/"):]
                    problem = check_project_include(path, target, root)
                    if problem is None and owner(path) in LAYERS:
                        used.setdefault((owner(path), owner(target)), place)
                    if problem is None and quote == '"':
                        problem = f"write <volccd/{target}>"
                elif quote == '"' and owner(path) in LAYERS and (file.parent / target).is_file():
                    problem = f'"{target}" is relative: write <volccd/...>'
                else:
                    problem = check_third_party(path, target)
                if problem:
                    findings.append(f"{place}: {problem}")
    direct, closure = links(root)
    findings += check_links(root, used, closure, direct)
    for path in long_headers:
        if not (root / path).is_file():
            findings.append(f"scripts/check_layers.py:1: LONG_HEADERS names {path}, which is gone")
    return findings, files, includes


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parent.parent, help="tree to check")
    root = parser.parse_args().root
    findings, files, includes = check(root, LONG_HEADERS)
    for finding in findings:
        print(finding)
    print(f"check_layers: {files} files, {includes} includes, {len(findings)} findings")
    if files == 0:
        print(f"check_layers: no sources under {root}", file=sys.stderr)
        return 1
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
