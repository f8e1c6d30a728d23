// Figures from the rows of the records, with scenes, pipelines, axes and scales to choose.
import {Bar, bars, chart, Series} from "./chart";
import {check, duration, grouped, h, percent, select, short} from "./dom";
import {noteOf, tableChart, PickRow} from "./tables";
import {provenanceLine} from "./provenance";
import type {DataRecord, Report} from "./types";

interface Point {
  record: string;
  group: string;  ///< record, table and treatment of what is measured together
  scene: string;
  label: string;  ///< pipeline and variant
  step: number;
  elements: number;
  of: (column: string) => number;
}

const kStages: [string, string][] = [
  ["broad_phase_s", "broad phase"], ["element_culling_s", "element culling"], ["assignment_s", "assignment"],
  ["orphans_s", "orphan source"], ["flood_s", "boundary flood"], ["feature_filter_s", "feature filters"],
  ["narrow_phase_s", "elementary tests"]
];

const tests = (p: Point) => p.of("vf_tests") + p.of("ee_tests");
const kMeasures: {[name: string]: {label: string; of: (p: Point) => number; text: (v: number) => string}} = {
  time: {
    label: "time of a step, ms (median over rounds)",
    of: (p) => 1e3 * p.of("seconds"),
    text: (v) => duration(v / 1e3)
  },
  tests: {label: "elementary tests of a step", of: tests, text: grouped},
  pairs: {label: "element pairs of the broad phase", of: (p) => p.of("element_pairs"), text: grouped},
  surviving: {label: "element pairs after culling", of: (p) => p.of("surviving_pairs"), text: grouped},
  contacts: {label: "contacts of a step", of: (p) => p.of("contacts"), text: grouped},
  cost: {
    label: "nanoseconds of an elementary test",
    of: (p) => (tests(p) ? (1e9 * p.of("narrow_phase_s")) / tests(p) : NaN),
    text: (v) => `${short(v)} ns`
  },
};

function pointsOf(report: Report): Point[] {
  if (!report.points) return [];
  const {texts, columns} = report.points, list: Point[] = [];
  for (let i = 0; i < (columns.record?.length ?? 0); ++i) {
    const text = (c: string) => texts[columns[c][i]!] ?? "";
    const treatment = [
      text("table") && `table ${text("table")}`, text("motion_model"), text("edges"), text("mesh"),
      columns.motion_scale[i] !== 1 && columns.motion_scale[i] ? `motion x ${columns.motion_scale[i]}` : ""
    ].filter((t) => t).join(", ");
    list.push({
      record: text("record"),
      group: `${text("record")}: ${treatment}`,
      scene: text("scene"),
      label: text("pipeline") + (text("variant") ? ` ${text("variant")}` : "") +
          ((columns.threads[i] ?? 1) > 1 ? `, ${columns.threads[i]} threads` : ""),
      step: columns.step[i] ?? 0,
      elements: columns.elements[i] ?? 0,
      of: (c) => columns[c]?.[i] ?? 0
    });
  }
  return list;
}

const unique = <T>(values: T[]): T[] => [...new Set(values)];
const median = (values: number[]) => {
  const sorted = [...values].sort((a, b) => a - b), n = sorted.length;
  return n % 2 ? sorted[n >> 1] : (sorted[n / 2 - 1] + sorted[n / 2]) / 2;
};

/// A list of boxes; those of `chosen` are ticked. A change updates `chosen`.
function choices(name: string, values: string[], chosen: Set<string>, changed: () => void): HTMLElement {
  const boxes = values.map((value) => check(name, value, chosen.has(value), (on) => {
                             if (on)
                               chosen.add(value);
                             else
                               chosen.delete(value);
                             changed();
                           }));
  return h(
      "details", {class: "choices", open: values.length <= 12}, h("summary", {}, `${name} (${values.length})`),
      h("div", {}, ...boxes));
}

export class Figures {
  private points: Point[];
  constructor(
      private report: Report, private pickPoint: (record: DataRecord, scene: string, motion?: number) => void,
      private pickRow: PickRow) {
    this.points = pointsOf(report);
  }

