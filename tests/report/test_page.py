#!/usr/bin/env python3
"""Tests the report and the view in a headless Chromium, opened from disk: there is no error and no network request, and
each control has an effect. Skipped (77) if there is no Chromium, or if the page is not built.

Usage: test_page.py VOLCCD
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from browser import CHROMIUM, Browser

VOLCCD = os.path.abspath(sys.argv.pop(1))
ROOT = Path(__file__).resolve().parents[2]


TABLE1 = json.loads((ROOT / "results/table1.json").read_text(encoding="utf-8"))
# The second, if the scene has changed since the records of results/ were made.
HOW_TO_GET = r"volccd (scene generate {scene}|experiment run \S+ \(the record is of another version)"
LIVER = next(i["file"] for i in TABLE1["provenance"]["inputs"] if i["scene"] == "liver")


def run(folder, *arguments):
    environment = {**os.environ, "VOLCCD_CACHE": str(folder / "cache"), "VOLCCD_DATA": str(folder / "no-data")}
    done = subprocess.run([VOLCCD, *map(str, arguments)], capture_output=True, text=True, env=environment, check=False)
    if "the page of the report is not built" in done.stderr:
        print(f"skipped: {done.stderr.strip()}")
        sys.exit(77)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def setUpModule():
    """Makes a report of a measurement of the built-in scene and of kept records whose scenes are missing here, and
    a view."""
    global FOLDER, BROWSER, TEMPORARY
    TEMPORARY = tempfile.TemporaryDirectory()
    FOLDER = Path(TEMPORARY.name)
    run(FOLDER, "scene", "generate", "builtin", "--elements", "600", "--frames", "7", "-o", FOLDER / "run.vtkhdf")
    run(FOLDER, "view", FOLDER / "run.vtkhdf", "-o", FOLDER / "view")
    run(FOLDER, "experiment", "run", "projectile", "--quick", "-o", FOLDER / "results")
    for name in ("table1", "scenes", "plus"):
        shutil.copy(ROOT / "results" / f"{name}.json", FOLDER / "results")
    (FOLDER / "results/pictures").mkdir()
    for name in ("octopi", "liver"):
        shutil.copy(ROOT / "results/pictures" / f"{name}.png", FOLDER / "results/pictures")
    # A sequence in the place of one that table1 measured, so that there are two scenes, one of which has a note.
    (FOLDER / "cache").mkdir(exist_ok=True)
    shutil.copy(FOLDER / "run.vtkhdf", FOLDER / "cache" / LIVER)
    output = run(FOLDER, "report", FOLDER / "results", "-o", FOLDER / "report")
    assert re.search(r"octopi: not shown.*\n.*\n  " + HOW_TO_GET.format(scene="octopi"), output), output
    BROWSER = Browser(1000, 760)


def tearDownModule():
    BROWSER.close()
    TEMPORARY.cleanup()


# A hash of a text, and a small picture of the 3-D view as a text.
HASH = "(text => { let h = 0; for (let i = 0; i < text.length; ++i) h = (31 * h + text.charCodeAt(i)) | 0; return h; })"
PICTURE = """(() => { volccd_test.viewer.drawNow(); const small = document.createElement('canvas');
  small.width = 320; small.height = 200; const c = small.getContext('2d');
  c.drawImage(document.querySelector('canvas'), 0, 0, 320, 200);
  return Array.from(c.getImageData(0, 0, 320, 200).data, v => String.fromCharCode(v)).join(''); })()"""


class Page(unittest.TestCase):
    report = "report"

    def setUp(self):
        BROWSER.problems.clear()
        BROWSER.requests.clear()
        BROWSER.js("window.volccd_test = undefined")

    def tearDown(self):
        self.assertEqual(BROWSER.problems, [])
        outside = [url for url in BROWSER.requests if not url.startswith(("file://", "data:", "blob:"))]
        self.assertEqual(outside, [])

    def go(self, place):
        BROWSER.open("about:blank")
        BROWSER.open(f"file://{FOLDER}/{self.report}/index.html#{place}")
        BROWSER.until("'ready' in document.body.dataset")

    def changes(self, expression, act, what):
        """Checks that `act` changes the value of an expression."""
        before = BROWSER.js(f"{HASH}({expression} + '')")
        act()
        try:
            BROWSER.until(f"{HASH}({expression} + '') !== {before}", 5)
        except AssertionError:
            raise AssertionError(f"{what} changed nothing") from None

    def redraws(self, act, what):
        self.changes(PICTURE, act, what)

    def make_small(self):
        """Makes the 3-D view small, because software draws it here and takes less time then."""
        BROWSER.js("document.head.insertAdjacentHTML('beforeend', '<style>.stage { width: 320px !important }</style>')")

    def count(self, selector):
        return BROWSER.js(f"document.querySelectorAll({json.dumps(selector)}).length")

    def text(self, selector):
        return BROWSER.js(f"document.querySelector({json.dumps(selector)}).textContent")


class Report(Page):
    def test_first_paint_and_overview(self):
        cold = Browser(1000, 760)
        try:
            cold.open(f"file://{FOLDER}/report/index.html")
            cold.until("performance.getEntriesByType('paint').length > 0")
            paint = cold.js("performance.getEntriesByType('paint').pop().startTime")
        finally:
            cold.close()
        self.assertLess(paint, 2000 * max(1, os.getloadavg()[0] / os.cpu_count()))
        self.go("overview")
        self.assertEqual(self.count(".records tbody tr"), 4)
        self.assertRegex(BROWSER.js("document.body.textContent"), HOW_TO_GET.format(scene="octopi"))
        self.assertEqual(self.count("a.card"), 2)
        self.assertGreater(self.count(".card.missing"), 10)
        BROWSER.js("document.querySelectorAll('.card img').forEach(image => (image.loading = 'eager'))")
        BROWSER.until("[...document.querySelectorAll('.card img')].every(image => image.naturalWidth > 100)")
        self.assertGreater(self.count(".card.missing img"), 0)
        self.assertEqual(self.count("a.card img"), 1)
        for name in ("tables", "figures", "scenes", "overview"):
            self.changes("document.querySelector('main').innerHTML.length",
                    lambda n=name: BROWSER.click(f"header a[data-key={n}]"),
                         name)
        BROWSER.until("document.querySelector('.records a')")
        BROWSER.click(".records a")
        BROWSER.until("document.querySelector('.table-block')")

    def test_records_and_scenes_are_listed_before_the_scripts_run(self):
        BROWSER.call("Emulation.setScriptExecutionDisabled", value=True)
        try:
            BROWSER.call("Page.navigate", url="about:blank")
            BROWSER.call("Page.navigate", url=f"file://{FOLDER}/report/index.html")
            BROWSER.until("document.querySelector('main')")
            links = BROWSER.js("[...document.querySelectorAll('a')].map(a => a.getAttribute('href'))")
        finally:
            BROWSER.call("Emulation.setScriptExecutionDisabled", value=False)
        self.assertEqual(links[:4], ["#overview", "#tables", "#figures", "#scenes"])
        self.assertEqual(sorted(links[4:8]), ["#tables/plus", "#tables/projectile", "#tables/scenes", "#tables/table1"])
        self.assertTrue(all(link.startswith("#scenes/") for link in links[8:]) and len(links) > 8, links)

    def test_a_report_without_data_says_so(self):
        killed = FOLDER / "killed"
        shutil.copytree(FOLDER / "report", killed)
        (killed / "data" / "report.js").unlink()
        BROWSER.open(f"file://{killed}/index.html")
        BROWSER.until("document.querySelector('.error')")
        self.assertIn("data/report.js is missing", self.text(".error"))
        self.assertIn("run the same command again", self.text(".error"))
        self.assertEqual([p for p in BROWSER.problems if "ERR_FILE_NOT_FOUND" not in p], [])
        BROWSER.problems.clear()

    def test_tables_sort_and_show_where_numbers_come_from(self):
        self.go("tables/table1")
        first = ".table-block:first-of-type"
        cells = f"[...document.querySelectorAll('{first} tbody td:nth-child(2)')].map(c => c.textContent).join(' ')"
        numbers = [int(n.replace(",", "")) for n in BROWSER.js(cells).split()]
        column = f"{first} th:nth-child(2) button"
        for expected, state in ((sorted(numbers, reverse=True), "descending"), (sorted(numbers), "ascending"),
                (numbers, "none")):
            BROWSER.click(column)
            self.assertEqual([int(n.replace(",", "")) for n in BROWSER.js(cells).split()], expected)
            self.assertEqual(BROWSER.js(f"document.querySelector('{first} th:nth-child(2)').ariaSort"), state)
        BROWSER.hover(f"{first} tbody tr:nth-child(2) td:nth-child(4)")
        BROWSER.until("document.querySelector('.tip') && !document.querySelector('.tip').hidden")
        tip = self.text(".tip")
        made = TABLE1["provenance"]
        for part in ("table1.json", f"commit {made['commit']}", made["cpu"], f"load {made['load']:g}",
                     "volccd experiment run table1 --full"):
            self.assertIn(part, tip)
        BROWSER.click(f"{first} tbody tr:nth-child(2) td:nth-child(4)")
        BROWSER.until("!document.querySelector('.drawer').hidden")
        details = self.text(".drawer")
        for part in ("bullet", "-O3", "Medians over rounds", "hash"):
            self.assertIn(part, details)
        self.assertRegex(details, HOW_TO_GET.format(scene="bullet"))
        BROWSER.key("Escape")
        BROWSER.until("document.querySelector('.drawer').hidden")

    def test_the_skip_link_and_the_cards(self):
        self.go("overview")
        BROWSER.js("document.querySelector('.skip').focus()")
        BROWSER.key("Enter", text="\r")
        BROWSER.until("document.activeElement.id === 'content'")
        card = BROWSER.js("document.querySelector('a.card').getAttribute('href')")
        BROWSER.click("a.card")
        BROWSER.until("window.volccd_test && document.querySelector('.scenes canvas')")
        self.assertEqual(BROWSER.js("'#scenes/' + volccd_test.view.data.header.name"), card)

    def test_the_list_of_scenes(self):
        self.go("scenes")
        self.make_small()
        BROWSER.until("window.volccd_test")
        names = BROWSER.js("[...document.querySelector('select[name=scene]').options].map(o => o.value)")
        self.assertIn(Path(LIVER).stem, names)
        for name in sorted(names, key=lambda n: n == Path(LIVER).stem):
            BROWSER.set("select[name=scene]", name)
            BROWSER.until(f"volccd_test.view.data && volccd_test.view.data.header.name === {json.dumps(name)}")
        self.assertIn("differs from that of the measured file", self.text(".notes"))
        self.opens("details:not(.choices)", "Missing scenes")

    def test_a_report_opens_with_the_certified_table_and_the_motion_with_most_contacts(self):
        self.go("overview")
        self.assertRegex(BROWSER.js("document.querySelector('#figure-speedup select').selectedOptions[0].text"),
                         r"^Table I-c")
        self.go("scenes")
        self.make_small()
        BROWSER.until("window.volccd_test")
        contacts, shown = BROWSER.js("(v => [v.data.header.motions.map(m => m.stats.contacts), v.clock.textContent])"
                                     "(volccd_test.view)")
        busiest = contacts.index(max(contacts))
        self.assertGreater(busiest, 0, "the scene shows nothing")
        self.assertIn(f"frames {busiest} →", shown)
        self.assertLess(self.away_from_contacts(), 1e-6)

    def away_from_contacts(self):
        """The distance of the camera's target from the middle of the contacts of the step."""
        return BROWSER.js("""(({data, target, motion}) => { const first = data.firstMark[motion];
            const count = data.header.motions[motion].shown;
            return Math.hypot(...[0, 1, 2].map(axis => { const values = [...data.marks[axis].slice(first, first + count)];
              return target.getComponent(axis) - (Math.min(...values) + Math.max(...values)) / 2 / 65535; })); })
            (volccd_test.viewer)""")

    def test_an_unknown_scene_is_named(self):
        self.go("scenes/no-such-scene")
        self.assertIn("There is no scene no-such-scene here.", self.text("main .error"))
        self.go("scenes/octopi")
        self.assertIn("This is", self.text("main .error"))
        self.go("scenes")
        self.assertEqual(self.count("main .error"), 0)

    def test_nothing_is_wider_than_a_narrow_window(self):
        narrow = Browser(420, 800)
        try:
            for place in ("overview", "tables/table1", "tables/plus", "tables/projectile", "figures", "scenes"):
                narrow.open("about:blank")
                narrow.open(f"file://{FOLDER}/report/index.html#{place}")
                narrow.until("'ready' in document.body.dataset")
                self.assertLessEqual(narrow.js("document.documentElement.scrollWidth"), 420, place)
        finally:
            narrow.close()

    def test_dark_mode(self):
        self.go("tables/table1")
        colour = "getComputedStyle(document.querySelector('{}')).{}"
        light = [BROWSER.js(colour.format(s, "backgroundColor")) for s in ("body", "table.data th")]
        BROWSER.call("Emulation.setEmulatedMedia", media="", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        try:
            dark = [BROWSER.js(colour.format(s, "backgroundColor")) for s in ("body", "table.data th")]
            ink = BROWSER.js(colour.format("body", "color"))
        finally:
            BROWSER.call("Emulation.setEmulatedMedia", media="", features=[])
        self.assertEqual((light, dark, ink), (["rgb(255, 255, 255)"] * 2, ["rgb(23, 27, 33)"] * 2, "rgb(228, 232, 238)"))

    def opens(self, selector, text):
        """A click on the summary opens or closes the details."""
        self.assertIn(text, self.text(f"{selector} summary"))
        self.changes(f"document.querySelector({json.dumps(selector)}).open", lambda: BROWSER.click(f"{selector} summary"),
                     text)

    def test_marks_and_bars_open_their_scene(self):
        self.go("figures")
        for figure in ("explorer", "culling", "curves"):
            self.opens(f"#figure-{figure} .choices", "(")
        self.make_small()
        act = {"click": lambda selector: BROWSER.js(
                   f"document.querySelector('{selector}').dispatchEvent(new MouseEvent('click', {{bubbles: true}}))"),
               "key": lambda selector: (BROWSER.js(f"document.querySelector('{selector}').focus()"),
                                        BROWSER.key("Enter", text="\r"))}
        for figure, mark in (("explorer", "g.pick"), ("stages", "rect.pick"), ("culling", "g.pick"), ("curves", "g.pick")):
            for way, do in act.items():
                do(f"#figure-{figure} {mark}")
                BROWSER.until("!document.querySelector('.drawer').hidden")
                self.assertIn("Where the numbers come from", self.text(".drawer"), f"{figure}, {way}")
                if self.count(".drawer details"):
                    self.opens(".drawer details", "Medians over rounds")
                BROWSER.key("Escape")
                BROWSER.until("document.querySelector('.drawer').hidden")

    def test_columns_of_tables_are_plotted(self):
        self.go("tables/table1")
        BROWSER.click(".table-block .plot")
        BROWSER.until("document.querySelector('.table-chart svg.chart')")
        picture = "document.querySelector('.table-chart svg.chart').outerHTML"
        for box in range(1, self.count(".table-block:first-of-type .controls input") + 1):
            self.changes(picture, lambda b=box: BROWSER.click(f".table-chart .controls label:nth-child({b}) input"),
                    f"box {box}")
        BROWSER.click(".table-block .plot")
        BROWSER.until("!document.querySelector('.table-chart')")
        for name in ("projectile", "plus", "scenes"):
            self.changes("document.querySelector('main h2').textContent",
                    lambda n=name: BROWSER.click(f".list a[href='#tables/{n}']"), name)

    def test_a_click_on_a_row_shows_its_scene(self):
        self.go("tables/projectile")
        self.make_small()
        BROWSER.click("tr.has-scene td")
        BROWSER.until("window.volccd_test && document.querySelector('.drawer canvas')")
        self.assertIn("builtin", self.text(".drawer"))
        self.assertGreater(BROWSER.js(f"new Set({PICTURE}).size"), 30)
        self.redraws(lambda: BROWSER.set(".drawer .time", "60"), "the slider")
        BROWSER.click(".drawer button[name=close]")
        BROWSER.until("document.querySelector('.drawer').hidden")
        BROWSER.js("document.querySelector('tr.has-scene').focus()")
        BROWSER.key("Enter", text="\r")
        BROWSER.until("!document.querySelector('.drawer').hidden")
        BROWSER.click(".drawer .scene-name a")
        BROWSER.until("document.querySelector('.scenes canvas')")

    def test_controls_of_figures(self):
        self.go("figures")
        for figure in ("speedup", "explorer", "stages", "culling", "curves"):
            chart = f"document.querySelector('#figure-{figure} figure').outerHTML"
            controls = BROWSER.js(f"[...document.querySelectorAll('#figure-{figure} select')].map(s => s.name)")
            for name in controls:
                values = BROWSER.js(f"[...document.querySelector('#figure-{figure} select[name=\"{name}\"]').options].map(o => o.value)")
                if len(values) > 1:
                    selector = f"#figure-{figure} select[name=\"{name}\"]"
                    now = BROWSER.js(f"document.querySelector({json.dumps(selector)}).value")
                    other = next(v for v in reversed(values) if v != now)
                    self.changes(chart, lambda s=selector, o=other: BROWSER.set(s, o), f"{figure}: {name}")
            boxes = self.count(f"#figure-{figure} input[type=checkbox]")
            self.assertGreater(boxes, 0, figure)
            for i in range(boxes):
                # A box for x alone has no effect on categories; therefore `motion` is chosen above.
                self.changes(chart, lambda f=figure, i=i: BROWSER.js(
                    f"document.querySelectorAll('#figure-{f} input[type=checkbox]')[{i}].click()"),
                            f"{figure}: box {i}")
                BROWSER.js(f"document.querySelectorAll('#figure-{figure} input[type=checkbox]')[{i}].click()")
        BROWSER.hover("#figure-speedup g[role=img]")
        BROWSER.until("!document.querySelector('.tip').hidden")
        self.assertIn("commit", self.text(".tip"))
        BROWSER.click("#figure-speedup g[role=img]")
        BROWSER.until("!document.querySelector('.drawer').hidden")

    def test_print_style_leaves_the_controls_out(self):
        self.go("tables/table1")
        BROWSER.call("Emulation.setEmulatedMedia", media="print")
        shown = "getComputedStyle(document.querySelector('{}')).display"
        self.assertEqual([BROWSER.js(shown.format(s)) for s in (".plot", ".list", "table.data")], ["none", "none",
                "table"])
        BROWSER.call("Emulation.setEmulatedMedia", media="")


class View(Page):
    report = "view"

    def setUp(self):
        super().setUp()
        self.go("")
        self.make_small()
        BROWSER.until("window.volccd_test")

    def clock(self):
        return self.text(".clock")

    def test_time(self):
        self.assertIn("frames 0 → 1 of 6", self.clock())
        self.redraws(lambda: BROWSER.set(".time", "70"), "the slider")
        self.assertIn("frames 3 → 4 of 6, at 0.50", self.clock())
        self.redraws(lambda: BROWSER.click("button[aria-label='next step']"), "next")
        self.assertIn("frames 4 → 5", self.clock())
        self.redraws(lambda: BROWSER.click("button[aria-label='previous step']"), "previous")
        BROWSER.set(".time", "0")
        self.redraws(lambda: BROWSER.click(".timeline"), "the strip of contacts")
        self.changes("document.querySelector('.funnel-box').textContent", lambda: BROWSER.set(".time", "0"), "funnel")
        BROWSER.set(".speed", "60")
        self.redraws(lambda: BROWSER.click(".play"), "play")
        self.assertIn("Stop", self.text(".play"))
        BROWSER.until("document.querySelector('.pace').textContent.includes('pictures a second')")
        BROWSER.click(".play")
        self.assertIn("Play", self.text(".play"))

    def test_each_picture_is_drawn_from_the_frames_of_its_motion(self):
        BROWSER.js("""(() => { const v = volccd_test.viewer, {header, frames, shown, corners} = v.data;
            window.pictures = [], window.wrong = [];
            v.onDraw = () => {
              pictures.push(v.motion + v.t);
              for (const f of [v.motion, Math.min(v.motion + 1, frames.length - 1)]) v.mesh.vertexOf.forEach((vertex, i) => {
                for (let axis = 0; axis < 3; ++axis)
                  if (v.positions[f % 2].array[4 * i + axis] !== frames[f][axis * header.vertices + vertex])
                    wrong.push(`frame ${f} in motion ${v.motion}`);
              });
              if (v.materials[0].uniforms.share.value !== (v.motion % 2 ? 1 - v.t : v.t)) wrong.push(`t of ${v.motion}`);
              shown[v.motion].forEach((triangle, i) => {
                if (v.mesh.vertexOf[v.indices[0].array[3 * i]] !== corners[0][triangle]) wrong.push(`triangle ${triangle}`);
              });
            }; })()""")
        for speed, pictures in ((60, 12), (6, 12)):  # with motions skipped, and with several pictures of a motion
            BROWSER.js("pictures.length = 0")
            BROWSER.set(".speed", str(speed))
            BROWSER.click(".play")
            BROWSER.until(f"pictures.length >= {pictures}")
            BROWSER.click(".play")
            self.assertGreater(BROWSER.js("new Set(pictures).size"), 4)
        for value in (0, 70, 20, 120, 59, 119):
            BROWSER.set(".time", str(value))
            BROWSER.until(f"Math.abs(pictures[pictures.length - 1] - {value / 20}) < 1e-9")
        self.assertEqual(BROWSER.js("wrong.slice(0, 5)"), [])

    def test_keys_without_a_click(self):
        self.assertTrue(BROWSER.js("document.activeElement === document.body"))
        self.redraws(lambda: BROWSER.key("ArrowRight"), "ArrowRight")
        self.redraws(lambda: BROWSER.key("w", text="w"), "w")

    def test_keys(self):
        BROWSER.js("document.querySelector('canvas').focus()")
        for key, text in (("ArrowRight", None), ("End", None), ("ArrowLeft", None), ("Home", None), ("w", "w"), ("a",
                "a"), ("s", "s"),
                          ("d", "d"), ("+", "+"), ("-", "-")):
            self.redraws(lambda k=key, t=text: BROWSER.key(k, text=t), key)
        BROWSER.key("+", text="+")
        self.redraws(lambda: BROWSER.key("f", text="f"), "f")
        self.redraws(lambda: BROWSER.key(" ", "Space", " "), "space")
        BROWSER.key(" ", "Space", " ")

    def test_camera(self):
        self.redraws(lambda: BROWSER.drag("canvas", 60, 30), "dragging")
        self.redraws(lambda: BROWSER.drag("canvas", 60, 30, modifiers=8), "dragging with shift")
        self.redraws(lambda: BROWSER.mouse("mouseWheel", *BROWSER.place("canvas"), deltaX=0, deltaY=200), "the wheel")
        for axis in "102":
            self.redraws(lambda a=axis: BROWSER.set("select[name=up]", a), f"{axis} upwards")
        self.go_to_contacts()
        for view in ("x", "y", "z", "default", "contacts", "default"):
            self.redraws(lambda v=view: BROWSER.click(f"button[name=view-{v}]"), view)

    def go_to_contacts(self):
        """To a step with contacts between objects, and within an object if there is such a step."""
        marked = BROWSER.js("volccd_test.view.data.header.motions.findIndex(m => m.inter > 0 && m.inter < m.stats.contacts)")
        if marked < 0:
            marked = BROWSER.js("volccd_test.view.data.header.motions.findIndex(m => m.inter > 0)")
        self.assertGreaterEqual(marked, 0)
        BROWSER.set(".time", str(20 * marked))

    def test_display_and_objects(self):
        self.go_to_contacts()
        self.redraws(lambda: BROWSER.click("input[name=lines]"), "edges")
        self.redraws(lambda: BROWSER.click("input[name=marks]"), "contacts")
        BROWSER.click("input[name=marks]")
        self.redraws(lambda: BROWSER.set("select[name=kinds]", "0"), "contacts within an object")
        self.redraws(lambda: BROWSER.set("select[name=kinds]", "1"), "contacts between objects")
        for name in ("input[name=object-0]", "button[name=no-objects]", "button[name=all-objects]"):
            self.redraws(lambda n=name: BROWSER.click(n), name)

    def test_section_planes(self):
        for axis in "xyz":
            self.redraws(lambda a=axis: BROWSER.click(f"input[name=cut-{a}]"), f"section {axis}")
            self.redraws(lambda a=axis: BROWSER.set(f"input[name=at-{a}]", "400"), f"place {axis}")
            self.redraws(lambda a=axis: BROWSER.click(f"button[name=flip-{a}]"), f"flip {axis}")
            BROWSER.click(f"input[name=cut-{axis}]")

    def test_the_funnel_has_the_counts_of_the_stages(self):
        stats = FOLDER / "stats.json"
        run(FOLDER, "detect", FOLDER / "run.vtkhdf", "--pipeline", "VolCCD+", "--stats", stats)
        # The stages of `detect` are not compared: it lists initial overlaps, too, for which the flood cannot be used.
        contacts = [step["contacts"] for step in json.loads(stats.read_text())["steps"]]
        motions = BROWSER.js("volccd_test.view.data.header.motions")
        self.assertEqual([m["stats"]["contacts"] for m in motions], contacts)
        self.assertGreater(sum(contacts), 0)
        for k, motion in enumerate(motions):
            BROWSER.set(".time", str(20 * k))
            text = self.text(".funnel-box").replace(",", "")
            self.assertIn(f": {contacts[k]} contacts", text)
            for stage in motion["stats"]["stages"]:
                if stage["out"]:
                    self.assertIn(f"{stage['name']}", text)
                    self.assertIn(str(stage["out"]), text)
        BROWSER.hover(".funnel tbody tr:nth-child(2)")
        BROWSER.until("document.querySelector('.tip') && !document.querySelector('.tip').hidden")
        self.assertRegex(self.text(".tip"), "took|gave")

    def go_to_dropped_pairs(self):
        """The motion and the stage that dropped the most pairs of elements or features."""
        motions = BROWSER.js("volccd_test.view.data.header.motions")
        filters = ("element-culling", "feature-filter")
        _, k, stage = max((s["in"] - s["out"], k, i) for k, m in enumerate(motions)
                          for i, s in enumerate(m["stats"]["stages"]) if s["role"] in filters)
        BROWSER.set(".time", str(20 * k + 10))
        return k, stage, motions[k]

    def test_the_pairs_of_a_stage(self):
        _, stage, motion = self.go_to_dropped_pairs()
        counts, (dropped, kept) = motion["stats"]["stages"][stage], motion["pairs"][stage]
        self.assertGreater(dropped, 0)
        self.assertEqual(BROWSER.js("document.querySelectorAll('.pair-legend').length"), 0)
        choose = f".stage-choice[data-stage='{stage}']"
        self.redraws(lambda: BROWSER.click(choose), "a click on a stage")
        self.assertEqual(BROWSER.js(f"document.querySelector(\"{choose}\").ariaPressed"), "true")
        legend = self.text(".pair-legend").replace(",", "")
        for name, count, drawn in (("dropped", counts["in"] - counts["out"], dropped), ("kept", counts["out"], kept)):
            self.assertRegex(legend, f"that it {name}: {count}" + (f" of which {drawn} are drawn" if drawn < count else ""))
        self.assertIn(str(counts["in"] - counts["out"]), legend)
        self.redraws(lambda: BROWSER.click(choose), "a second click")
        self.assertEqual(BROWSER.js("document.querySelectorAll('.pair-legend').length"), 0)

    def test_the_keys_of_stages(self):
        self.go_to_dropped_pairs()
        rows = BROWSER.js("[...document.querySelectorAll('.stage-choice')].map(b => b.dataset.stage)")
        BROWSER.js("document.querySelector('canvas').focus()")
        for place, stage in enumerate(rows, 1):
            BROWSER.key(str(place), text=str(place))
            BROWSER.until("document.querySelector('tr.chosen .stage-choice')")
            self.assertEqual(BROWSER.js("document.querySelector('tr.chosen .stage-choice').dataset.stage"), stage)
        self.changes("document.querySelector('.funnel-box').textContent", lambda: BROWSER.key("0", text="0"), "0")
        self.assertEqual(self.count("tr.chosen"), 0)

    def test_a_pair_tells_what_it_is(self):
        _, stage, _ = self.go_to_dropped_pairs()
        BROWSER.click("input[name=marks]")
        BROWSER.click(f".stage-choice[data-stage='{stage}']")
        BROWSER.hover("canvas")
        x, y = BROWSER.js("""(() => { const v = volccd_test.viewer, b = v.canvas.getBoundingClientRect();
            v.drawNow(); const {first, dropped} = v.pairs.range(v.motion, v.stage);
            for (let i = 0; i < dropped; ++i) {  // one whose line no other line hides
              const [p, q] = v.data.pairAt(first + i), c = v.onCanvas(p.map((a, k) => (a + q[k]) / 2));
              const x = Math.round(b.x + c.x), y = Math.round(b.y + c.y);
              if (v.pairAt(x - b.x, y - b.y) === i) return [x, y];
            }
            throw new Error("the lines of kept pairs hide all dropped ones"); })()""")
        BROWSER.mouse("mouseMoved", x, y)
        BROWSER.until("document.querySelector('.tip') && !document.querySelector('.tip').hidden")
        self.assertRegex(self.text(".tip"), r"^(Element pair|Vertex-triangle test|Edge-edge test), dropped by .+\.$")


# The elements that the tests above click, drag or type into. A new control needs a test, and then a line here.
CONTROLS = {
    "report": ["a.skip", "header a", ".records a", "a.card", ".list a", ".sort", ".plot", "table.data tr[tabindex]",
               ".controls select", ".controls input", ".choices summary", ".choices input", "svg.chart .pick",
               "select[name=scene]", ".scenes > details > summary"],
    "view": ["a.skip", "header a", "canvas", ".timeline", ".time", ".speed", ".play", "button[aria-label='next step']",
             "button[aria-label='previous step']", ".stage-choice", "input[name=lines]", "input[name=marks]",
             "select[name=kinds]", "select[name=up]", "button[name^=view-]", "input[name^=cut-]", "input[name^=at-]",
             "button[name^=flip-]", "input[name^=object-]", "button[name=all-objects]", "button[name=no-objects]"],
    "drawer": ["button[name=close]", ".scene-name a", "details summary"]}


class Controls(Page):
    def test_each_control_is_one_that_a_test_uses(self):
        found = set()
        for report, places in (("report", ("overview", "tables/table1", "figures", "scenes")), ("view", ("",))):
            self.report = report
            for place in places:
                self.go(place)
                if report == "view" or place == "scenes":
                    BROWSER.until("window.volccd_test")
                if place == "tables/table1":
                    BROWSER.click(".plot")
                    BROWSER.click("tr.has-scene td")
                    BROWSER.until("!document.querySelector('.drawer').hidden && window.volccd_test")
                known = CONTROLS["report"] + CONTROLS["view"] + [f".drawer {c}" for c in CONTROLS["drawer"]]
                unknown, used = BROWSER.js(f"""(() => {{ const known = {json.dumps(known)};
                    const all = [...document.querySelectorAll('a[href], button, select, input, summary, canvas, .timeline, [tabindex="0"]')];
                    return [all.filter(e => !known.some(k => e.matches(k))).map(e => e.outerHTML.slice(0, 200)),
                            known.filter(k => all.some(e => e.matches(k)))]; }})()""")
                self.assertEqual(unknown, [], f"{report} {place}")
                found.update(used)
        self.assertEqual(found, set(known))


if __name__ == "__main__":
    if not CHROMIUM:
        print("skipped: there is no Chromium here (Debian: chromium)")
        sys.exit(77)
    unittest.main()
