"""Stages from outside the library, and the check of a stage."""

import unittest

from program_support import EXAMPLE, ProgramTest


class Stages(ProgramTest):
    def test_a_stage_from_outside_the_library(self):
        self.assertIn("spheres", self.good("stages", program=EXAMPLE))
        self.assertIn("none of 6", self.good("verify", self.sequence, program=EXAMPLE))
        for pipeline in ("Spheres", "Spheres+CSAT"):
            self.assertIn("spheres", self.good("detect", self.sequence, "--pipeline", pipeline, program=EXAMPLE))
        self.good("detect", self.sequence, "--pipeline", "VolCCD+", "--set", "element-culling=spheres,csat", "--set",
                  "spheres.padding=0.1", program=EXAMPLE)

    def test_check_of_a_stage(self):
        shown = self.good("check", "spheres", self.sequence, "--trials", "300", program=EXAMPLE)
        self.assertIn("spheres (element-culling), declared conservative", shown)
        self.assertRegex(shown, r"allocates nothing in steady state +[1-9]")
        self.assertTrue(shown.endswith("all promises kept\n"))
        self.good("check", "csat", "--set", "csat.axis=optimal", "--trials", "10", "--seed", "7")
        self.bad("check", "nothing", says="kdop-bvh")
        self.bad("check", "csat", "--set", "kdop-bvh.k=6", says="csat.option=value")
        self.bad("check", "csat", "--set", "csat.axis=sideways", says="centroid")
        self.bad("check", "csat", self.path("absent.vtkhdf"), says="absent.vtkhdf")


if __name__ == "__main__":
    unittest.main()
