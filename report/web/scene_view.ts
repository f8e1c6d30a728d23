// A scene with its controls: the 3-D view, the time slider, the funnel, objects and section planes.
import {check, h, grouped, duration, megabytes, short, svg, tooltip} from "./dom";
import {funnel, largestCount, pairLegend, stageAt} from "./funnel";
import {loadScene, SceneData} from "./scene_data";
import type {SceneEntry} from "./types";
import {Viewer} from "./viewer";

const kFine = 20;  ///< positions of the slider in a step

/// Levels of detail with which a sequence is drawn while it plays, from the highest to the lowest.
const kSimplicities =
    [{detail: 1, lines: true}, {detail: 0.7, lines: false}, {detail: 0.5, lines: false}, {detail: 0.35, lines: false}];

export class SceneView {
  readonly element = h("section", {class: "scene-view"});
  readonly status = h("p", {class: "status", role: "status"});
  private viewer: Viewer|null = null;
  private data: SceneData|null = null;
  private entry: SceneEntry|null = null;
  private motion = 0;
  private t = 0;
  private playing = false;
  private speed = 12;
  private hidden = new Set<number>();
  private max = 1;
  private stage: number|null = null;  ///< whose pairs are shown, as an index into the statistics
  private slider =
      h("input",
        {type: "range", min: 0, value: 0, class: "time", "aria-label": "time", oninput: () => this.fromSlider()});
  private playButton =
      h("button", {class: "play", onclick: () => this.play(!this.playing), title: "play or stop (space)"}, "▶ Play");
  private clock = h("output", {class: "clock"});
  private pace = h("p", {class: "pace", role: "status"});
  private funnelBox = h("div", {class: "funnel-box"});
  private strip = h("div", {class: "strip"});
  private side = h("div", {class: "side"});
  private canvasBox = h("div", {class: "stage"});
  private notes = h("div", {class: "notes"});
  private frames = 0;      ///< number of pictures drawn since playing began
  private runs = 0;        ///< number of times that playing has begun
  private simplicity = 0;  ///< index into kSimplicities
  rate = 0;                ///< pictures a second while it plays

  constructor(readonly compact: boolean) {
    this.element.tabIndex = -1;
    const buttons =
        h("div", {class: "transport"},
          h("button", {onclick: () => this.step(-1), title: "the step before (←)", "aria-label": "previous step"},
            "◀"),
          this.playButton,
          h("button", {onclick: () => this.step(1), title: "the next step (→)", "aria-label": "next step"}, "▶"),
          this.slider, this.clock,
          h("select", {
            class: "speed",
            "aria-label": "steps per second",
            title: "steps per second",
            onchange: (e: Event) => (this.speed = Number((e.target as HTMLSelectElement).value))
          },
            ...[2, 6, 12, 24, 60].map((n) => h("option", {value: n, selected: n === 12}, `${n} / s`))));
    this.element.append(
        this.status,
        h("div", {class: "scene-grid"}, h("div", {class: "main"}, this.canvasBox, this.strip, buttons, this.pace),
          this.side, this.notes));
    this.element.addEventListener("keydown", (e) => this.onKey(e));
  }

  /// Shows a scene on the canvas of the page, of which there is only one.
  async show(entry: SceneEntry, viewer: Viewer): Promise<void> {
    this.viewer = viewer;
    this.entry = entry;
    this.play(false);
    this.data = null;
    this.status.textContent = `Loading ${entry.name} (${megabytes(entry.bytes ?? 0)}) ...`;
    try {
      const data = await loadScene(entry);
      if (this.entry !== entry) return;
      this.data = data;
    } catch (error) {
      this.status.textContent = (error as Error).message;
      return;
    }
    this.canvasBox.replaceChildren(
        viewer.canvas,
        h("p", {class: "hint"},
          "Drag: turn · shift or right drag: move · wheel: zoom · space: play · ← →: steps · 1 to 9: pairs of a stage"));
    viewer.canvas.onmousemove = (e) => this.hover(e);
    viewer.canvas.onmouseleave = () => tooltip(null);
    this.motion = 0;
    this.t = 0;
    this.stage = null;
    this.hidden.clear();
    viewer.planes.forEach((p) => {
      p.on = false;
      p.flip = false;
      p.share = 0.5;
    });
    viewer.marks = true;
    viewer.markKinds = 2;
    viewer.show(this.data);
    viewer.setUp(2);
    this.build();
    this.update();
    this.status.textContent = "";
  }

