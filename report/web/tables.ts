// Tables that can be sorted, and a chart of their columns.
import {chart, Series} from "./chart";
import {check, h, tooltip} from "./dom";
import {provenanceLine, sceneOf} from "./provenance";
import type {DataRecord, DataTable, Report} from "./types";

const kUnits: {[unit: string]: number} = {
  s: 1,
  ms: 1e-3,
  us: 1e-6,
  "µs": 1e-6,
  K: 1e3,
  M: 1e6,
  GB: 1e9,
  MB: 1e6,
  KB: 1e3,
  B: 1,
  x: 1,
  "%": 1
};

/// The number at the beginning of a cell, in seconds or bytes if it has such a unit; NaN if there is none.
export function numberOf(cell: string): number {
  const match = /^([+-]?[\d,]*\.?\d+(?:[eE][+-]?\d+)?)\s*([a-zA-Zµ%]*)/.exec(cell.trim());
  if (!match) return NaN;
  return Number(match[1].replace(/,/g, "")) * (kUnits[match[2]] ?? 1);
}

/// Names of the columns. A column with a repeated name, or named "paper", is named after the column before it.
export function columnNames(header: string[]): string[] {
  return header.map(
      (name, i) => (i > 0 && (name === "paper" || header.indexOf(name) !== header.lastIndexOf(name)) &&
                    header.indexOf(name) !== i) ||
              name === "paper" ?
          `${name}, ${header[i - 1]}` :
          name);
}

export type PickRow = (record: DataRecord, table: DataTable, row: string[], column: number) => void;

function numeric(table: DataTable, column: number): boolean {
  const cells = table.rows.map((r) => r[column] ?? "").filter((c) => c !== "" && c !== "-");
  return cells.length > 0 && cells.filter((c) => !isNaN(numberOf(c))).length >= 0.7 * cells.length;
}

/// A table that is sorted by a click on a header: downwards, then upwards, then in the original order.
export function sortable(report: Report, record: DataRecord, table: DataTable, pick: PickRow): HTMLElement {
  let column = -1, direction = 1;
  const body = h("tbody");
  const numbers = table.header.map((_, i) => numeric(table, i));
  const heads = table.header.map((name, i) => {
    const button =
        h("button", {
          class: "sort",
          title: "sort by this column",
          onclick: () => {
            if (column !== i)
              column = i, direction = numbers[i] ? -1 : 1;
            else if (direction === (numbers[i] ? -1 : 1))
              direction = -direction;
            else
              column = -1;
            fill();
          }
        },
          name || "\u00a0");
    return h("th", {class: numbers[i] ? "number" : "", scope: "col"}, button);
  });
  const fill = () => {
    heads.forEach(
        (th, i) => th.setAttribute(
            "aria-sort",
            i !== column      ? "none" :
                direction > 0 ? "ascending" :
                                "descending"));
    const rows = [...table.rows];
    if (column >= 0)
      rows.sort((a, b) => {
        const x = a[column] ?? "", y = b[column] ?? "";
        if (!numbers[column]) return direction * x.localeCompare(y, "en", {numeric: true});
        const p = numberOf(x), q = numberOf(y);
        return isNaN(p) ? (isNaN(q) ? 0 : 1) : isNaN(q) ? -1 : direction * (p - q);
      });
    body.replaceChildren(...rows.map(line));
  };
  const line = (row: string[]) => {
    const {name, entry} = sceneOf(report, record, table.title, row);
    const choose = (i: number) => pick(record, table, row, i);
    const tr =
        h("tr", {tabindex: 0, class: entry && !entry.missing ? "has-scene" : "", "data-scene": name},
          ...table.header.map(
              (_, i) => h("td", {class: numbers[i] ? "number" : "", onclick: () => choose(i)}, row[i] ?? "")));
    tr.addEventListener("keydown", (e) => {
      if (e.key === "Enter") choose(0);
    });
    tr.addEventListener("mousemove", (e) => tooltip(provenanceLine(record, name), e.clientX, e.clientY));
    tr.addEventListener("mouseleave", () => tooltip(null));
    return tr;
  };
  fill();
  return h("div", {class: "scroll"}, h("table", {class: "data"}, h("thead", {}, h("tr", {}, ...heads)), body));
}

