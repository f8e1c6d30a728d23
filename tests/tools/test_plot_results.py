"""tools/plot_results.py on records with known numbers, which the tests make."""

import contextlib
import io
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77  # the exit code that means "skipped" to CTest
try:
    import matplotlib  # noqa: F401  # pylint: disable=unused-import
except ImportError as missing:
    # Debian's packages are for Debian's interpreter, which need not be the first one in the path.
    SYSTEM = "/usr/bin/python3"
    if os.path.realpath(sys.executable) != os.path.realpath(SYSTEM) and os.path.exists(SYSTEM):
        os.execv(SYSTEM, [SYSTEM, *sys.argv])
    print(f"skipped: {missing}; install python3-matplotlib")
    sys.exit(SKIPPED)

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(HERE)), "tools"))
import plot_results  # noqa: E402  # pylint: disable=wrong-import-position
from plots import feature_sets, records, scaling, stages  # noqa: E402  # pylint: disable=wrong-import-position

PROVENANCE = {"version": "0.1.0", "commit": "abc1234", "cpu": "Test CPU", "cores": 2, "threads": 1,
              "setting": "quick"}


def row(pipeline="VolCCD", scene="octopi", **columns):
    """A row of a step of 1 s: its stages take 0.9 s; 100 of 1000 non-adjacent pairs touch; there are 30 tests."""
    result = {"table": "b", "scene": scene, "motion_model": "linear", "step": 0, "pipeline": pipeline, "variant": "",
              "round": 0, "threads": 1, "elements": 1000, "vertices": 300, "seconds": 1.0, "topology_seconds": 0.0,
              "element_pairs": 1200, "adjacent_pairs": 200, "surviving_pairs": 300, "touching_pairs": 100,
              "owned_tests": 60, "orphan_tests": 7, "vf_tests": 10, "ee_tests": 20, "contacts": 5, "earliest_toi": None,
              "workspace_bytes": 4096, "bounds_s": 0.05}
    result |= {f"{role}_{part}_s": 0.0 for role in records.ROLES for part in ("prepare", "run")}
    result |= {"broad_phase_prepare_s": 0.2, "broad_phase_run_s": 0.1, "element_culling_run_s": 0.1,
               "narrow_phase_run_s": 0.5}
    return result | columns


def steps(seconds, *arguments, **columns):
    """A row for each step and round; `seconds` has a list of times for each step."""
    return [row(*arguments, step=step, round=number, seconds=time, **columns)
            for step, times in enumerate(seconds) for number, time in enumerate(times)]