  private build(): void {
    const {header} = this.data!;
    this.max = largestCount(header.motions.map((m) => m.stats));
    this.slider.max = String(Math.max(this.data!.motions, 0) * kFine);
    this.slider.value = "0";
    this.viewer!.canvas.setAttribute("aria-label", `3-D view of ${header.title || header.name}`);
    this.side.replaceChildren(this.funnelBox, this.display(), this.sections(), this.objects());
    this.strip.replaceChildren(this.timeline());
    const made = header.made;
    this.notes.replaceChildren(
        h("p", {},
          `${header.title || header.name}. ${grouped(header.frames[0].cells)} elements in the first frame, ${
              header.frames.length} ${header.frames.length === 1 ? "frame" : "frames"}, ` +
              `${grouped(this.data!.largestFrame())} triangles of the surface at most.` +
              (header.source ? ` Source: ${header.source}.` : "") +
              (header.license ? ` Licence: ${header.license}.` : "")),
        ...(header.notes.concat(this.entry?.notes?.filter((n) => !header.notes.includes(n)) ?? [])
                .map((note) => h("p", {class: "note"}, note))),
        header.detection ?
            h("p", {},
              `Contacts and counts: pipeline ${header.detection.pipeline.name} (${
                  header.detection.pipeline.guarantee}), ` +
                  `shells as ${header.detection.shells}, ${header.detection.edges} edges, ${header.detection.threads} ${
                      header.detection.threads === 1 ? "thread" : "threads"}; ` +
                  `computed when this page was made, ${made.date}, commit ${made.commit}, ${made.cpu}, load ${
                      made.load}. ` +
                  `Sequence: ${header.file}, hash ${header.fnv1a}.`) :
            this.data!.motions ? h("p", {}, "Contacts were not computed for this page (--no-contacts).") :
                                 "");
  }

  private display(): HTMLElement {
    const viewer = this.viewer!;
    const box = (name: string, label: string, on: boolean, change: (on: boolean) => void) =>
        check(name, label, on, (chosen) => {
          change(chosen);
          viewer.draw();
        });
    return h(
        "fieldset", {class: "display"}, h("legend", {}, "Display"),
        box("lines", "edges of elements", viewer.lines, (on) => (viewer.lines = on)),
        box("marks", "contacts", viewer.marks, (on) => (viewer.marks = on)),
        h("select", {
          name: "kinds",
          "aria-label": "which contacts",
          onchange: (e: Event) => {
            viewer.markKinds = Number((e.target as HTMLSelectElement).value);
            viewer.draw();
          }
        },
          h("option", {value: 2}, "all contacts"), h("option", {value: 1}, "between objects"),
          h("option", {value: 0}, "within an object")),
        h("p", {class: "legend"}, h("span", {class: "key"}, h("i", {class: "disc"}), "between objects"),
          h("span", {class: "key"}, h("i", {class: "diamond"}), "within an object")),
        h("div", {class: "views"}, "View: ",
          ...["default", "contacts", "x", "y", "z"].map(
              (v) =>
                  h("button", {name: `view-${v}`, onclick: () => viewer.look(v)},
                    v.length > 1 ? v : `along ${v}`)),
          h("select", {
            name: "up",
            "aria-label": "axis that points upwards",
            onchange: (e: Event) => viewer.setUp(Number((e.target as HTMLSelectElement).value))
          },
            ...["x", "y", "z"].map((axis, i) => h("option", {value: i, selected: i === 2}, `${axis} upwards`)))));
  }

