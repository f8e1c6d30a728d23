// The page of `volccd report` and `volccd view`: overview, tables, figures, scenes.
import {grouped, h, megabytes, tooltip} from "./dom";
import {Figures} from "./figures";
import {describe, provenanceTable, rowsOf, sceneOf} from "./provenance";
import {SceneView} from "./scene_view";
import {recordSection} from "./tables";
import type {DataRecord, DataTable, Report, SceneEntry} from "./types";
import {Viewer} from "./viewer";

class Page {
  private viewer: Viewer|null = null;
  private content = h("main", {id: "content", tabindex: -1});
  private nav = h("nav", {"aria-label": "parts of the report"});
  private drawer = h("aside", {class: "drawer", hidden: true, tabindex: -1, "aria-label": "details of the row"});
  private drawerView = new SceneView(true);
  private sceneView = new SceneView(false);
  private back: HTMLElement|null = null;

  constructor(private report: Report) {
    const single = report.records.length === 0;
    document.title = single ? `${report.scenes[0]?.title || report.scenes[0]?.name} - VolCCD` : "VolCCD report";
    const links: [string, string][] =
        single ? [] : [["overview", "Overview"], ["tables", "Tables"], ["figures", "Figures"]];
    if (report.scenes.length) links.push(["scenes", single ? "Scene" : "Scenes"]);
    this.nav.append(...links.map(([key, text]) => h("a", {href: `#${key}`, "data-key": key}, text)));
    document.body.replaceChildren(
        h("a", {
          class: "skip",
          href: "#content",
          onclick: (e: Event) => {
            e.preventDefault();
            this.content.focus();
          }
        },
          "Skip to the content"),
        h("header", {}, h("h1", {}, "VolCCD", h("small", {}, single ? "sequence" : "report")), this.nav), this.content,
        this.drawer,
        h("footer", {},
          `Made ${report.made.date} by volccd ${report.made.version}, commit ${report.made.commit}, on ${
              report.made.cpu}` +
              (report.folder ? `, from the records in ${report.folder}.` : ".")));
    addEventListener("hashchange", () => this.route());
    addEventListener("keydown", (e) => {
      if (e.key === "Escape") this.closeDrawer();
      if (e.target === document.body && this.sceneView.element.isConnected) this.sceneView.onKey(e);
    });
    this.route();
  }

  private route(): void {
    tooltip(null);
    const [key, ...rest] = decodeURIComponent(location.hash.slice(1)).split("/");
    const name = rest.join("/"), first = this.report.records.length ? "overview" : "scenes";
    const place = ["overview", "tables", "figures", "scenes"].includes(key) ? key : first;
    for (const link of this.nav.querySelectorAll("a")) {
      if (link.dataset.key === place)
        link.setAttribute("aria-current", "page");
      else
        link.removeAttribute("aria-current");
    }
    this.closeDrawer();
    this.sceneView.play(false);
    const parts: {[place: string]: () => Node} = {
      overview: () => this.overview(),
      tables: () => this.tables(name),
      figures: () => this.figures(),
      scenes: () => this.scenes(name)
    };
    this.content.replaceChildren(parts[place]());
    scrollTo(0, 0);
  }

