#!/usr/bin/env python3
"""check_layers.py on small trees: a correct one passes, and each kind of violation is reported with its line."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import check_layers  # noqa: E402

GOOD = {
    "core/error.hpp": "#pragma once\n",
    "core/CMakeLists.txt": "volccd_module(core PUBLIC fmt::fmt PRIVATE TBB::tbb)\n",
    "mesh/mesh.hpp": "#pragma once\n#include <volccd/core/error.hpp>\n#include <volccd/mesh/detail/pool.hpp>\n",
    "mesh/detail/pool.hpp": "#pragma once\n",
    "mesh/CMakeLists.txt": "volccd_module(mesh PUBLIC volccd_core)\n",
    "io/sequence/reader.hpp": "#pragma once\n#include <volccd/mesh/mesh.hpp>\n",
    "io/sequence/reader.cpp": "#include <volccd/io/sequence/reader.hpp>\n#include <hdf5.h>\n",
    "io/CMakeLists.txt": "volccd_module(io PUBLIC volccd_mesh PRIVATE hdf5::hdf5)\n",
    "culling/csat/csat.hpp": "#pragma once\n#include <volccd/mesh/mesh.hpp>\n",
    "culling/csat/csat.cpp": "#include <volccd/culling/csat/csat.hpp>\n#include <hwy/highway.h>\n",
    "culling/CMakeLists.txt": "volccd_module(culling PUBLIC volccd_mesh PRIVATE hwy::hwy)\n",
    "broadphase/bvh.hpp": "#pragma once\n#include <volccd/core/error.hpp>\n",
    "broadphase/CMakeLists.txt": "volccd_module(broadphase PUBLIC volccd_mesh)\n",
    "pipelines/pipeline.hpp": "#pragma once\n#include <volccd/culling/csat/csat.hpp>\n",
    "pipelines/CMakeLists.txt": "volccd_module(pipelines PUBLIC volccd_culling volccd_broadphase)\n",
    "oracle/fcl.hpp": "#pragma once\n#include <volccd/pipelines/pipeline.hpp>\n",
    "oracle/CMakeLists.txt": "volccd_module(oracle NO_INSTALL PUBLIC volccd_pipelines PRIVATE fcl)\n",
    "experiments/verify.cpp": "#include <volccd/oracle/fcl.hpp>\n",
    "tests/mesh/test_pool.cpp": "#include <volccd/mesh/detail/pool.hpp>\n#include <volccd/oracle/fcl.hpp>\n",
}


class CheckLayers(unittest.TestCase):
    def findings(self, changes, long_headers=()):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            for path, text in {**GOOD, **changes}.items():
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(text)
            return check_layers.check(root, dict.fromkeys(long_headers, "reason"))[0]

    def assert_found(self, changes, place, words):
        found = self.findings(changes)
        self.assertEqual(len(found), 1, found)
        self.assertTrue(found[0].startswith(place + ": "), found[0])
        self.assertIn(words, found[0])

    def test_good_tree_passes(self):
        self.assertEqual(self.findings({}), [])

    def test_upward_include(self):
        self.assert_found({"core/error.hpp": "#pragma once\n\n#include <volccd/mesh/mesh.hpp>\n",
                           "core/CMakeLists.txt": ""}, "core/error.hpp:3", "core may not include mesh")

    def test_mesh_does_not_know_sequences(self):
        self.assert_found({"mesh/a.cpp": "#include <volccd/io/sequence/reader.hpp>\n"}, "mesh/a.cpp:1",
                          "mesh may not include io")

    def test_siblings(self):
        for a, b in (("culling", "broadphase/bvh.hpp"), ("broadphase", "culling/csat/csat.hpp")):
            self.assert_found({f"{a}/x.cpp": f"#include <volccd/{b}>\n"}, f"{a}/x.cpp:1", f"{a} may not include")

    def test_spacing_of_the_directive_does_not_hide_it(self):
        self.assert_found({"culling/x.cpp": "  #  include<volccd/broadphase/bvh.hpp>\n"}, "culling/x.cpp:1",
                          "may not include broadphase")

    def test_oracle_is_for_verify_only(self):
        self.assert_found({"experiments/detect.cpp": "#include <volccd/oracle/fcl.hpp>\n"}, "experiments/detect.cpp:1",
                          "experiments may not include oracle")
        self.assert_found({"oracle/cases/attack.hpp": "#pragma once\n",
                           "simulation/x.cpp": "#include <volccd/oracle/cases/attack.hpp>\n"},
                          "simulation/x.cpp:1", "simulation may not include oracle/cases")
        self.assert_found({"pipelines/x.cpp": "#include <volccd/oracle/fcl.hpp>\n"}, "pipelines/x.cpp:1",
                          "pipelines may not include oracle")

    def test_detail_of_another_module(self):
        for user in ("culling/x.cpp", "tests/culling/x.cpp", "examples/x.cpp"):
            self.assert_found({user: "#include <volccd/mesh/detail/pool.hpp>\n"}, f"{user}:1", "is a detail of mesh")

    def test_adaptors_of_other_libraries_use_details_of_broad_phases(self):
        detail = {"broadphase/detail/writer.hpp": "#pragma once\n",
                  "peers/CMakeLists.txt": "volccd_module(peers PUBLIC volccd_broadphase)\n"}
        text = "#include <volccd/broadphase/detail/writer.hpp>\n"
        self.assertEqual(self.findings({**detail, "peers/x.cpp": text}), [])
        self.assert_found({**detail, "pipelines/x.cpp": text}, "pipelines/x.cpp:1", "is a detail of broadphase")

    def test_rooms_of_a_module(self):
        flood = {"culling/flood/front.hpp": "#pragma once\n#include <volccd/culling/csat/csat.hpp>\n"}
        self.assertEqual(self.findings(flood), [])
        self.assert_found({**flood, "culling/csat/x.cpp": "#include <volccd/culling/flood/front.hpp>\n"},
                          "culling/csat/x.cpp:1", "culling/csat may not include culling/flood")
        self.assert_found({"culling/x.cpp": "#include <volccd/culling/csat/csat.hpp>\n"}, "culling/x.cpp:1",
                          "culling/ may not include culling/csat")

    def test_crowded_detail_folder(self):
        files = {f"mesh/detail/file{i}.hpp": "#pragma once\n" for i in range(12)}  # and pool.hpp
        self.assert_found(files, "mesh/detail:1", "13 files")

    def test_missing_header(self):
        self.assert_found({"culling/x.cpp": "#include <volccd/mesh/gone.hpp>\n"}, "culling/x.cpp:1", "does not exist")

    def test_relative_and_quoted_includes(self):
        self.assert_found({"culling/csat/x.cpp": '#include "csat.hpp"\n'}, "culling/csat/x.cpp:1", "relative")
        self.assert_found({"pipelines/x.cpp": '#include "volccd/culling/csat/csat.hpp"\n'}, "pipelines/x.cpp:1", "write <volccd")

    def test_third_party(self):
        self.assert_found({"culling/x.cpp": "#include <tbb/parallel_for.h>\n"}, "culling/x.cpp:1", "culling may not")
        self.assert_found({"culling/x.hpp": "#pragma once\n#include <hwy/highway.h>\n"}, "culling/x.hpp:2",
                          "public header")

    def test_python_is_above_the_library(self):
        self.assertEqual(self.findings({"python/src/x.cpp": "#include <pybind11/numpy.h>\n#include <volccd/mesh/mesh.hpp>\n"}), [])
        self.assert_found({"mesh/x.cpp": "#include <pybind11/numpy.h>\n"}, "mesh/x.cpp:1", "mesh may not")
        self.assert_found({"oracle/fcl.hpp": "#pragma once\n", "python/src/x.cpp": "#include <volccd/oracle/fcl.hpp>\n"},
                          "python/src/x.cpp:1", "python may not include oracle")

    def test_kernel_headers(self):
        lanes = {"mesh/lanes-inl.hpp": "#include <hwy/highway.h>\n"}
        self.assertEqual(self.findings({**lanes, "culling/x.cpp": "#include <volccd/mesh/lanes-inl.hpp>\n",
                                        "culling/detail/y-inl.hpp": "#include <volccd/mesh/lanes-inl.hpp>\n"}), [])
        self.assert_found({**lanes, "culling/x.hpp": "#pragma once\n#include <volccd/mesh/lanes-inl.hpp>\n"},
                          "culling/x.hpp:2", "public header")

    def test_link_above(self):
        self.assert_found({"mesh/CMakeLists.txt": "volccd_module(mesh PUBLIC volccd_core PRIVATE volccd_culling)\n"},
                          "mesh/CMakeLists.txt:1", "mesh may not link culling")

    def test_include_that_is_not_linked(self):
        self.assert_found({"pipelines/CMakeLists.txt": "volccd_module(pipelines PUBLIC volccd_broadphase)\n"},
                          "pipelines/pipeline.hpp:2", "does not link it")

    def test_thread_local(self):
        self.assert_found({"mesh/x.cpp": "\n  thread_local int kept = 0;\n"}, "mesh/x.cpp:2", "thread_local")
        self.assert_found({"mesh/x.cpp": "static thread_local int kept = 0;\n"}, "mesh/x.cpp:1", "workspace")
        self.assertEqual(self.findings({"mesh/x.cpp": "// no thread_local\n", "tests/x.cpp": "thread_local int i;\n"}), [])

    def test_pragma_once(self):
        self.assert_found({"mesh/bare.hpp": "// nothing\n"}, "mesh/bare.hpp:1", "#pragma once")

    def test_long_header(self):
        long = "#pragma once\n" + "//\n" * 200
        self.assert_found({"mesh/long.hpp": long}, "mesh/long.hpp:201", "201 lines")
        self.assertEqual(self.findings({"mesh/long.hpp": long}, ["mesh/long.hpp"]), [])
        self.assertEqual(len(self.findings({}, ["mesh/long.hpp"])), 1, "a listed header that is gone is reported")


if __name__ == "__main__":
    unittest.main()
