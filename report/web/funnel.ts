// What each stage of the pipeline took in and gave out in one motion, as bars on a logarithmic scale.
import {duration, grouped, h, percent, svg, tooltip} from "./dom";
import type {MotionStats, StageCount} from "./types";

interface Row {
  label: string;
  detail: string;
  unit: string;
  from: number|null;  ///< what came in, in the same unit as what went out; null: another unit
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

function rowOf(stage: StageCount): Row|null {
  const role = kRoles[stage.role];
  if (!role) return null;
  return {
    label: role.label,
    detail: stage.name,
    unit: role.unit,
    from: role.filters ? stage.in : null,
    to: stage.out,
    seconds: stage.prepare_seconds + stage.seconds
  };
}

function sentence(row: Row): string {
  const time = `Time: ${duration(row.seconds)}.`;
  if (row.from === null) return `${row.label} (${row.detail}) gave ${grouped(row.to)} ${row.unit}. ${time}`;
  const dropped = row.from - row.to, what = row.unit === "contacts" ? "tests" : row.unit;
  const share = row.from > 0 ? ` (${percent(dropped / row.from)})` : "";
  return row.unit === "contacts" ?
      `${row.label} (${row.detail}) took ${grouped(row.from)} tests and found ${grouped(row.to)} contacts. ${time}` :
      `${row.label} (${row.detail}) took ${grouped(row.from)} ${what}, dropped ${grouped(dropped)}${share} and kept ${
          grouped(row.to)}. ${time}`;
}

export function funnel(stats: MotionStats, most: number): HTMLElement {
  const rows = stats.stages.map(rowOf)
                   .filter((r): r is Row => r !== null)
                   .filter((r) => r.to > 0 || (r.from ?? 0) > 0 || r.label === "Elementary tests");
  const width = 190, scale = (n: number) => (n <= 0 ? 0 : (width * Math.log10(1 + n)) / Math.log10(1 + most));
  const body = rows.map((row) => {
    const bar =
        svg("svg", {viewBox: `0 0 ${width} 18`, preserveAspectRatio: "none", height: 18, "aria-hidden": "true"},
            row.from !== null ? svg("rect", {x: 0, y: 2, width: scale(row.from), height: 14, fill: "#d5dae1"}) : null,
            svg("rect", {
              x: 0,
              y: 2,
              width: Math.max(scale(row.to), row.to > 0 ? 2 : 0),
              height: 14,
              fill: row.unit === "contacts" ? "#c8102e" :
                  row.unit === "tests"      ? "#0072b2" :
                                              "#5b6b7f"
            }));
    const dropped = row.from !== null && row.unit !== "contacts" && row.from > 0 ?
        `−${percent((row.from - row.to) / row.from)}` :
        "";
    const line =
        h("tr", {tabindex: 0}, h("th", {scope: "row"}, row.label, h("small", {}, row.detail)), h("td", {}, bar),
          h("td", {class: "number"}, grouped(row.to), h("small", {}, row.unit.replace("element ", ""))),
          h("td", {class: "number"}, dropped), h("td", {class: "number"}, duration(row.seconds)));
    line.addEventListener("mousemove", (e) => tooltip(sentence(row), e.clientX, e.clientY));
    line.addEventListener("mouseleave", () => tooltip(null));
    return line;
  });
  return h(
      "table", {class: "funnel"},
      h("caption", {}, "What each stage kept (dark) of what it took in (light); logarithmic"),
      h("thead", {},
        h("tr", {}, h("th", {}, "stage"), h("th", {}, ""), h("th", {}, "kept"), h("th", {}, "dropped"),
          h("th", {}, "time"))),
      h("tbody", {}, ...body));
}

/// The largest count of any stage in any motion, so that all funnels of a scene have one scale.
export function largestCount(all: MotionStats[]): number {
  return Math.max(10, ...all.flatMap((s) => s.stages.flatMap((stage) => [stage.in, stage.out])));
}