  element(): HTMLElement {
    const parts = [
      this.speedups(), this.points.length ? this.explorer() : null, this.points.length ? this.stages() : null,
      this.points.length ? this.culling() : null, this.curves()
    ].filter((p): p is HTMLElement => p !== null);
    return h(
        "div", {class: "figures"}, h("h2", {}, "Figures"),
        h("p", {}, "Hover over a mark for its number and where it comes from; click it for the scene and all details."),
        ...parts);
  }

  private record(name: string): DataRecord {
    return this.report.records.find((r) => r.name === name)!;
  }

  /// Table I with the paper's figures beside the measured ones.
  speedups(): HTMLElement|null {
    const record = this.record("table1");
    if (!record) return null;
    const tables = record.tables.filter((t) => t.header.includes("/Nav"));
    if (!tables.length) return null;
    const place = h("div");
    const draw = (i: string) => place.replaceChildren(
        tableChart(
            this.report, record, tables[Number(i)], this.pickRow,
            ["/Nav", "paper, /Nav", "/Hash", "paper, /Hash", "+/Nav"], "speed-up"),
        h("p", {class: "note"}, noteOf(tables[Number(i)])));
    const certified = String(Math.max(0, tables.findIndex((t) => t.title.startsWith("Table I-c"))));
    draw(certified);
    return h(
        "section", {class: "figure", id: "figure-speedup"}, h("h3", {}, "Speed-ups beside the paper's"),
        h("div", {class: "controls"}, select("table", tables.map((t, i) => [String(i), t.title]), certified, draw)),
        place);
  }

  private groups(): string[] {
    return unique(this.points.map((p) => p.group));
  }
  private defaultGroup(): string {
    const groups = this.groups();
    return groups.find((g) => g.startsWith("table1: table c, linear")) ?? groups[0];
  }

  private groupSelect(group: string, changed: (group: string) => void): HTMLElement {
    return select("measured in", this.groups().map((g) => [g, g]), group, changed);
  }

  /// Fills `top` with selectors of a group and of a scene in it, and with `box`. Calls `enter` with the points of the
  /// group at the beginning and when another group is chosen, and `draw` with those of the scene, now and whenever the
  /// scene changes. Returns a function that draws again.
  private chooseScene(
      top: HTMLElement, box: HTMLElement, enter: (all: Point[]) => void,
      draw: (own: Point[], scene: string) => void): () => void {
    let group = this.defaultGroup(), scene = "";
    const redraw = () => draw(this.points.filter((p) => p.group === group && p.scene === scene), scene);
    const fill = () => {
      const all = this.points.filter((p) => p.group === group), scenes = unique(all.map((p) => p.scene));
      scene = scenes.includes(scene) ? scene : scenes[0];
      const groups = this.groupSelect(group, (v) => {
        group = v;
        fill();
      });
      const one = select("scene", scenes.map((s) => [s, s]), scene, (v) => {
        scene = v;
        redraw();
      });
      top.replaceChildren(groups, one, box);
      enter(all);
      redraw();
    };
    fill();
    return redraw;
  }

  private explorer(): HTMLElement {
    const place = h("div"), boxes = h("div", {class: "choice-row"});
    let group = this.defaultGroup(), measure = "time", against = "scene", logX = false, logY = true;
    let scenes = new Set<string>(), pipelines = new Set<string>();
    const enter = () => {
      const own = this.points.filter((p) => p.group === group);
      const names = unique(own.map((p) => p.scene)), labels = unique(own.map((p) => p.label));
      scenes = new Set(names);
      pipelines = new Set(labels.slice(0, 8));
      boxes.replaceChildren(choices("scenes", names, scenes, draw), choices("pipelines", labels, pipelines, draw));
      draw();
    };
    const draw = () => {
      const own = this.points.filter((p) => p.group === group && scenes.has(p.scene) && pipelines.has(p.label));
      place.replaceChildren(this.explored(own, measure, against, logX, logY));
    };
    enter();
    return h(
        "section", {class: "figure", id: "figure-explorer"}, h("h3", {}, "Times and counts of the pipelines"),
        h("div", {class: "controls"}, this.groupSelect(group, (v) => {
          group = v;
          enter();
        }), select("show", Object.entries(kMeasures).map(([k, m]) => [k, m.label]), measure, (v) => {
            measure = v;
            draw();
          }), select("against", [["scene", "scene"], ["step", "step"], ["elements", "elements"]], against, (v) => {
            against = v;
            draw();
          }), check("log-x", "logarithmic x", logX, (on) => {
            logX = on;
            draw();
          }), check("log-y", "logarithmic y", logY, (on) => {
            logY = on;
            draw();
          })), boxes, place);
  }

