// Elements, and texts of numbers.

type Child = Node|string|null|undefined|false;
type Attributes = {
  [name: string]: string|number|boolean|((event: any) => void)|undefined
};

function fill(element: Element, attributes: Attributes, children: Child[]): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    if (typeof value === "function")
      element.addEventListener(name.slice(2), value);
    else
      element.setAttribute(name, value === true ? "" : String(value));
  }
  for (const child of children)
    if (child) element.append(child);
}

/// An HTML element; attributes that begin with "on" are listeners.
export function h<K extends keyof HTMLElementTagNameMap>(
    tag: K, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  fill(element, attributes, children);
  return element;
}

export function svg(tag: string, attributes: Attributes = {}, ...children: Child[]): SVGElement {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  fill(element, attributes, children);
  return element;
}

/// A labelled list of values: [value, text].
export function select(
    name: string, values: [string, string][], value: string, changed: (value: string) => void): HTMLElement {
  return h(
      "label", {}, `${name} `,
      h("select", {name, onchange: (e: Event) => changed((e.target as HTMLSelectElement).value)},
        ...values.map(([key, text]) => h("option", {value: key, selected: key === value}, text))));
}

/// A box with its label.
export function check(name: string, label: string, on: boolean, changed: (on: boolean) => void): HTMLElement {
  return h(
      "label", {},
      h("input",
        {type: "checkbox", name, checked: on, onchange: (e: Event) => changed((e.target as HTMLInputElement).checked)}),
      ` ${label}`);
}

export function grouped(value: number): string {
  return Math.round(value).toLocaleString("en-US");
}

/// A number with three significant digits and grouped thousands.
export function short(value: number): string {
  if (!isFinite(value)) return "-";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1000) return grouped(value);
  if (size >= 0.001) return String(Number(value.toPrecision(3)));
  return value.toExponential(2);
}

export function duration(seconds: number): string {
  if (seconds >= 1) return `${short(seconds)}\u00a0s`;
  if (seconds >= 1e-3) return `${short(seconds * 1e3)}\u00a0ms`;
  return `${short(seconds * 1e6)}\u00a0µs`;
}

export function percent(share: number): string {
  return `${Number((100 * share).toPrecision(3))}\u00a0%`;
}

export function megabytes(bytes: number): string {
  return `${(bytes / 1e6).toFixed(1)}\u00a0MB`;
}

let tip: HTMLElement|null = null;

/// Shows text beside the pointer; null hides it.
export function tooltip(text: string|null, x = 0, y = 0): void {
  if (!tip) {
    tip = h("div", {class: "tip", role: "tooltip"});
    document.body.append(tip);
  }
  tip.hidden = text === null;
  if (text === null) return;
  tip.textContent = text;
  const box = tip.getBoundingClientRect();
  tip.style.left = `${Math.max(4, Math.min(x + 14, innerWidth - box.width - 8))}px`;
  tip.style.top = `${y + 18 + box.height > innerHeight ? Math.max(4, y - box.height - 10) : y + 18}px`;
}

/// Colours that colour-blind readers can distinguish (Okabe and Ito 2008; yellow is darkened for white paper).
export const kSeries = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#9a8700", "#e69f00", "#333333"];
export const kDashes = ["", "6 3", "2 3", "8 3 2 3", "12 4", "4 2", "1 2", "10 2 2 2"];
