// The origin of a number: the record, how and where it was measured, and the rows that it summarises.
import {duration, grouped, h, short} from "./dom";
import type {DataRecord, Machine, Report, SceneEntry} from "./types";

/// A line for a tooltip.
export function provenanceLine(record: DataRecord, scene?: string): string {
  const p: Machine = (scene && record.provenance.scenes?.[scene]) || record.provenance;
  return `${record.file} · commit ${p.commit ?? "unknown"} · ${p.cpu ?? "unknown CPU"} · load ${
             p.load ?? "unknown"} · ${p.date ?? ""}\n` +
      `${record.command}\nClick for the scene and all details.`;
}

function line(name: string, value: string|number|null|undefined): HTMLElement|null {
  return value === undefined || value === null || value === "" ?
      null :
      h("tr", {}, h("th", {scope: "row"}, name), h("td", {}, String(value)));
}

export function provenanceTable(record: DataRecord, scene?: string): HTMLElement {
  const own = scene ? record.provenance.scenes?.[scene] : undefined;
  const p = {...record.provenance, ...own};
  const inputs = (record.provenance.inputs ?? []).filter((i) => !scene || i.scene === scene);
  return h(
      "table", {class: "provenance"},
      h("tbody", {}, line("record", record.file), line("rows in it", record.row_count), line("command", record.command),
        line("commit", p.commit), line("version", p.version), line("CPU", p.cpu), line("vector kernels", p.isa),
        line("cores", p.cores), line("cores allowed", p.allowed_cores), line("kernel", p.kernel),
        line("load", p.load), line("load at the end", p.load_at_end), line("threads", p.threads), line("rounds", p.rounds), line("setting", p.setting),
        line("date (UTC)", p.date), line("compiler", p.compiler), line("flags", p.flags),
        ...inputs.map((i) => line(`input, ${i.scene}`, `${i.file}, hash ${i.fnv1a}`))));
}

/// Measured rows of a scene of a record, up to a maximum number.
export function rowsOf(report: Report, record: DataRecord, scene: string, max = 40): HTMLElement|null {
  const points = report.points;
  if (!points) return null;
  const {texts, columns} = points;
  const found: number[] = [];
  for (let i = 0; i < columns.record.length; ++i)
    if (texts[columns.record[i]!] === record.name && texts[columns.scene[i]!] === scene) found.push(i);
  if (!found.length) return null;
  const text = (column: string, i: number) => texts[columns[column][i]!] ?? "";
  const head = ["table", "pipeline", "variant", "step", "rounds", "time", "tests", "contacts"];
  return h(
      "details", {}, h("summary", {}, `Medians over rounds of ${scene} in this record (${found.length})`),
      h("div", {class: "scroll"},
        h("table", {}, h("thead", {}, h("tr", {}, ...head.map((n) => h("th", {}, n)))),
          h("tbody", {},
            ...found.slice(0, max).map(
                (i) =>
                    h("tr", {}, h("td", {}, text("table", i)), h("td", {}, text("pipeline", i)),
                      h("td", {}, text("variant", i)), h("td", {class: "number"}, String(columns.step[i])),
                      h("td", {class: "number"}, String(columns.rounds[i])),
                      h("td", {class: "number"}, duration(columns.seconds[i] ?? 0)),
                      h("td", {class: "number"}, grouped((columns.vf_tests[i] ?? 0) + (columns.ee_tests[i] ?? 0))),
                      h("td", {class: "number"}, grouped(columns.contacts[i] ?? 0))))))),
      found.length > max ? h("p", {}, `The first ${max} of ${found.length}; the record has all.`) : null);
}

/// The scene of a row: named by a cell, or else by the title of the table.
export function sceneOf(
    report: Report, record: DataRecord, title: string, row: string[]): {name?: string; entry?: SceneEntry} {
  const names = [...new Set(report.scenes.map((s) => s.scene).concat(record.curves.map((c) => c.scene)))];
  const name = row.find((cell) => names.includes(cell)) ??
      names.find((n) => title.startsWith(`${n}:`) || new RegExp(`\\bon ${n}\\b`).test(title));
  if (!name) return {};
  const all = report.scenes.filter((s) => s.scene === name);
  const own = all.filter((s) => s.records.includes(record.name));
  const best = (own.length ? own : all)
                   .sort((a, b) => Number(!!a.missing) - Number(!!b.missing) || (b.elements ?? 0) - (a.elements ?? 0));
  return {name, entry: best[0]};
}

export function describe(entry: SceneEntry): string {
  return entry.missing ? `${entry.scene}, missing` :
                         `${entry.scene}, ${grouped(entry.elements ?? 0)} elements, ${short(entry.frames ?? 0)} frames`;
}
