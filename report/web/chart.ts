// Charts as SVG: points and lines over a number or over categories, and stacked bars. Linear or logarithmic axes.
import {h, kDashes, kSeries, short, svg, tooltip} from "./dom";

export interface Mark {
  x: number;  ///< a number, or the index of a category
  y: number;
  low?: number;  ///< ends of a whisker
  high?: number;
  text: string;
  pick?: () => void;
}

export interface Series {
  name: string;
  marks: Mark[];
  index?: number;  ///< for colour and shape; by default the position in the list
  line?: boolean;
}

export interface ChartOptions {
  xLabel: string;
  yLabel: string;
  categories?: string[];
  logX?: boolean;
  logY?: boolean;
  height?: number;
  width?: number;
  zero?: boolean;  ///< a linear axis begins at 0
  legend?: boolean;
}

interface Scale {
  (value: number): number;
  ticks: number[];
}

function niceTicks(low: number, high: number, count: number): number[] {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= raw) ?? raw;
  const ticks: number[] = [];
  for (let t = Math.ceil(low / step) * step; t <= high + step * 1e-9; t += step)
    ticks.push(Math.abs(t) < step * 1e-9 ? 0 : t);
  return ticks;
}

function makeScale(values: number[], from: number, to: number, log: boolean, zero: boolean, count: number): Scale {
  const good = values.filter((v) => isFinite(v) && (!log || v > 0));
  let low = Math.min(...good), high = Math.max(...good);
  if (!good.length) low = log ? 0.1 : 0, high = 1;
  if (log) {
    const pad = Math.max((Math.log10(high) - Math.log10(low)) * 0.05, 0.1);
    const a = Math.log10(low) - pad, b = Math.log10(high) + pad;
    const scale = ((v: number) => from + ((Math.log10(v) - a) / (b - a)) * (to - from)) as Scale;
    const ticks: number[] = [];
    const decades = b - a;
    const factors = decades < 3.5 ? [1, 2, 5] : [1];
    const every = Math.max(1, Math.ceil(decades / 8));
    for (let e = Math.floor(a); e <= Math.ceil(b); e += every)
      for (const f of factors) {
        const t = f * 10 ** e;
        if (Math.log10(t) >= a && Math.log10(t) <= b) ticks.push(t);
      }
    scale.ticks = ticks;
    return scale;
  }
  if (zero) low = Math.min(low, 0), high = Math.max(high, 0);
  if (low === high) low -= 0.5, high += 0.5;
  const pad = (high - low) * 0.04;
  const a = zero && low === 0 ? 0 : low - pad, b = high + pad;
  const scale = ((v: number) => from + ((v - a) / (b - a)) * (to - from)) as Scale;
  scale.ticks = niceTicks(a, b, count);
  return scale;
}

/// Marks of different shapes, so that series can be distinguished without colours.
function symbol(shape: number, x: number, y: number, r: number, colour: string): SVGElement {
  const path = [
    `M${x - r},${y}a${r},${r} 0 1,0 ${2 * r},0a${r},${r} 0 1,0 ${- 2 * r},0`,
    `M${x - r},${y - r}h${2 * r}v${2 * r}h${- 2 * r}z`,
    `M${x},${y - 1.3 * r}l${1.2 * r},${2.2 * r}h${- 2.4 * r}z`,
    `M${x},${y - 1.4 * r}l${1.4 * r},${1.4 * r}l${- 1.4 * r},${1.4 * r}l${- 1.4 * r},${- 1.4 * r}z`,
    `M${x},${y + 1.3 * r}l${1.2 * r},${- 2.2 * r}h${- 2.4 * r}z`,
  ][shape % 5];
  const hollow = Math.floor(shape / 5) % 2 === 1;
  return svg("path", {d: path, fill: hollow ? "#fff" : colour, stroke: colour, "stroke-width": 1.5});
}

function tickText(value: number): string {
  const size = Math.abs(value);
  if (size >= 1e6) return `${Number((value / 1e6).toPrecision(3)).toLocaleString("en-US")} M`;
  if (size >= 1e4) return `${Number((value / 1e3).toPrecision(3))} K`;
  if (size > 0 && size < 1e-3) return value.toExponential(0);
  return short(value);
}

function legend(names: string[], indices: number[], lines: boolean): HTMLElement {
  return h("div", {class: "legend"}, ...names.map((name, i) => {
    const colour = kSeries[indices[i] % kSeries.length];
    const swatch =
        svg("svg", {width: 26, height: 14, "aria-hidden": "true"},
            lines ? svg("line", {
              x1: 0,
              x2: 26,
              y1: 7,
              y2: 7,
              stroke: colour,
              "stroke-width": 2,
              "stroke-dasharray": kDashes[indices[i] % kDashes.length]
            }) :
                    null,
            symbol(indices[i], 13, 7, 4, colour));
    return h("span", {class: "key"}, swatch, name);
  }));
}

