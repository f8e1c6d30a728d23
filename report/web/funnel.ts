// The numbers of pairs that each stage of the pipeline took and kept in one step, as bars on a logarithmic scale.
import {duration, grouped, h, percent, svg, tooltip} from "./dom";
import type {Motion, MotionStats, StageCount} from "./types";

interface Row {
  stage: number;  ///< index into the statistics
  label: string;
  detail: string;
  unit: string;
  from: number|null;  ///< number before the stage, in the unit of `to`; null: the unit is different
  to: number;
  seconds: number;
}

const kRoles: {[role: string]: {label: string; unit: string; filters: boolean}} = {
  "broad-phase": {label: "Broad phase", unit: "element pairs", filters: false},
  "element-culling": {label: "Element culling", unit: "element pairs", filters: true},
  assignment: {label: "Assignment", unit: "tests", filters: false},
  orphans: {label: "Orphan source", unit: "tests", filters: false},
  flood: {label: "Boundary flood", unit: "element pairs", filters: false},
  "feature-filter": {label: "Feature filter", unit: "tests", filters: true},
  "narrow-phase": {label: "Elementary tests", unit: "contacts", filters: true},
};

function rowOf(count: StageCount, stage: number): Row|null {
  const role = kRoles[count.role];
  if (!role) return null;
  return {
    stage,
    label: role.label,
    detail: count.name,
    unit: role.unit,
    from: role.filters ? count.in : null,
    to: count.out,
    seconds: count.prepare_seconds + count.seconds
  };
}

/// The stages of a step that process anything, and the chosen one.
function rowsOf(stats: MotionStats, chosen: number|null): Row[] {
  return stats.stages.map(rowOf)
      .filter((row): row is Row => row !== null)
      .filter((row) => row.to > 0 || (row.from ?? 0) > 0 || row.label === "Elementary tests" || row.stage === chosen);
}

/// The stage in row `place` of the funnel; null if there is no such row.
export function stageAt(stats: MotionStats, chosen: number|null, place: number): number|null {
  return rowsOf(stats, chosen)[place]?.stage ?? null;
}

function sentence(row: Row): string {
  const time = `Time: ${duration(row.seconds)}. Click to show its pairs.`;
  if (row.from === null) return `${row.label} (${row.detail}) gave ${grouped(row.to)} ${row.unit}. ${time}`;
  const dropped = row.from - row.to;
  const share = row.from > 0 ? ` (${percent(dropped / row.from)})` : "";
  return row.unit === "contacts" ?
      `${row.label} (${row.detail}) took ${grouped(row.from)} tests and found ${grouped(row.to)} contacts. ${time}` :
      `${row.label} (${row.detail}) took ${grouped(row.from)} ${row.unit}, dropped ${grouped(dropped)}${
          share} and kept ${grouped(row.to)}. ${time}`;
}

function bar(row: Row, max: number): SVGElement {
  const width = 190, scale = (n: number) => (n <= 0 ? 0 : (width * Math.log10(1 + n)) / Math.log10(1 + max));
  const colour = row.unit === "contacts" ? "#c8102e" : row.unit === "tests" ? "#0072b2" : "#5b6b7f";
  return svg(
      "svg", {viewBox: `0 0 ${width} 18`, preserveAspectRatio: "none", height: 18, "aria-hidden": "true"},
      row.from !== null ? svg("rect", {x: 0, y: 2, width: scale(row.from), height: 14, fill: "#d5dae1"}) : null,
      svg("rect", {x: 0, y: 2, width: Math.max(scale(row.to), row.to > 0 ? 2 : 0), height: 14, fill: colour}));
}

/// The funnel of a step. `choose` gets the stage whose row is clicked, or null if this stage was chosen already.
export function funnel(
    stats: MotionStats, max: number, chosen: number|null, choose: (stage: number|null) => void): HTMLElement {
  const body = rowsOf(stats, chosen).map((row, place) => {
    const dropped = row.from !== null && row.unit !== "contacts" && row.from > 0 ?
        `−${percent((row.from - row.to) / row.from)}` :
        "";
    const on = row.stage === chosen, act = () => choose(on ? null : row.stage);
    const button =
        h("button", {class: "stage-choice", "data-stage": row.stage, "aria-pressed": String(on), onclick: act},
          row.label, h("small", {}, row.detail));
    if (place < 9) button.setAttribute("aria-keyshortcuts", String(place + 1));
    const line =
        h("tr", {class: on ? "chosen" : ""}, h("th", {scope: "row"}, button), h("td", {onclick: act}, bar(row, max)),
          h("td", {class: "number"}, grouped(row.to), h("small", {}, row.unit.replace("element ", ""))),
          h("td", {class: "number"}, dropped), h("td", {class: "number"}, duration(row.seconds)));
    line.addEventListener("mousemove", (e) => tooltip(sentence(row), e.clientX, e.clientY));
    line.addEventListener("mouseleave", () => tooltip(null));
    return line;
  });
  return h(
      "table", {class: "funnel"},
      h("caption", {},
        "What each stage kept (dark) of what it took in (light); logarithmic. " +
            "Click a stage, or press its number, to show its pairs."),
      h("thead", {},
        h("tr", {}, h("th", {}, "stage"), h("th", {}, ""), h("th", {}, "kept"), h("th", {}, "dropped"),
          h("th", {}, "time"))),
      h("tbody", {}, ...body));
}

/// Which pairs of a stage are drawn, and how many there are.
export function pairLegend(motion: Motion, stage: number): HTMLElement|null {
  const row = rowOf(motion.stats.stages[stage], stage);
  if (!row) return null;
  const key = (form: string, text: string, count: number, drawn: number) =>
      h("p", {class: "key"}, h("i", {class: `line ${form}`}),
        `${text}: ${grouped(count)}` + (drawn < count ? `, of which ${grouped(drawn)} are drawn` : ""));
  const [dropped, kept] = motion.pairs[stage], orphans = orphansOfFlood(motion.stats, stage);
  const unit = row.unit === "contacts" ? "tests" : row.unit;
  return h(
      "div", {class: "pair-legend", role: "status"},
      row.from === null ?
          key("kept", `${orphans ? "element pairs and orphan tests" : row.unit} that it gave`, row.to + orphans, kept) :
          h("div", {}, key("dropped", `${unit} that it dropped`, row.from - row.to, dropped),
            key("kept", row.unit === "contacts" ? "tests that are contacts" : `${unit} that it kept`, row.to, kept)),
      h("p", {},
        "A line joins the centroids of the two elements or features in the middle of the step; it is pale behind a " +
            "surface."));
}

/// Number of orphan tests that a flood listed; they are not in the output count of the stage.
function orphansOfFlood(stats: MotionStats, stage: number): number {
  const given = stats.stages.filter((s) => s.role === "orphans").reduce((sum, s) => sum + s.out, 0);
  return stats.stages[stage].role === "flood" ? stats.orphan_tests - given : 0;
}

/// The largest count of any stage in any step, so that all funnels of a scene have one scale.
export function largestCount(all: MotionStats[]): number {
  return Math.max(10, ...all.flatMap((s) => s.stages.flatMap((stage) => [stage.in, stage.out])));
}