  private sections(): HTMLElement {
    const viewer = this.viewer!, {box} = this.data!.header;
    return h("fieldset", {class: "sections"}, h("legend", {}, "Section planes"), ...["x", "y", "z"].map((axis, i) => {
      const plane = viewer.planes[i];
      const value = h("output");
      const tell = () => (value.textContent = plane.on ? short(box.low[i] + plane.share * box.size[i]) : "");
      const slider = h("input", {
        type: "range",
        name: `at-${axis}`,
        min: 0,
        max: 1000,
        value: 500,
        disabled: true,
        "aria-label": `place of the plane along ${axis}`,
        oninput: () => {
          plane.share = Number(slider.value) / 1000;
          tell();
          viewer.draw();
        }
      });
      const flip =
          h("button", {
            name: `flip-${axis}`,
            disabled: true,
            title: "show the other side",
            onclick: () => {
              plane.flip = !plane.flip;
              viewer.draw();
            }
          },
            "⇄");
      const on = h("input", {
        type: "checkbox",
        name: `cut-${axis}`,
        onchange: () => {
          plane.on = on.checked;
          slider.disabled = flip.disabled = !on.checked;
          tell();
          viewer.draw();
        }
      });
      return h("div", {class: "plane"}, h("label", {}, on, ` ${axis}`), slider, flip, value);
    }));
  }

  private objects(): HTMLElement {
    const {objects} = this.data!.header;
    const boxes: HTMLInputElement[] = [];
    const all = (on: boolean) => {
      boxes.forEach((box, i) => {
        box.checked = on;
        if (on)
          this.hidden.delete(i);
        else
          this.hidden.add(i);
      });
      this.viewer!.setHiddenObjects(this.hidden);
    };
    return h(
        "fieldset", {class: "objects"}, h("legend", {}, `Objects (${objects.length})`),
        h("div", {class: "views"}, h("button", {name: "all-objects", onclick: () => all(true)}, "all"),
          h("button", {name: "no-objects", onclick: () => all(false)}, "none")),
        h("div", {class: "object-list"}, ...objects.map((object, i) => {
          const box = h("input", {
            type: "checkbox",
            name: `object-${i}`,
            checked: true,
            onchange: () => {
              if (box.checked)
                this.hidden.delete(i);
              else
                this.hidden.add(i);
              this.viewer!.setHiddenObjects(this.hidden);
            }
          });
          boxes.push(box);
          return h("label", {}, box, h("i", {class: "swatch", style: `background:${object.colour}`}), object.name);
        })));
  }

  /// Contacts of all steps, as bars above the slider.
  private timeline(): Element|string {
    const {motions} = this.data!.header;
    if (!motions.length) return "";
    const max = Math.max(1, ...motions.map((m) => m.stats.contacts)), w = 1000 / motions.length;
    const plot = svg("svg", {
      viewBox: "0 0 1000 46",
      preserveAspectRatio: "none",
      class: "timeline",
      role: "img",
      "aria-label": "contacts of each step"
    });
    const cursor = svg("rect", {x: 0, y: 0, width: Math.max(w, 2), height: 46, class: "cursor"});
    plot.append(cursor);
    motions.forEach((m, i) => {
      const inter = (44 * Math.log10(1 + m.inter)) / Math.log10(1 + max),
            all = (44 * Math.log10(1 + m.stats.contacts)) / Math.log10(1 + max);
      plot.append(
          svg("rect", {x: i * w, y: 46 - all, width: w * 0.86, height: all, fill: "#182c78"}),
          svg("rect", {x: i * w, y: 46 - inter, width: w * 0.86, height: inter, fill: "#c8102e"}));
    });
    const at = (e: MouseEvent) => {
      const box = plot.getBoundingClientRect();
      return Math.max(
          0, Math.min(motions.length - 1, Math.floor(((e.clientX - box.left) / box.width) * motions.length)));
    };
    plot.addEventListener("click", (e) => this.go(at(e as MouseEvent), 0));
    plot.addEventListener("mousemove", (e) => {
      const m = motions[at(e as MouseEvent)], step = this.data!.header.frames[at(e as MouseEvent)].step;
      tooltip(
          `Step ${step}: ${grouped(m.stats.contacts)} contacts, ${
              grouped(m.inter)} of them between objects, ` +
              `${grouped(m.stats.vf_tests + m.stats.ee_tests)} elementary tests, ${
                  duration(m.stats.seconds)}. Click to go there.`,
          (e as MouseEvent).clientX, (e as MouseEvent).clientY);
    });
    plot.addEventListener("mouseleave", () => tooltip(null));
    return h(
        "div", {},
        h("small", {},
          `Contacts of each step, logarithmic, at most ${grouped(max)}; red: between objects, blue: within an object`),
        plot);
  }

  /// The motion with most contacts, the first of equal ones; 0 if there are none.
  busiest(): number {
    const contacts = this.data?.header.motions.map((m) => m.stats.contacts) ?? [];
    return Math.max(0, contacts.indexOf(Math.max(...contacts)));
  }