function interactive(element: SVGElement, mark: Mark): void {
  const show = (event: MouseEvent|FocusEvent) => {
    const box = element.getBoundingClientRect();
    tooltip(mark.text, "clientX" in event ? event.clientX : box.right, "clientY" in event ? event.clientY : box.top);
  };
  element.addEventListener("mousemove", show as EventListener);
  element.addEventListener("focus", show as EventListener);
  element.addEventListener("mouseleave", () => tooltip(null));
  element.addEventListener("blur", () => tooltip(null));
  element.setAttribute("tabindex", "0");
  element.setAttribute("role", "img");
  element.setAttribute("aria-label", mark.text);
  if (!mark.pick) return;
  element.setAttribute("class", "pick");
  element.addEventListener("click", mark.pick);
  element.addEventListener("keydown", ((e: KeyboardEvent) => {
                                        if (e.key === "Enter") mark.pick!();
                                      }) as EventListener);
}

/// The axes and the area of a chart.
interface Frame {
  plot: SVGElement;
  x: Scale;
  y: Scale;
  left: number;
  right: number;
  top: number;
  bottom: number;
  slanted: boolean;
}

function makeFrame(series: Series[], options: ChartOptions): Frame {
  const categories = options.categories;
  const slanted = categories !== undefined && categories.some((c) => c.length > 12) && categories.length > 5;
  const width = options.width ?? 740, height = options.height ?? 360;
  const left = slanted && categories!.length > 20 ? 130 : 74, right = width - 16, top = 12,
        bottom = height - (slanted ? 118 : 52);
  const plot = svg("svg", {
    viewBox: `0 0 ${width} ${height}`,
    class: "chart",
    role: "group",
    "aria-label": `${options.yLabel} against ${options.xLabel}`
  });
  const marks = series.flatMap((s) => s.marks);
  const ys = marks.flatMap((m) => [m.y, m.low ?? m.y, m.high ?? m.y]);
  const y = makeScale(ys, bottom, top, !!options.logY, options.zero ?? true, 6);
  const x = categories ? (Object.assign(
                              (v: number) => left + ((v + 0.5) / categories.length) * (right - left),
                              {ticks: categories.map((_, i) => i)}) as Scale) :
                         makeScale(marks.map((m) => m.x), left, right, !!options.logX, false, 9);
  return {plot, x, y, left, right, top, bottom, slanted};
}

function drawAxes(frame: Frame, options: ChartOptions): void {
  const {plot, x, y, left, right, top, bottom, slanted} = frame, categories = options.categories;
  for (const t of y.ticks) {
    plot.append(
        svg("line", {x1: left, x2: right, y1: y(t), y2: y(t), class: "grid"}),
        svg("text", {x: left - 8, y: y(t) + 4, class: "tick end"}, tickText(t)));
  }
  // If there is not enough room, some names are left out; the marks show all of them.
  const every = categories ? Math.ceil(categories.length / 30) : 1;
  for (const t of x.ticks) {
    const name = categories ? categories[t] : tickText(t);
    if (categories && t % every !== 0) continue;
    const label = name.length > 26 ? `${name.slice(0, 25)}…` : name;
    if (!categories) plot.append(svg("line", {x1: x(t), x2: x(t), y1: top, y2: bottom, class: "grid"}));
    plot.append(
        slanted ?
            svg("text", {x: x(t), y: bottom + 14, class: "tick end", transform: `rotate(-32 ${x(t)} ${bottom + 14})`},
                label) :
            svg("text", {x: x(t), y: bottom + 18, class: "tick middle"}, label));
  }
  plot.append(
      svg("path", {d: `M${left},${top}V${bottom}H${right}`, class: "axis"}),
      svg("text", {x: (left + right) / 2, y: bottom + (slanted ? 110 : 44), class: "label middle"}, options.xLabel),
      svg("text",
          {x: 16, y: (top + bottom) / 2, class: "label middle", transform: `rotate(-90 16 ${(top + bottom) / 2})`},
          options.yLabel));
}

/// The line of a series. It ends at a value that cannot be shown (0 on a logarithmic axis), and begins again after it.
function linePath(frame: Frame, s: Series, good: Mark[]): string {
  let path = "", joined = false;
  for (const m of s.line ? s.marks : []) {
    const shown = good.includes(m);
    if (shown) path += `${joined ? "L" : "M"}${frame.x(m.x).toFixed(1)},${frame.y(m.y).toFixed(1)}`;
    joined = shown;
  }
  return path;
}