  private explored(own: Point[], measure: string, against: string, logX: boolean, logY: boolean): HTMLElement {
    const m = kMeasures[measure], labels = unique(own.map((p) => p.label)), scenes = unique(own.map((p) => p.scene));
    const origin = (p: Point) => provenanceLine(this.record(p.record), p.scene);
    const pick = (p: Point, motion?: number) => () => this.pickPoint(this.record(p.record), p.scene, motion);
    const series: Series[] = [];
    if (against === "scene")
      for (const label of labels)
        series.push({
          name: label,
          marks: scenes.flatMap((scene, x) => {
            const some = own.filter((p) => p.label === label && p.scene === scene),
                  values = some.map(m.of).filter((v) => isFinite(v));
            if (!values.length) return [];
            const y = median(values), low = Math.min(...values), high = Math.max(...values);
            return [{
              x,
              y,
              low,
              high,
              pick: pick(some[0]),
              text: `${scene}, ${label}: ${m.text(y)}, median of ${values.length} steps ` +
                  `(${m.text(low)} to ${m.text(high)})\n${origin(some[0])}`
            }];
          })
        });
    else
      labels.forEach((label, index) => scenes.forEach((scene) => {
        const some = own.filter((p) => p.label === label && p.scene === scene);
        if (!some.length) return;
        const x = (p: Point) => (against === "step" ? p.step : p.elements);
        series.push({
          name: scenes.length > 1 ? `${scene}, ${label}` : label,
          index: scenes.length > 1 ? series.length : index,
          line: true,
          marks: some.sort((a, b) => x(a) - x(b))
                     .map((p) => ({
                            x: x(p),
                            y: m.of(p),
                            pick: pick(p, p.step),
                            text: `${scene}, ${label}, step ${p.step}: ${m.text(m.of(p))}\n${origin(p)}`
                          }))
        });
      }));
    return chart(series, {
      xLabel: against,
      yLabel: m.label,
      categories: against === "scene" ? scenes : undefined,
      logX,
      logY,
      zero: !logY
    });
  }

  private stages(): HTMLElement {
    const place = h("div"), top = h("div", {class: "controls"});
    let share = true;
    const draw = (own: Point[], scene: string) => {
      const list: Bar[] = unique(own.map((p) => p.label)).slice(0, 24).map((label) => {
        const some = own.filter((p) => p.label === label), total = median(some.map((p) => p.of("seconds")));
        const values = kStages.map(([column]) => median(some.map((p) => p.of(column))));
        const rest = Math.max(0, total - values.reduce((a, b) => a + b, 0));
        const parts = [...kStages.map(([, name], k) => ({name, value: values[k]})), {name: "rest", value: rest}].map(
            (part) => ({
              name: part.name,
              value: share ? (100 * part.value) / total : 1e3 * part.value,
              text: `${label}, ${part.name}: ${duration(part.value)}, ${percent(part.value / total)}\n${
                  provenanceLine(this.record(some[0].record), scene)}`
            }));
        return {
          name: label,
          parts,
          text: duration(total),
          pick: () => this.pickPoint(this.record(some[0].record), scene)
        };
      });
      place.replaceChildren(bars(list, share ? "share of the time, %" : "time of a step, ms"));
    };
    const box = check("share", "as shares", share, (on) => {
      share = on;
      redraw();
    });
    const redraw = this.chooseScene(top, box, () => {}, draw);
    return h(
        "section", {class: "figure", id: "figure-stages"}, h("h3", {}, "Where the time goes"),
        h("p", {class: "note"},
          "Medians over steps and rounds of each stage, preparation included. With several threads, stages are summed over them."),
        top, place);
  }

