#!/usr/bin/env python3
"""Everything to which the documents refer exists: links, headers and files named in `code`, stage names. Listings
are parts of tested files."""

import re
import textwrap
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")]


class Docs(unittest.TestCase):
    def test_there_are_documents(self):
        self.assertGreater(len(DOCUMENTS), 10)

    def test_links(self):
        for document in DOCUMENTS:
            prose = re.sub(r"^```.*?^```", "", document.read_text(), flags=re.DOTALL | re.MULTILINE)
            for target in re.findall(r"\]\(([^)#]+)", prose):
                if not target.startswith("http"):
                    self.assertTrue((document.parent / target).exists(), f"{document.name}: {target}")

    def test_files_named(self):
        for document in DOCUMENTS:
            for path in re.findall(r"`([a-z_]+/[\w/.-]+\.(?:hpp|cpp|py|txt|md))`", document.read_text()):
                self.assertTrue((ROOT / path).is_file(), f"{document.name}: {path}")

    def test_stages_named(self):
        sources = "".join(path.read_text() for folder in ("broadphase", "culling", "narrowphase", "paper2011", "peers", "examples")
                          for path in (ROOT / folder).rglob("*.cpp"))
        for document in DOCUMENTS:
            for name in re.findall(r"^\| `([a-z]+-[a-z-]+)` \|", document.read_text(), re.MULTILINE):
                self.assertTrue(f'"{name}"' in sources, f"{document.name}: {name}")

    def test_listing_in_the_readme_is_the_consumer(self):
        listing = re.search(r"```cpp\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL).group(1)
        consumer = (ROOT / "tests/consumer/main.cpp").read_text().split("\n", 1)[1]
        self.assertEqual(listing, consumer)

    def test_listings_of_adding_a_stage_are_the_example(self):
        page = (ROOT / "docs/adding_a_stage.md").read_text()
        for language, name in (("cmake", "CMakeLists.txt"), ("cpp", "custom_culling.cpp")):
            listings = re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL)
            self.assertEqual(listings, [(ROOT / "examples/custom_culling" / name).read_text()], name)

    def test_packages_of_adding_a_stage_are_those_that_cmake_asks_for(self):
        config = (ROOT / "cmake/volccdConfig.cmake.in").read_text()
        config = re.sub(r"macro\(_volccd_find_mpi\).*?endmacro", "", config, flags=re.DOTALL)  # another component
        known = {"Eigen3": "libeigen3-dev", "fmt": "libfmt-dev", "TBB": "libtbb-dev", "hwy": "libhwy-dev", "GMP": "libgmp-dev",
                 "HDF5": "libhdf5-dev"}
        asked = {known[name] for name in re.findall(r"find_dependency\((\w+)", config)}
        asked |= set(re.findall(r"\w:(\w+-dev)\b", config)) | set(re.findall(r"\(Debian: ([\w.-]+)\)", config))
        page = (ROOT / "docs/adding_a_stage.md").read_text()
        command = re.search(r"apt-get install ((?:.*\\\n)*.*)", page)[1].replace("\\", "").split()
        self.assertEqual(set(command), asked | {"g++", "cmake"})

    def test_third_party_notices_name_what_is_bundled(self):
        notices = (ROOT / "THIRD_PARTY").read_text()
        for name in ("three.js", "CLI11", "nlohmann/json", "pybind11", "Highway"):
            self.assertIn(f"\n{name}: ", notices)

    def test_listings_of_into_a_solver_are_parts_of_the_example(self):
        """Whether the text consists of consecutive whole lines of the files, perhaps with less indentation."""
        page = (ROOT / "docs/into_a_solver.md").read_text()
        for language, name, minimum in (("cmake", "solver/CMakeLists.txt", 1), ("cpp", "solver/solver.cpp", 6),
                                      ("python", "python/solver.py", 1), ("c", "c/bouncing_cube.c", 2),
                                      ("fortran", "fortran/bouncing_cube.f90", 2)):
            source = (ROOT / "examples" / name).read_text()
            listings = re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL)
            self.assertGreaterEqual(len(listings), minimum)
            for listing in listings:
                indented = (textwrap.indent(listing, " " * n) for n in range(0, 9, 2))
                self.assertTrue(any("\n" + text in "\n" + source for text in indented), f"{name} has not:\n{listing}")


if __name__ == "__main__":
    unittest.main()