class Plots(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def record(self, name, rows, /, **changes):
        data = {"experiment": name, "schema": 1, "complete": True, "provenance": PROVENANCE, "rows": rows}
        with open(os.path.join(self.folder, f"{name}.json"), "w", encoding="utf-8") as file:
            json.dump(data | changes, file)

    def run_tool(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = plot_results.main([self.folder, "-o", os.path.join(self.folder, "figures"), *arguments])
            except SystemExit as stop:
                code = stop.code
        return code, out.getvalue(), err.getvalue()

    def good(self, *arguments):
        code, out, err = self.run_tool(*arguments)
        self.assertEqual((code, err), (0, ""))
        return out

    def refused(self, *parts):
        code, _, err = self.run_tool()
        self.assertEqual((code, err.count("\n")), (2, 1), err)
        for part in parts:
            self.assertIn(part, err)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "figures")), "something was written")

    def read(self, name, output="figures"):
        with open(os.path.join(self.folder, output, name), "rb") as file:
            return file.read()

    def texts(self, name):
        svg = self.read(f"{name}.svg").decode().replace("\N{NO-BREAK SPACE}", " ")
        return re.findall(r"<text[^>]*>([^<]*)</text>", svg)

    def table1(self):
        return [*steps([[4, 9, 3], [4, 4, 5], [100, 200, 300]], "NavCCD"), *steps([[8], [8], [8]], "HashCCD"),
                *steps([[1, 1, 9], [1, 0.5, 7], [2, 2, 2]], "VolCCD"), *steps([[0.5]] * 3, "VolCCD+")]

    # --- figures

    def test_every_figure_is_drawn_the_same_twice(self):
        self.record("table1", self.table1() + [r | {"motion_model": "tentative"} for r in self.table1()])
        self.record("culling", [row("A none", "octopi", table="II"), row("C all", "crash", table="III")])
        self.record("ablation", [row(variant=f"broad-phase=spatial-hash csat.axis={axis}") for axis in "xy"] + [row()])
        self.record("scaling", [row(variant=f"size={n}", elements=n) for n in (10, 100)] +
                    [row(variant=f"motion={f}", moved_edges=f) for f in (0.1, 1)])
        self.good()
        again = [sys.executable, plot_results.__file__, self.folder, "-o", os.path.join(self.folder, "again")]
        environment = os.environ | {"PYTHONHASHSEED": "7", "PYTHONDONTWRITEBYTECODE": "1"}
        subprocess.run(again, env=environment, check=True, stdout=subprocess.DEVNULL)
        names = ["ablation", "breakdown", "breakdown-tentative", "culling", "false-positives",
                 "false-positives-tentative", "funnel", "funnel-tentative", "scaling", "scaling-motion", "speedup",
                 "speedup-tentative"]
        files = [name + end for name in names for end in (".png", ".svg")]
        self.assertEqual(sorted(os.listdir(os.path.join(self.folder, "figures"))), sorted(files))
        for name in files:
            self.assertEqual(self.read(name), self.read(name, "again"), name)
            self.assertNotIn(b"dc:date", self.read(name))
        caption = " ".join(self.texts("culling"))
        for part in ("octopi (1), crash (1)", "Setting: quick", "Commit abc1234.", "Test CPU, 2 cores, 1 thread."):
            self.assertIn(part, caption)

    def test_speedups_are_ratios_of_means_beside_the_paper_s(self):
        self.record("table1", self.table1())
        self.good("--only", "speedup")
        texts = self.texts("speedup")
        # NavCCD: the motions have the medians 4, 4 and 200 s; VolCCD: 1, 1 and 2; VolCCD+: 0.5; HashCCD: 8.
        self.assertEqual([text for text in texts if text.endswith("×")],
                         ["52.0×", "139×", "12×", "6.0×", "16.0×", "18.3×"])
        self.assertIn("I-b: over NavCCD", texts)

    def test_speedups_take_steps_that_both_have(self):
        self.record("table1", [*steps([[6], [6]], "NavCCD"), *steps([[2], [2], [90], [90], [90]], "VolCCD")])
        self.good("--only", "speedup")
        self.assertIn("3.0×", self.texts("speedup"))
        self.record("table1", [row("NavCCD", step=1), row("VolCCD", step=2), row("HashCCD", step=2, seconds=7)])
        self.assertIn("octopi, VolCCD: has no step in common with NavCCD; left out", self.good("--only", "speedup"))
        self.assertIn("7.0×", self.texts("speedup"))

    def test_variants_are_compared_with_their_like(self):
        self.record("table1", [row("NavCCD", seconds=6), row("NavCCD", variant="adjacent=no", seconds=3),
                               row("NavCCD", variant="edges=polytope", seconds=20),
                               row(), row(variant="edges=polytope", seconds=2)])
        self.good("--only", "speedup")
        texts = self.texts("speedup")
        for text in ("VolCCD", "VolCCD, edges=polytope", "6.0×", "10.0×"):
            self.assertIn(text, texts)
        self.assertNotIn("3.0×", texts)
        for text in ("VolCCD over NavCCD, adjacent=no", "3.0×"):
            self.assertIn(text, self.texts("speedup-variants"))

    def test_settings_of_a_whole_table_are_not_in_its_labels(self):
        self.record("table1", [row("NavCCD", variant="narrow-phase=cubic", seconds=6),
                               row(variant="narrow-phase=cubic"),
                               row("NavCCD", variant="narrow-phase=cubic orphans=o-set", seconds=3)])
        out = self.good("--only", "speedup", "breakdown")
        self.assertIn("table b: narrow-phase=cubic is a setting of all its pipelines", out)
        self.assertTrue({"VolCCD", "6.0×"} <= set(self.texts("speedup")))
        self.assertTrue({"VolCCD over NavCCD, orphans=o-set", "3.0×"} <= set(self.texts("speedup-variants")))
        self.assertIn("I-b: VolCCD", self.texts("breakdown"))

    def test_topology_edits_count_in_speedups(self):
        self.record("table1", [row("NavCCD", seconds=6, topology_seconds=1.0), row(topology_seconds=1.0)])
        self.good("--only", "speedup")
        self.assertIn("3.5×", self.texts("speedup"))

    def test_edge_sets_are_kept_apart(self):
        self.record("table1", [row("NavCCD", seconds=6, edges="triangulated"), row(edges="triangulated"),
                               row("NavCCD", seconds=8, edges="polytope"), row(edges="polytope")])
        self.good("--only", "speedup")
        self.assertIn("6.0×", self.texts("speedup"))
        self.assertIn("8.0×", self.texts("speedup-polytope"))

    def test_scenes_and_pipelines_that_the_paper_does_not_know_are_drawn(self):
        rows = [row(pipeline, scene, seconds=time) for scene in ("my-scene", "octopi")
                for pipeline, time in (("NavCCD", 5), ("Mine", 2))]
        self.record("table1", rows)
        self.record("culling", [row("A none", "my-scene"), row("Mine", "my-scene", variant="csat.k=1", vf_tests=77),
                                row("Mine", "my-scene")])
        self.good()
        for name in ("speedup", "breakdown", "false-positives", "funnel", "culling"):
            self.assertTrue({"my-scene"} <= set(self.texts(name)), name)
        self.assertEqual(self.texts("speedup").count("2.5×"), 2)
        self.assertIn("77", " ".join(self.texts("culling")))
        self.assertIn("Mine, csat.k=1: sum of all steps", self.texts("culling"))
        self.assertFalse(any("paper" in text for text in self.texts("culling")))

    def test_breakdown_has_all_of_the_time(self):
        shares = stages.shares_of(steps([[1.0, 1.0], [1.0]]))
        expected = {"k-DOPs": 5, "tree": 15, "traversal and culling": 20, "O-Set": 0, "feature filters": 0,
                    "elementary tests": 50, "remainder": 10}
        self.assertEqual(list(shares), list(expected))
        for name, share in expected.items():
            self.assertAlmostEqual(shares[name], share, msg=name)
        self.record("table1", self.table1())
        self.good("--only", "breakdown")
        self.assertIn("50", self.texts("breakdown"))
        self.assertIn("I-b: VolCCD", self.texts("breakdown"))

    def test_typical_round_is_the_median_and_a_single_one(self):
        rows = steps([[3, 1, 2], [5, 4]])
        self.assertEqual([r["seconds"] for r in records.typical(rows)], [2, 4])

    def test_false_positives(self):
        self.record("table1", [row(), row(step=1, touching_pairs=20), row(step=2, touching_pairs=10),
                               row(step=3, element_pairs=200)])
        out = self.good("--only", "false-positives")
        self.assertIn("98.00", self.texts("false-positives"))  # median of 90, 98 and 99
        self.assertIn("octopi: 1 steps without pairs", out)

    def test_funnel_has_zeros(self):
        self.record("table1", [row(contacts=0), row("VolCCD+", vf_tests=3, ee_tests=1, contacts=0)])
        self.good("--only", "funnel")
        for text in ("1.2 k", "300", "67", "30", "4", "0"):
            self.assertIn(text, self.texts("funnel"))
        self.assertNotIn("0.1", self.texts("funnel"), "the place of zeros is labelled with its logarithmic value")

    def test_culling_sums_steps_and_takes_each_once(self):
        rows = [row("A none", "crash", step=m, round=r, vf_tests=1000, ee_tests=2500) for m in (0, 1) for r in (0, 1)]
        self.record("culling", rows)
        self.good("--only", "culling")
        self.assertIn("2 k", " ".join(self.texts("culling")))
        self.assertIn("5 k", " ".join(self.texts("culling")))
        self.assertIn("paper (Tables II and III, as printed)", self.texts("culling"))

    def test_ablation_is_relative_to_the_best_and_names_broad_phases(self):
        plan = [{"table": "b", "pipeline": pipeline, "variant": variant, "stages": {"broad_phase": {"name": name}}}
                for pipeline, variant, name in (("VolCCD", "", "kdop-bvh"), ("VolCCD", "csat.axis=face", "kdop-bvh"),
                                                ("spatial-hash", "none", "spatial-hash"))]
        self.record("ablation", [row(seconds=2), row(variant="csat.axis=face", seconds=3, vf_tests=480),
                                 row(variant="csat.axis=face broad-phase=brute-force", seconds=8),
                                 row("Other", seconds=0.5),
                                 row("spatial-hash", variant="CSAT + filters", seconds=5),
                                 row("spatial-hash", variant="none", seconds=7)],
                    provenance=PROVENANCE | {"plan": {"runs": [{"entrants": plan}]}})
        out = self.good()
        texts = self.texts("ablation")
        for text in ("kdop-bvh", "brute-force", "VolCCD", "VolCCD, csat.axis=face", "1.0×", "4.0×", "6.0×", "16.0×",
                     "500", "none", "spatial-hash", "broad phase not recorded"):
            self.assertIn(text, texts)
        self.assertEqual(texts.count("VolCCD, csat.axis=face"), 2)
        self.assertIn("ablation: neither the variant nor the provenance", out)

    def test_long_ablations_go_on_on_another_page(self):
        self.record("ablation", [row(variant=f"csat.n={n}", table=table) for table in ("n", "a b") for n in range(41)])
        self.good()
        names = {name for name in os.listdir(os.path.join(self.folder, "figures")) if name.endswith(".svg")}
        self.assertEqual(names, {f"ablation-{table}-{page}.svg" for table in ("n", "a-b") for page in (1, 2)})
        self.assertIn("VolCCD, csat.n=40", self.texts("ablation-n-2"))

    def test_exponents(self):
        lines = [[(n, 5 * n ** 1.5) for n in (10, 100, 1000)], [(10, 9e9), (20, 9e9 * 2 ** 1.5)]]
        slope, error = scaling.exponent(lines)
        self.assertAlmostEqual(slope, 1.5)
        self.assertAlmostEqual(error, 0)
        self.assertIsNone(scaling.exponent([[(10, 1), (20, 2)]])[1])
        self.assertIsNone(scaling.exponent([[(10, 1)], [(20, 2)]]))
        self.record("scaling", [row(variant=f"size={n}", elements=10 ** n, seconds=100 ** n, vf_tests=0, ee_tests=0)
                                for n in (1, 2, 3)] + [row(variant="odd"), row(variant="size=1 csat.k=2")])
        out = self.good("--only", "scaling")
        self.assertIn("VolCCD: 2.00 ± 0.00", self.texts("scaling"))
        self.assertIn("VolCCD, csat.k=2: no exponent", self.texts("scaling"))
        self.assertIn("1 rows with the variant 'odd'", out)
        self.assertIn("is 0 at 3 points", out)

    def test_whole_steps_are_those_after_the_first_of_a_window(self):
        steps = [row("VolCCD+", table="", variant="inclusion", step=step, window=4, seconds=seconds,
                     topology_seconds=0.25)
                 for step, seconds in ((4, 9), (5, 1), (6, 3))]
        single = [row("boundary alone", table="", step=4, window=4, round=round, seconds=7) for round in (0, 1)]
        self.record("plus", [*steps, *single, row("VolCCD+", table="2 threads", window=0, step=0)])
        self.good("--only", "plus")
        texts = self.texts("plus")
        for text in ("VolCCD+, inclusion", "2.25 k", "boundary alone", "7 k"):
            self.assertIn(text, texts)
        self.assertIn("VolCCD+", self.texts("plus-2-threads"))

    def test_feature_sets_over_time(self):
        def sets(scene, velocities):
            return [row("VolCCD+", scene, variant="all", step=k, time=1e-6 * (k + 1), velocity=v, overlaps_inter=k,
                        interior=10 * k) for k, v in enumerate(velocities)]
        self.record("feature-sets", sets("bullet", [750, 300, -40]) + sets("bullet-surface", [750, 500]))
        self.good()
        texts = self.texts("feature-sets")
        for text in ("bullet", "bullet-surface", "velocity of the bullet, m/s", "time, microseconds"):
            self.assertIn(text, texts)
        self.assertIn("bullet (3), bullet-surface (2)", " ".join(texts))
        page = feature_sets.draw_feature_sets(records.read_record(os.path.join(self.folder, "feature-sets.json"),
                                                                  "feature-sets"), None)[0][1]
        lines = [line.get_ydata() for line in page.panels[0][0].get_lines()]
        self.assertEqual([list(line) for line in lines], [[750, 300, -40], [750, 500]])
        self.assertAlmostEqual(page.panels[0][2].get_lines()[0].get_xdata()[2], 3)
        self.assertEqual(list(page.panels[0][2].get_lines()[0].get_ydata()), [0, 10, 20])
        self.record("feature-sets", [row("VolCCD+", time=1.0, velocity=float("nan"), overlaps_inter=0, interior=0)])
        code, _, err = self.run_tool()
        self.assertEqual((code, "velocity = NaN" in err), (2, True), err)

    # --- what is missing

    def test_missing_records_are_said(self):
        self.record("culling", [row("A none")])
        with open(os.path.join(self.folder, "scenes.json"), "w", encoding="ascii") as file:
            file.write("{}")
        out = self.good()
        self.assertIn("speedup, breakdown, false-positives, funnel: skipped, there is no ", out)
        self.assertIn("no figure is made of scenes.json", out)
        with open(os.path.join(self.folder, "table1.incomplete.jsonl"), "w", encoding="ascii"):
            self.assertIn("repeat the command that began", self.good())
        self.record("scaling", [row(variant="size=1")])
        self.assertIn("scaling-motion: skipped", self.good())
        code, _, err = self.run_tool("--only", "speedup")
        self.assertEqual((code, "has no record for the figures asked for" in err), (2, True))
        self.assertEqual(self.run_tool("--only", "nonsense")[0], 2)

    def test_missing_and_bad_columns_are_refused_with_file_and_row(self):
        incomplete = row()
        del incomplete["touching_pairs"]
        self.record("culling", [row("A none")])
        self.record("table1", [row(), incomplete])
        self.refused("table1.json", "row 1", "no column 'touching_pairs'")
        for column, value in (("seconds", 0), ("seconds", None), ("vf_tests", "12"), ("contacts", -1), ("scene", 3),
                              ("ee_tests", True), ("bounds_s", float("nan"))):
            self.record("table1", [row(), row(), row(**{column: value})])
            self.refused("table1.json", "row 2", f"{column} = ")
        self.record("table1", [row()])
        self.record("scaling", [row(variant="size=1"), row(variant="motion=1")])
        self.refused("scaling.json", "row 1", "no column 'moved_edges'")

    def test_what_is_no_record_is_refused(self):
        for changes, part in (({"schema": 2}, "schema 2"), ({"experiment": "culling"}, "no record of the experiment"),
                              ({"rows": None}, "no 'rows'"), ({"rows": [1]}, "row 0 is no object"),
                              ({"provenance": {"setting": "quick"}}, "the provenance has no 'commit'")):
            self.record("table1", [row()], **changes)
            self.refused("table1.json", part)
        with open(os.path.join(self.folder, "table1.json"), "w", encoding="ascii") as file:
            file.write('{"rows": [')
        self.refused("table1.json", "cannot be read")

    def test_incomplete_records_are_called_so(self):
        self.record("table1", self.table1(), complete=False,
                    provenance=PROVENANCE | {"commit": "abc1234-dirty", "threads": 2})
        self.good("--only", "funnel")
        caption = " ".join(self.texts("funnel"))
        for part in ("quick, incomplete record.", "abc1234 with local changes.", "2 threads."):
            self.assertIn(part, caption)


if __name__ == "__main__":
    unittest.main()
