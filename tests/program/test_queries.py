"""queries: candidates of sequences and tests with known answers."""

import json
import os
import unittest

from program_support import SOURCE, ProgramTest


class Queries(ProgramTest):
    def queries(self, *arguments):
        return json.loads(self.good("queries", *arguments, "--json", "--rounds", "1"))

    def test_queries_on_candidates_find_what_detect_finds(self):
        found = self.queries(self.sequence, "--steps", "0", "--candidates", "--narrowphase",
                             "cubic,cubic:axis_test=false")
        self.assertEqual([n["name"] for n in found["narrow_phases"]], ["cubic", "cubic:axis_test=false"])
        expected = self.contacts("--steps", "0", "--set", "narrow-phase=cubic")[1:]
        for group in found["groups"]:
            self.assertEqual(group["scene"], "candidates, step 0")
            self.assertIsNone(group["colliding"])
            for score in group["scores"]:
                self.assertEqual(score["contacts"], sum(row[1] == group["kind"] for row in expected))
                self.assertGreater(score["nanoseconds"], 0)
        filtered = self.queries(self.sequence, "--steps", "0", "--candidates", "--narrowphase", "cubic", "--filters",
                                "feature-kdop,coplanarity", "--set", "cubic.axis_test=false")
        for group, fewer in zip(found["groups"], filtered["groups"]):
            self.assertEqual(fewer["scores"][0]["contacts"], group["scores"][0]["contacts"])
            self.assertLess(fewer["scores"][0]["tests"], group["queries"])
        sample = self.queries(self.sequence, "--steps", "0:2", "--candidates", "--narrowphase", "cubic",
                              "--sample", "10")
        self.assertEqual([group["queries"] for group in sample["groups"]], [10, 10, 10, 10])

    def test_queries_judged_by_a_narrow_phase(self):
        judged = self.queries(self.sequence, "--steps", "1:3", "--candidates", "--sample", "2000", "--judge", "exact",
                              "--narrowphase", "inclusion,exact")
        self.assertGreater(sum(group["colliding"] for group in judged["groups"]), 0)
        for group in judged["groups"]:
            for score in group["scores"]:
                self.assertEqual((score["missed"], score["extra"]), (0, score["undecided"]))
                self.assertLessEqual(score["latest"], 0)
        self.bad("queries", self.sequence, "--steps", "1", says="GroundTruth")

    def test_queries_with_known_answers(self):
        data = os.environ.get("VOLCCD_DATA", os.path.join(SOURCE, "..", "shared", "data"))
        queries = os.path.join(data, "ccd-queries.h5")
        if not os.path.exists(queries):
            self.skipTest("ccd-queries.h5 is not there")
        found = self.queries(queries, "--narrowphase", "cubic")
        self.assertEqual(sum(group["queries"] for group in found["total"]), 4779)
        self.assertEqual([group["scores"][0]["missed"] for group in found["total"]], [0, 0])
        listed = self.good("queries", queries, "--narrowphase", "cubic:tolerance=1e-3", "--rounds", "0", "--list")
        self.assertTrue("extra by cubic:tolerance=1e-3: erleben-spike-hole VF 500 (data_0_0.csv)" in listed)
        self.bad("queries", queries, "--candidates", says="--candidates")


if __name__ == "__main__":
    unittest.main()