  go(motion: number, t: number): void {
    if (!this.data) return;
    const last = Math.max(this.data.motions - 1, 0);
    this.motion = Math.max(0, Math.min(last, motion));
    this.t = motion > last ? 1 : t;
    this.update();
  }

  step(by: number): void {
    this.play(false);
    this.go(this.motion + by, 0);
  }

  private fromSlider(): void {
    this.play(false);
    const value = Number(this.slider.value), motion = Math.floor(value / kFine);
    this.go(motion, value / kFine - motion);
  }

  private update(): void {
    const {header} = this.data!, frame = header.frames[this.motion], next = header.frames[this.motion + 1];
    this.viewer!.setTime(this.motion, this.t);
    // While a sequence plays, only a few times a second, because drawing the page takes longer than drawing the view.
    const now = performance.now();
    if (this.playing && now - this.updatedAt < 250) return;
    this.updatedAt = now;
    this.slider.value = String(Math.round((this.motion + this.t) * kFine));
    const time = next ? frame.time + this.t * (next.time - frame.time) : frame.time;
    this.clock.textContent = next ? `frames ${frame.step} → ${next.step} of ${header.steps - 1}, at ${
                                        this.t.toFixed(2)} · t = ${Number(time.toPrecision(4))} ${header.time_unit}` :
                                    "one frame";
    const cursor = this.strip.querySelector(".cursor");
    cursor?.setAttribute("x", String((1000 / Math.max(header.motions.length, 1)) * this.motion));
    this.updateFunnel();
  }

  private funnelOf = -1;
  private updatedAt = 0;  ///< when the slider, the texts and the funnel were last updated
  private updateFunnel(): void {
    const {header} = this.data!, motion = header.motions[this.motion];
    const key = this.motion;
    if (this.funnelOf === key && this.funnelBox.dataset.scene === header.name) return;
    this.funnelOf = key;
    this.funnelBox.dataset.scene = header.name;
    if (!motion) {
      this.funnelBox.replaceChildren(
          h("p", {},
            this.data!.motions ? "No contacts were computed for this sequence." :
                                 "A single frame has no step, and no contacts."));
      return;
    }
    const s = motion.stats, step = header.frames[this.motion].step, threads = header.detection?.threads ?? 1;
    this.funnelBox.replaceChildren(
        h("h3", {}, `Step ${step}: ${grouped(s.contacts)} contacts`),
        h("p", {},
          `${grouped(motion.inter)} between objects, ${grouped(s.contacts - motion.inter)} within; ${
              grouped(s.contacts_at_start)} touch at the start. ` +
              (s.earliest_toi === null ? "" : `The earliest is at ${short(s.earliest_toi)} of the step. `) +
              (motion.shown < s.contacts ? `${grouped(motion.shown)} are drawn. ` : "") +
              `Detection took ${duration(s.seconds)}` +
              (threads > 1 ? `; times of stages are summed over ${threads} threads.` : ".")),
        funnel(s, this.max, this.stage, (stage) => this.choose(stage)),
        (this.stage !== null && pairLegend(motion, this.stage)) || "");
  }

  /// Shows the pairs of a stage in this step and in others; null: no pairs.
  private choose(stage: number|null): void {
    const focused = this.funnelBox.contains(document.activeElement);
    this.stage = stage;
    this.funnelOf = -1;
    tooltip(null);
    this.viewer!.showPairs(stage);
    this.updateFunnel();
    if (focused) this.funnelBox.querySelector<HTMLElement>(`[data-stage="${stage}"]`)?.focus();
  }

  private chooseRow(place: number): void {
    const motion = this.data!.header.motions[this.motion];
    if (!motion) return;
    const stage = stageAt(motion.stats, this.stage, place);
    this.choose(stage === this.stage ? null : stage);
  }