  private overview(): HTMLElement {
    const {records, scenes} = this.report;
    return h(
        "div", {class: "overview"},
        h("h2", {}, "Continuous collision detection between volume meshes: measured results"),
        h("p", {}, "This page shows the records of ", h("code", {}, "volccd experiment run"),
          ": tables, figures, and the scenes that were measured. " +
              "Hover over a number to see where it comes from; click a row to see its scene and the details of its measurement."),
        this.makeFigures().speedups(), h("h3", {}, "Records"),
        h("div", {class: "scroll"},
          h("table", {class: "data records"},
            h("thead", {},
              h("tr", {},
                ...["record", "what it has", "tables", "setting", "commit", "CPU", "load", "date (UTC)"].map(
                    (n) => h("th", {}, n)))),
            h("tbody", {},
              ...records.map(
                  (r) =>
                      h("tr", {}, h("td", {}, h("a", {href: `#tables/${r.name}`}, r.name)),
                        h("td", {class: "wrap"}, r.description), h("td", {class: "number"}, String(r.tables.length)),
                        h("td", {}, r.provenance.setting ?? ""), h("td", {}, h("code", {}, r.provenance.commit ?? "")),
                        h("td", {}, `${r.provenance.cpu ?? ""}, ${r.provenance.cores ?? "?"} cores`),
                        h("td", {class: "number"}, String(r.provenance.load ?? "")),
                        h("td", {}, (r.provenance.date ?? "").replace("T", " ").replace("Z", ""))))))),
        scenes.length ? h("h3", {}, "Scenes") : null, scenes.length ? this.sceneCards() : null, h("h3", {}, "Keys"),
        h("p", {},
          "Tab and Enter reach everything. In a scene: space plays and stops, ← and → go by steps, Home and End to the ends, " +
              "w a s d turn, + and - zoom, f shows all, 1 to 9 show the pairs of a stage and 0 none. Escape closes the details."));
  }

  private sceneCards(): HTMLElement {
    const sorted = [...this.report.scenes].sort(
        (a, b) => Number(!!a.missing) - Number(!!b.missing) || a.scene.localeCompare(b.scene) ||
            (b.elements ?? 0) - (a.elements ?? 0));
    const picture = (s: SceneEntry) =>
        s.picture ? h("img", {src: s.picture, alt: `picture of ${s.scene}`, loading: "lazy"}) : null;
    return h(
        "div", {class: "cards"},
        ...sorted.map(
            (s) => s.missing ? h("div", {class: "card missing"}, picture(s), h("strong", {}, s.scene),
                                 h("p", {}, `${s.file} is not on the machine that made this page.`),
                                 h("p", {}, "To get it: ", h("code", {}, s.missing))) :
                               h("a", {class: "card", href: `#scenes/${s.name}`}, picture(s), h("strong", {}, s.scene),
                                 h("p", {},
                                   `${grouped(s.elements ?? 0)} elements, ${s.frames} frames` +
                                       (s.frames !== s.steps ? ` of ${s.steps}` : "") + `, ${megabytes(s.bytes ?? 0)}`),
                                 h("p", {class: "used"}, s.records.length ? `Measured in ${s.records.join(", ")}` : ""))));
  }

  private tables(name: string): HTMLElement {
    const records = this.report.records, record = records.find((r) => r.name === name) ?? records[0];
    return h(
        "div", {class: "with-list"},
        h("nav", {class: "list", "aria-label": "records"},
          ...records.map(
              (r) => h(
                  "a",
                  {href: `#tables/${r.name}`, "aria-current": r === record ? "page" : undefined, title: r.description},
                  r.name))),
        recordSection(this.report, record, (rec, table, row, column) => this.openRow(rec, table, row, column)));
  }

  private figures(): HTMLElement {
    return this.makeFigures().element();
  }

  private makeFigures(): Figures {
    return new Figures(
        this.report, (record, scene, motion) => this.openScene(record, scene, motion),
        (rec, table, row, column) => this.openRow(rec, table, row, column));
  }

  private scenes(name: string): HTMLElement {
    const shown = this.report.scenes.filter((s) => !s.missing);
    const entry = shown.find((s) => s.name === name) ?? shown.find((s) => s.contacts) ?? shown[0];
    if (!entry) return h("div", {}, h("h2", {}, "Scenes"), this.sceneCards());
    const choose: HTMLSelectElement =
        h("select", {name: "scene", "aria-label": "scene", onchange: () => (location.hash = `scenes/${choose.value}`)},
          ...shown.map((s) => h("option", {value: s.name, selected: s === entry}, describe(s))));
    const missing = this.report.scenes.filter((s) => s.missing), asked = missing.find((s) => s.name === name);
    queueMicrotask(() => this.present(this.sceneView, entry));
    return h(
        "div", {class: "scenes"},
        h("div", {class: "title"}, h("h2", {}, entry.scene),
          shown.length > 1 ? h("label", {}, "Scene ", choose) : null),
        name && entry.name !== name ?
            h("p", {class: "error"},
              asked ? `${asked.file} is not on the machine that made this page.` : `There is no scene ${name} here.`,
              ` This is ${entry.scene}.`) :
            null,
        this.sceneView.element,
        missing.length ? h("details", {}, h("summary", {}, `Missing scenes (${missing.length})`),
                           h("ul", {}, ...missing.map((s) => h("li", {}, `${s.file}: `, h("code", {}, s.missing!))))) :
                         null);
  }