/// Series `place` of `count`. Series at the same category are drawn side by side.
function drawSeries(frame: Frame, s: Series, place: number, count: number, options: ChartOptions): void {
  const {plot, x, y} = frame, categories = options.categories;
  const index = s.index ?? place, colour = kSeries[index % kSeries.length];
  const room = categories ? Math.min((0.7 * (frame.right - frame.left)) / categories.length, 22 * count) : 0;
  const offset = categories && !s.line ? ((place + 0.5) / count - 0.5) * room : 0;
  const good =
      s.marks.filter((m) => isFinite(m.y) && (!options.logY || m.y > 0) && (categories || !options.logX || m.x > 0));
  const path = linePath(frame, s, good);
  if (path)
    plot.append(svg("path", {
      d: path,
      fill: "none",
      stroke: colour,
      "stroke-width": 1.8,
      "stroke-dasharray": kDashes[index % kDashes.length]
    }));
  const crowded = s.line && good.length > 40;
  for (const mark of good) {
    const px = x(mark.x) + offset, py = y(mark.y), group = svg("g");
    if (mark.low !== undefined && mark.high !== undefined && mark.high > mark.low && (!options.logY || mark.low > 0))
      group.append(svg("path", {
        d: `M${px},${y(mark.low)}V${y(mark.high)}M${px - 3},${y(mark.low)}h6M${px - 3},${y(mark.high)}h6`,
        stroke: colour,
        fill: "none",
        "stroke-width": 1.2
      }));
    group.append(
        symbol(index, px, py, crowded ? 2 : 4.5, colour), svg("circle", {cx: px, cy: py, r: 8, fill: "transparent"}));
    interactive(group, mark);
    plot.append(group);
  }
}

/// A chart of points. Lines join the marks of a series if the series asks for them.
export function chart(series: Series[], options: ChartOptions): HTMLElement {
  const frame = makeFrame(series, options), {plot} = frame;
  drawAxes(frame, options);
  series.forEach((s, place) => drawSeries(frame, s, place, series.length, options));
  const empty = series.every((s) => s.marks.length === 0) ?
      h("p", {class: "empty"}, "Nothing is chosen, or the records have no such rows.") :
      null;
  return h(
      "figure", {},
      options.legend === false ?
          null :
          legend(series.map((s) => s.name), series.map((s, i) => s.index ?? i), series.some((s) => s.line)),
      plot, empty);
}

export interface Bar {
  name: string;
  parts: {name: string; value: number; text: string}[];
  text: string;
  pick?: () => void;
}

/// Horizontal stacked bars. All bars name their parts in the same order.
export function bars(list: Bar[], label: string, width = 740): HTMLElement {
  const left = 190, right = 80, row = 30, height = list.length * row + 44;
  const max = Math.max(...list.map((b) => b.parts.reduce((sum, p) => sum + p.value, 0)), 1e-300);
  const x = makeScale([0, max], left, width - right, false, true, 6);
  const plot = svg("svg", {viewBox: `0 0 ${width} ${height}`, class: "chart", role: "group", "aria-label": label});
  for (const t of x.ticks)
    plot.append(
        svg("line", {x1: x(t), x2: x(t), y1: 6, y2: height - 38, class: "grid"}),
        svg("text", {x: x(t), y: height - 22, class: "tick middle"}, tickText(t)));
  plot.append(svg("text", {x: (left + width - right) / 2, y: height - 4, class: "label middle"}, label));
  list.forEach((bar, i) => {
    const y = 8 + i * row;
    plot.append(svg("text", {x: left - 8, y: y + 15, class: "tick end"}, bar.name));
    let sum = 0;
    bar.parts.forEach((part, k) => {
      const a = x(sum), b = x(sum + Math.max(part.value, 0));
      sum += Math.max(part.value, 0);
      const box = svg("rect", {
        x: a,
        y,
        width: Math.max(b - a, 0),
        height: row - 9,
        fill: kSeries[k % kSeries.length],
        stroke: "#fff",
        "stroke-width": b - a > 2 ? 1 : 0
      });
      interactive(box, {x: 0, y: 0, text: part.text, pick: bar.pick});
      plot.append(box);
    });
    plot.append(svg("text", {x: x(sum) + 6, y: y + 15, class: "tick"}, bar.text));
  });
  const names = list[0]?.parts.map((p) => p.name) ?? [];
  const keys =
      h("div", {class: "legend"},
        ...names.map(
            (name, k) =>
                h("span", {class: "key"}, h("i", {class: "swatch", style: `background:${kSeries[k % kSeries.length]}`}),
                  name)));
  return h(
      "figure", {}, keys, plot,
      list.length ? null : h("p", {class: "empty"}, "Nothing is chosen, or the records have no such rows."));
}