  /// Plays at the chosen speed. If drawing takes too long, steps are skipped.
  play(on: boolean): void {
    if (this.playing === on) return;
    this.playing = on;
    this.playButton.textContent = on ? "❚❚ Stop" : "▶ Play";
    if (!on) {
      this.pace.textContent = "";
      this.viewer?.setDetail(1);
      if (this.data) this.update();
      return;
    }
    const run = ++this.runs;
    this.frames = 0;
    this.setSimplicity(this.viewer!.software ? 2 : 0);
    let last = performance.now(), since = last, counted = 0;
    const tick = (now: number) => {
      if (run !== this.runs) return;
      if (!this.playing || !this.data || !this.element.isConnected) {
        this.play(false);
        return;
      }
      ++this.frames;
      if (now - since > 700) {
        this.keepPace((1000 * (this.frames - counted)) / (now - since));
        since = now;
        counted = this.frames;
      }
      const at = this.motion + this.t + (Math.max(0, now - last) / 1000) * this.speed;
      last = now;
      const wrapped = at >= this.data.motions ? 0 : at;
      this.go(Math.floor(wrapped), wrapped - Math.floor(wrapped));
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /// Chooses a lower level of detail if fewer than 20 pictures a second are drawn, and says what is left out.
  private keepPace(rate: number): void {
    this.rate = rate;
    if (rate < 20 && this.simplicity + 1 < kSimplicities.length) this.setSimplicity(this.simplicity + 1);
    const {detail, lines} = kSimplicities[this.simplicity], left: string[] = [];
    if (!lines) left.push("without edges of elements");
    if (detail < 1) left.push(`with ${Math.round(100 * detail)} % of the pixels along each side`);
    if (rate < this.speed) left.push(`with ${short(this.speed / rate)} steps from one picture to the next`);
    this.pace.textContent =
        left.length ? `${Math.round(rate)} pictures a second. While it plays, it is drawn ${left.join(", ")}.` : "";
  }

  private setSimplicity(level: number): void {
    this.simplicity = level;
    this.viewer!.setDetail(kSimplicities[level].detail, kSimplicities[level].lines);
  }

  private hover(e: MouseEvent): void {
    if (e.buttons || !this.data || !this.viewer) return;
    const box = this.viewer.canvas.getBoundingClientRect();
    const x = e.clientX - box.left, y = e.clientY - box.top;
    const contact = this.viewer.contactAt(x, y), pair = contact === null ? this.viewer.pairAt(x, y) : null;
    const text = contact !== null ? this.contactText(contact) : pair !== null ? this.pairText(pair) : null;
    tooltip(text, e.clientX, e.clientY);
  }

  private contactText(i: number): string {
    const data = this.data!, at = data.firstMark[this.motion] + i, flags = data.flags[at];
    return `${flags & 1 ? "Edge-edge" : "Vertex-triangle"} contact ${flags & 2 ? "between objects" : "within an object"}, ` +
        (flags & 4 ? "touching at the start." : `at ${(data.marks[3][at] / 65535).toFixed(4)} of the step.`);
  }

  private pairText(i: number): string {
    const {kind, dropped} = this.viewer!.pair(i);
    const {role, name} = this.data!.header.motions[this.motion].stats.stages[this.stage!];
    const what = ["Element pair", "Vertex-triangle test", "Edge-edge test"][kind];
    return `${what}, ${dropped ? "dropped by" : "kept by or from"} ${name} (${role}).`;
  }

  /// Keys of the view, also if nothing has the focus.
  onKey(e: KeyboardEvent): void {
    const target = e.target as HTMLElement;
    if (!this.data || (target instanceof HTMLInputElement && target.type !== "checkbox") ||
        target instanceof HTMLSelectElement)
      return;
    const turn: {[key: string]: () => void} = {
      " ": () => this.play(!this.playing),
      ArrowLeft: () => this.step(-1),
      ArrowRight: () => this.step(1),
      Home: () => this.go(0, 0),
      End: () => this.go(this.data!.motions, 0),
      "+": () => this.viewer!.zoom(0.85),
      "-": () => this.viewer!.zoom(1 / 0.85),
      f: () => this.viewer!.fit(),
      a: () => this.viewer!.orbit(-0.15, 0),
      d: () => this.viewer!.orbit(0.15, 0),
      w: () => this.viewer!.orbit(0, 0.15),
      s: () => this.viewer!.orbit(0, -0.15),
      "0": () => this.choose(null),
    };
    for (let place = 0; place < 9; ++place) turn[String(place + 1)] = () => this.chooseRow(place);
    if (e.key === " " && (target instanceof HTMLButtonElement || target instanceof HTMLInputElement)) return;
    const act = turn[e.key];
    if (!act || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    act();
  }
}