  private culling(): HTMLElement {
    const place = h("div"), top = h("div", {class: "controls"}), boxes = h("div", {class: "choice-row"});
    const columns: [string, (p: Point) => number][] = [
      ["pairs, broad phase", (p) => p.of("element_pairs")], ["pairs, after culling", (p) => p.of("surviving_pairs")],
      ["tests assigned", (p) => p.of("owned_tests") + p.of("orphan_tests")], ["tests performed", tests],
      ["contacts", (p) => p.of("contacts")]
    ];
    let logY = true, chosen = new Set<string>();
    const draw = (all: Point[], scene: string) => {
      const own = all.filter((p) => chosen.has(p.label));
      const series = unique(own.map((p) => p.label)).map((label) => {
        const some = own.filter((p) => p.label === label);
        return {
          name: label,
          line: true,
          marks: columns.map(([name, of], x) => ({
                               x,
                               y: median(some.map(of)),
                               pick: () => this.pickPoint(this.record(some[0].record), scene),
                               text: `${label}, ${name}: ${grouped(median(some.map(of)))} per step\n${
                                   provenanceLine(this.record(some[0].record), scene)}`
                             }))
        };
      });
      place.replaceChildren(chart(series, {
        categories: columns.map(([name]) => name),
        xLabel: "after which stage",
        yLabel: "count per step (median)",
        logY,
        zero: !logY
      }));
    };
    const box = check("log-y", "logarithmic", logY, (on) => {
      logY = on;
      redraw();
    });
    const enter = (all: Point[]) => {
      const labels = unique(all.map((p) => p.label));
      chosen = new Set(labels.slice(0, 8));
      boxes.replaceChildren(choices("pipelines", labels, chosen, () => redraw()));
    };
    const redraw = this.chooseScene(top, box, enter, draw);
    return h(
        "section", {class: "figure", id: "figure-culling"}, h("h3", {}, "What each stage leaves"), top, boxes, place);
  }

  /// Quantities of the scenes over time, from the records.
  private curves(): HTMLElement|null {
    const records = this.report.records.filter((r) => r.curves.length);
    if (!records.length) return null;
    const place = h("div"), top = h("div", {class: "controls"}), boxes = h("div", {class: "choice-row"});
    let record = records[0], name = "", logY = true, chosen = new Set<string>();
    const draw = () => {
      const series = record.curves.filter((c) => chosen.has(c.scene) && c.values[name]).map((c) => {
        const time = c.values.time ?? c.values[name].map((_, i) => i), end = time[time.length - 1] || 1;
        return {
          name: c.scene,
          index: record.curves.indexOf(c),
          line: true,
          marks: c.values[name].map((y, i) => ({
                                      x: (100 * time[i]) / end,
                                      y,
                                      pick: () => this.pickPoint(record, c.scene, c.values.step?.[i] ?? i),
                                      text: `${c.scene}, step ${c.values.step?.[i] ?? i}: ${name} ${short(y)}\n${
                                          provenanceLine(record, c.scene)}`
                                    }))
        };
      });
      place.replaceChildren(chart(series, {xLabel: "time, % of the sequence", yLabel: name, logY, zero: !logY}));
    };
    const enter = () => {
      const names = unique(record.curves.flatMap((c) => Object.keys(c.values)))
                        .filter((n) => n !== "time" && n !== "step")
                        .sort();
      name = names.includes(name) ?
          name :
          names.find((n) => n === "contacts, inter") ?? names.find((n) => n.startsWith("contacts")) ?? names[0];
      chosen = new Set(record.curves.map((c) => c.scene));
      top.replaceChildren(select("record", records.map((r) => [r.name, r.name]), record.name, (v) => {
                            record = this.record(v);
                            enter();
                          }), select("show", names.map((n) => [n, n]), name, (v) => {
                            name = v;
                            draw();
                          }), check("log-y", "logarithmic", logY, (on) => {
                            logY = on;
                            draw();
                          }));
      boxes.replaceChildren(choices("scenes", record.curves.map((c) => c.scene), chosen, draw));
      draw();
    };
    enter();
    return h("section", {class: "figure", id: "figure-curves"}, h("h3", {}, "The scenes over time"), top, boxes, place);
  }
}