/// The note of a table, on one line.
export function noteOf(table: DataTable): string {
  return table.note.replace(/\n(?=setting )/g, "; ").replace(/\n(?!$)/g, " ").trim();
}

/// A chart of the columns of a table against its rows, with a box for each column.
export function tableChart(
    report: Report, record: DataRecord, table: DataTable, pick: PickRow, chosen?: string[],
    label = "value"): HTMLElement {
  const names = columnNames(table.header);
  const columns = names.map((_, i) => i).filter((i) => numeric(table, i));
  const texts = names.map((_, i) => i).filter((i) => !columns.includes(i));
  const nameOf = (row: string[]) =>
      (texts.length ? texts.slice(0, 3).map((i) => row[i]) : [row[0]]).filter((c) => c).join(" ");
  const first = columns.find((i) => !/^(elements|motions|threads|first|frames)/.test(names[i])) ?? columns[0];
  const on = new Set(columns.filter((i) => (chosen ? chosen.includes(names[i]) : i === first)));
  let log = true;
  const rows = table.rows.slice(0, 60);
  const place = h("div");
  const draw = () => {
    const series: Series[] =
        columns.filter((i) => on.has(i))
            .map((i) => ({
                   name: names[i],
                   index: [...on].indexOf(i),
                   marks: rows.map((row, r) => ({
                                     x: r,
                                     y: numberOf(row[i] ?? ""),
                                     pick: () => pick(record, table, row, i),
                                     text: `${nameOf(row)}: ${names[i]} ${row[i]}\n${
                                         provenanceLine(record, sceneOf(report, record, table.title, row).name)}`
                                   })),
                 }));
    place.replaceChildren(chart(series, {
      categories: rows.map(nameOf),
      xLabel: texts.length ? table.header[texts[0]] : "row",
      yLabel: on.size === 1 ? names[[...on][0]] : label,
      logY: log,
      zero: !log
    }));
  };
  const boxes = columns.map((i) => check("column", names[i], on.has(i), (shown) => {
                              if (shown)
                                on.add(i);
                              else
                                on.delete(i);
                              draw();
                            }));
  const logarithmic = check("log-y", "logarithmic", log, (chosen) => {
    log = chosen;
    draw();
  });
  draw();
  return h(
      "div", {class: "table-chart"}, h("div", {class: "controls"}, ...boxes, logarithmic), place,
      table.rows.length > rows.length ? h("p", {}, `The first ${rows.length} of ${table.rows.length} rows.`) : null);
}

export function recordSection(report: Report, record: DataRecord, pick: PickRow): HTMLElement {
  return h(
      "div", {class: "record"}, h("h2", {}, record.name), h("p", {}, record.description + "."),
      h("p", {class: "origin"},
        `${record.file}: commit ${record.provenance.commit ?? "unknown"}, ${record.provenance.cpu ?? ""}, ` +
            `load ${record.provenance.load ?? "unknown"}, ${record.provenance.date ?? ""}. Measured by `,
        h("code", {}, record.command), "."),
      ...record.tables.map((table) => {
        const plot = h("div");
        const button =
            h("button", {
              class: "plot",
              "aria-expanded": "false",
              onclick: () => {
                const open = plot.childElementCount > 0;
                plot.replaceChildren(...(open ? [] : [tableChart(report, record, table, pick)]));
                button.textContent = open ? "Plot columns" : "Hide the plot";
                button.setAttribute("aria-expanded", String(!open));
              }
            },
              "Plot columns");
        return h(
            "article", {class: "table-block"}, h("div", {class: "title"}, h("h3", {}, table.title), button),
            sortable(report, record, table, pick),
            h("p", {class: "note"}, noteOf(table)), plot);
      }));
}