  private async present(view: SceneView, entry: SceneEntry, motion?: number): Promise<void> {
    try {
      this.viewer ??= new Viewer();
    } catch (error) {
      view.status.textContent = (error as Error).message;
      return;
    }
    await view.show(entry, this.viewer);
    if (motion !== undefined || this.report.records.length) {
      view.go(motion ?? view.busiest(), 0);
      this.viewer.look("contacts");
    }
    window.volccd_test = {view, viewer: this.viewer};
  }

  private openRow(record: DataRecord, table: DataTable, row: string[], column: number): void {
    const {name, entry} = sceneOf(this.report, record, table.title, row);
    const cells = table.header.map(
        (head, i) =>
            h("tr", {class: i === column ? "chosen" : ""}, h("th", {scope: "row"}, head || "-"),
              h("td", {}, row[i] ?? "")));
    this.openDrawer(`${record.name}: ${row[0]}`, entry, [
      h("p", {}, table.title), h("table", {class: "provenance"}, h("tbody", {}, ...cells)),
      h("h3", {}, "Where the numbers come from"), provenanceTable(record, name),
      name ? rowsOf(this.report, record, name) : null
    ]);
  }

  private openScene(record: DataRecord, scene: string, motion?: number): void {
    const {entry} = sceneOf(this.report, record, "", [scene]);
    this.openDrawer(
        `${record.name}: ${scene}`, entry,
        [
          h("h3", {}, "Where the numbers come from"), provenanceTable(record, scene), rowsOf(this.report, record, scene)
        ],
        motion);
  }

  private openDrawer(title: string, entry: SceneEntry|undefined, content: (Node|null)[], motion?: number): void {
    tooltip(null);
    if (this.drawer.hidden) this.back = document.activeElement as HTMLElement | null;
    const shown = entry && !entry.missing;
    this.drawer.replaceChildren(
        h("div", {class: "title"}, h("h2", {}, title),
          h("button", {name: "close", onclick: () => this.closeDrawer(), title: "close (Escape)"}, "Close")),
        ...(shown ?
                [
                  h("p", {class: "scene-name"}, describe(entry!), " ",
                    h("a", {href: `#scenes/${entry!.name}`}, "Open in full")),
                  this.drawerView.element
                ] :
                [h("p", {class: "scene-name"},
                   entry ? `The sequence ${entry.file} is not on the machine that made this page. To get it: ${
                               entry.missing}` :
                           "This row belongs to no single scene.")]),
        ...content.filter((c): c is Node => c !== null));
    this.drawer.hidden = false;
    document.body.classList.add("with-drawer");
    this.drawer.focus();
    if (shown) this.present(this.drawerView, entry!, motion);
  }

  private closeDrawer(): void {
    if (this.drawer.hidden) return;
    this.drawerView.play(false);
    this.drawer.hidden = true;
    document.body.classList.remove("with-drawer");
    this.back?.focus();
  }
}

const report = window.volccd_report as Report | undefined;
if (!report)
  document.body.replaceChildren(
      h("p", {class: "error"},
        "data/report.js is missing or cannot be read. Either the folder data was not copied together with index.html, " +
            "or volccd was ended while it replaced the files of this report: then run the same command again."));
else if (report.schema !== 1)
  document.body.replaceChildren(h(
      "p", {class: "error"}, `The report has schema ${report.schema}, and this page reads 1: make the report again.`));
else {
  new Page(report);
  document.body.dataset.ready = "";  // for tests
}
