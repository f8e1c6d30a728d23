// The 3-D view of one step of a scene: surface, section planes, contacts, pairs. three.js draws, on WebGL 2.
import * as THREE from "three";

import {PairLines} from "./pair_lines";

import type {SceneData} from "./scene_data";
import {SurfaceMesh} from "./surface_mesh";

/// Positions are those of two frames. Even frames are in one buffer and odd ones in the other, so that only one buffer
/// is filled when the next step begins. `share` is the weight of the odd frame.
const kSurfaceVertex = `
attribute vec3 even;
attribute vec3 odd;
attribute vec4 tint;
uniform float share;
uniform float factor;
varying vec3 place;
varying vec3 eye;
varying vec4 colour;
void main() {
  place = mix(even, odd, share) * factor;
  colour = tint;
  // Approximately linear light, in which shading is computed; the fragment shader applies the square root.
  colour.rgb *= colour.rgb;
  vec4 view = modelViewMatrix * vec4(place, 1.0);
  eye = view.xyz;
  gl_Position = projectionMatrix * view;
  // Alpha: 0 hidden, 0.5 a shell, 1 a solid.
  if (colour.a < 0.25) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;

const kSurfaceFragment = `
#ifdef CUT
uniform vec4 planes[3];
#endif
varying vec3 place;
varying vec3 eye;
varying vec4 colour;
void main() {
#ifdef CUT
  for (int i = 0; i < 3; ++i) if (dot(planes[i].xyz, place) > planes[i].w) discard;
#endif
  vec3 normal = normalize(cross(dFdx(eye), dFdy(eye)));
  if (normal.z < 0.0) normal = -normal;
  float key = max(dot(normal, normalize(vec3(0.35, 0.6, 0.75))), 0.0);
  float fill = max(dot(normal, normalize(vec3(-0.7, -0.1, 0.5))), 0.0);
  vec3 shade = sqrt(min(colour.rgb * (0.22 + 0.72 * key + 0.24 * fill), vec3(1.0)));
#ifdef CUT
  if (!gl_FrontFacing && colour.a > 0.75) {
    vec3 base = sqrt(colour.rgb);
    // The back of a closed surface, seen through a section, is hatched and not shaded.
    float stripe = step(0.72, fract((gl_FragCoord.x + gl_FragCoord.y) / 9.0));
    shade = mix(mix(base, vec3(1.0), 0.45), base * 0.72, stripe * 0.6);
    gl_FragColor = vec4(shade, 1.0);
    return;
  }
#endif
  gl_FragColor = vec4(shade, 1.0);
}`;

const kLineFragment = `
#ifdef CUT
uniform vec4 planes[3];
#endif
uniform float opacity;
varying vec3 place;
void main() {
#ifdef CUT
  for (int i = 0; i < 3; ++i) if (dot(planes[i].xyz, place) > planes[i].w) discard;
#endif
  gl_FragColor = vec4(0.0, 0.0, 0.0, opacity);
}`;

const kMarkVertex = `
attribute vec3 at;
attribute vec2 kind;
uniform float size;
uniform vec4 planes[3];
uniform float show;
varying float inter;
varying float hide;
void main() {
  inter = kind.x;
  hide = 0.0;
  for (int i = 0; i < 3; ++i) if (dot(planes[i].xyz, at) > planes[i].w) hide = 1.0;
  if (show < 1.5 && abs(show - inter) > 0.5) hide = 1.0;
  vec4 view = modelViewMatrix * vec4(at, 1.0);
  view.z += 0.002;
  gl_Position = projectionMatrix * view;
  if (hide > 0.5) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = size;
}`;

const kMarkFragment = `
uniform float opacity;
varying float inter;
void main() {
  vec2 q = abs(gl_PointCoord * 2.0 - 1.0);
  float d = inter > 0.5 ? length(q) : q.x + q.y;
  if (d > 1.0) discard;
  vec3 body = inter > 0.5 ? vec3(0.784, 0.063, 0.18) : vec3(0.094, 0.173, 0.47);
  gl_FragColor = vec4(d > 0.66 ? vec3(1.0) : body, opacity);
}`;

/// Whether software draws, instead of a graphics card. Smooth edges would then take half of the time.
function drawnBySoftware(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  const info = context?.getExtension("WEBGL_debug_renderer_info");
  const name = context && info ? String(context.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export interface Plane {
  on: boolean;
  share: number;  ///< position of the plane along the axis, as a fraction of the box, 0 to 1
  flip: boolean;
}

export class Viewer {
  readonly canvas: HTMLCanvasElement;
  readonly planes: Plane[] = [0, 1, 2].map(() => ({on: false, share: 0.5, flip: false}));
  readonly software = drawnBySoftware();
  lines = true;
  marks = true;
  markKinds = 2;  ///< 0: within an object, 1: between objects, 2: both
  onDraw: () => void = () => {};  ///< called after each picture, for tests
  private renderer: THREE.WebGLRenderer;
  private scene = new THREE.Scene();
  private camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
  private data: SceneData|null = null;
  private geometry: THREE.BufferGeometry|null = null;
  private markGeometry: THREE.BufferGeometry|null = null;
  private lineGeometry: THREE.BufferGeometry|null = null;
  private materials: THREE.ShaderMaterial[] = [];  ///< of the surface and of the lines on it
  private mesh: SurfaceMesh|null = null;
  private lineMesh: THREE.LineSegments|null = null;
  private meanEdge = 0;  ///< as a fraction of the box
  private markMaterials: THREE.ShaderMaterial[] = [];
  private points: THREE.Points[] = [];
  private pairs: PairLines|null = null;
  private stage: number|null = null;                ///< the stage whose pairs are drawn
  private positions: THREE.BufferAttribute[] = [];  ///< of an even and an odd frame
  private held = [-1, -1];                          ///< the numbers of these frames
  private colours!: THREE.BufferAttribute;
  private indices: THREE.BufferAttribute[] = [];  ///< of triangles and of lines
  private indexed: Uint32Array|null = null;       ///< the triangles of `indices`
  private clip = [0, 1, 2].map(() => new THREE.Vector4());
  private gathered = -1;  ///< the step whose contacts and pairs are gathered
  private motion = 0;
  private t = 0;
  private wanted = false;
  private detail = 1;
  private withoutLines = false;
  private axes = [0, 1, 2];  ///< the two horizontal axes, then the upward one
  private azimuth = 0.9;
  private elevation = 0.45;
  private distance = 2.5;
  private radius = 0.8;
  private target = new THREE.Vector3();

  constructor() {
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    const context = this.canvas.getContext("webgl2", {antialias: !this.software});
    if (!context)
      throw new Error("This browser gives no WebGL 2, which the 3-D view needs; tables and figures work without.");
    this.renderer = new THREE.WebGLRenderer({canvas: this.canvas, context});
    this.renderer.setClearColor(0xf6f7f9, 1);
    this.camera.up.set(0, 0, 1);
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
  }

  show(data: SceneData): void {
    this.clear();
    this.data = data;
    this.addSurface();
    this.addMarks();
    this.pairs = new PairLines(data, this.clip);
    this.stage = null;
    this.scene.add(...this.pairs.meshes);
    this.setHiddenObjects(new Set());
    this.fit();
  }

  private addSurface(): void {
    const data = this.data!, {header} = data, mesh = new SurfaceMesh(data), drawn = mesh.vertexOf.length;
    this.mesh = mesh;
    this.meanEdge = mesh.meanEdge(data.frames[0], header.vertices, 1 / (2 ** header.bits - 1));
    // Four numbers for each vertex, of which three are used, for alignment.
    this.positions = [0, 1].map(() => new THREE.BufferAttribute(new Uint16Array(4 * drawn), 4, true));
    this.held = [-1, -1];
    this.colours = new THREE.BufferAttribute(new Uint8Array(4 * drawn), 4, true);
    this.indices = [3 * data.largestFrame(), 2 * mesh.edgeCount].map(
        (capacity) => new THREE.BufferAttribute(new Uint32Array(capacity), 1));
    this.indexed = null;
    const [geometry, lineGeometry] = this.indices.map((index) => {
      const made = new THREE.BufferGeometry();
      // three.js draws nothing if there is no attribute "position".
      made.setAttribute("even", this.positions[0]).setAttribute("position", this.positions[0]);
      made.setAttribute("odd", this.positions[1]);
      made.setAttribute("tint", this.colours).setIndex(index);
      return made;
    });
    const uniforms = {
      share: {value: 0},
      factor: {value: 65535 / (2 ** header.bits - 1)},
      planes: {value: this.clip},
      opacity: {value: 0}
    };
    const material = new THREE.ShaderMaterial({
      vertexShader: kSurfaceVertex,
      fragmentShader: kSurfaceFragment,
      side: THREE.DoubleSide,
      // Lines on the surface are then in front of it.
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
      extensions: {derivatives: true},
      defines: {},
      uniforms,
    });
    const lineMaterial = new THREE.ShaderMaterial({
      vertexShader: kSurfaceVertex,
      fragmentShader: kLineFragment,
      transparent: true,
      depthWrite: false,
      defines: {},
      uniforms,
    });
    const surface = new THREE.Mesh(geometry, material);
    this.lineMesh = new THREE.LineSegments(lineGeometry, lineMaterial);
    surface.frustumCulled = this.lineMesh.frustumCulled = false;
    this.scene.add(surface, this.lineMesh);
    this.geometry = geometry;
    this.lineGeometry = lineGeometry;
    this.materials = [material, lineMaterial];
  }

  private addMarks(): void {
    const max = Math.max(1, ...this.data!.header.motions.map((m) => m.shown));
    this.markGeometry = new THREE.BufferGeometry();
    const at = new THREE.BufferAttribute(new Float32Array(3 * max), 3);
    this.markGeometry.setAttribute("at", at).setAttribute("position", at);
    this.markGeometry.setAttribute("kind", new THREE.BufferAttribute(new Float32Array(2 * max), 2));
    // Drawn twice: pale marks behind surfaces, and full marks in front.
    for (const behind of [true, false]) {
      const material = new THREE.ShaderMaterial({
        vertexShader: kMarkVertex,
        fragmentShader: kMarkFragment,
        transparent: true,
        depthTest: !behind,
        depthWrite: false,
        uniforms: {size: {value: 9}, opacity: {value: behind ? 0.28 : 1}, planes: {value: this.clip}, show: {value: 2}},
      });
      const points = new THREE.Points(this.markGeometry, material);
      points.frustumCulled = false;
      points.renderOrder = behind ? 1 : 2;
      this.markMaterials.push(material);
      this.points.push(points);
      this.scene.add(points);
    }
  }

  private clear(): void {
    for (const geometry of [this.geometry, this.lineGeometry, this.markGeometry]) geometry?.dispose();
    for (const material of this.materials) material.dispose();
    this.pairs?.dispose();
    this.gathered = -1;
    for (const material of this.markMaterials) material.dispose();
    this.markMaterials = [];
    this.points = [];
    this.scene = new THREE.Scene();
  }

  setHiddenObjects(hidden: Set<number>): void {
    const byObject = this.data!.header.objects.map((object, i) => {
      const rgb = parseInt(object.colour.slice(1), 16);
      return [rgb >> 16, (rgb >> 8) & 255, rgb & 255, hidden.has(i) ? 0 : object.solid ? 255 : 128];
    });
    this.mesh!.objectOf.forEach((object, i) => (this.colours.array as Uint8Array).set(byObject[object], 4 * i));
    this.colours.needsUpdate = true;
    this.draw();
  }

  /// The step from frame `motion` to the next one, at t in [0, 1].
  setTime(motion: number, t: number): void {
    this.motion = motion;
    this.t = t;
    this.draw();
  }

  draw(): void {
    if (this.wanted) return;
    this.wanted = true;
    requestAnimationFrame(() => {
      this.wanted = false;
      this.drawNow();
    });
  }

  drawNow(): void {
    if (!this.data || this.canvas.clientWidth === 0) return;
    this.gather();
    this.placePlanes();
    this.placeCamera();
    // Both materials share their uniforms.
    const {uniforms} = this.materials[0];
    uniforms.share.value = this.motion % 2 ? 1 - this.t : this.t;
    const opacity = this.lineOpacity();
    uniforms.opacity.value = opacity;
    this.lineMesh!.visible = this.lines && !this.withoutLines && opacity > 0.01;
    this.compile();
    const ratio = Math.min(devicePixelRatio, 2) * this.detail;
    const count = this.data.header.motions[this.motion]?.shown ?? 0;
    this.markMaterials.forEach((material, i) => {
      this.points[i].visible = this.marks && count > 0;
      material.uniforms.size.value = ratio * (count > 600 ? 7 : 10);
      material.uniforms.show.value = this.markKinds;
    });
    this.pairs!.resize(this.canvas.width, this.canvas.height, ratio);
    this.renderer.render(this.scene, this.camera);
    this.onDraw();
  }

  /// Edges that are only a few pixels long are not drawn, because they would hide the surface.
  private lineOpacity(): number {
    const pixels = (this.meanEdge * this.canvas.clientHeight) / (2 * this.distance * Math.tan(Math.PI * 16 / 180));
    return 0.4 * Math.max(0, Math.min(1, (pixels - 5) / 10));
  }

  /// Without section planes, programs without `discard` are used, because `discard` keeps hidden fragments from being
  /// skipped.
  private compile(): void {
    const cut = this.planes.some((p) => p.on);
    for (const material of this.materials) {
      if (!!material.defines.CUT === cut) continue;
      material.defines = cut ? {CUT: true} : {};
      material.needsUpdate = true;
    }
  }

  /// Uploads the data of the step that are not there yet: positions, triangles, contacts and pairs.
  private gather(): void {
    const data = this.data!;
    for (const frame of [this.motion, Math.min(this.motion + 1, data.frames.length - 1)]) this.upload(frame);
    const shown = data.shown[this.motion];
    if (this.indexed !== shown) {
      this.indexed = shown;
      const [triangles, lines] = this.indices.map((index) => index.array as Uint32Array);
      const written = this.mesh!.fill(shown, triangles, lines);
      for (const index of this.indices) index.needsUpdate = true;
      this.geometry!.setDrawRange(0, 3 * shown.length);
      this.lineGeometry!.setDrawRange(0, written);
    }
    if (this.gathered === this.motion) return;
    this.gathered = this.motion;
    this.gatherMarks();
    this.pairs!.take(this.motion, this.stage);
  }

  private upload(frame: number): void {
    const which = frame % 2;
    if (this.held[which] === frame) return;
    this.held[which] = frame;
    const from = this.data!.frames[frame], n = this.data!.header.vertices, {vertexOf} = this.mesh!;
    const to = this.positions[which].array as Uint16Array;
    for (let i = 0; i < vertexOf.length; ++i) {
      const v = vertexOf[i];
      to[4 * i] = from[v];
      to[4 * i + 1] = from[n + v];
      to[4 * i + 2] = from[2 * n + v];
    }
    this.positions[which].needsUpdate = true;
  }

  /// Draws the pairs of a stage, given as an index into the statistics; null: no pairs.
  showPairs(stage: number|null): void {
    this.stage = stage;
    this.gathered = -1;
    this.draw();
  }

  private gatherMarks(): void {
    const data = this.data!, geometry = this.markGeometry as any;
    const first = data.firstMark[this.motion] ?? 0, count = data.header.motions[this.motion]?.shown ?? 0;
    const at = geometry.attributes.at.array as Float32Array, kind = geometry.attributes.kind.array as Float32Array;
    for (let i = 0; i < count; ++i) {
      for (let axis = 0; axis < 3; ++axis) at[3 * i + axis] = data.marks[axis][first + i] / 65535;
      kind[2 * i] = data.flags[first + i] & 2 ? 1 : 0;
    }
    geometry.attributes.at.needsUpdate = geometry.attributes.kind.needsUpdate = true;
    this.markGeometry!.setDrawRange(0, count);
  }

  private placePlanes(): void {
    const {box} = this.data!.header;
    this.planes.forEach((plane, axis) => {
      if (!plane.on) {
        this.clip[axis].set(0, 0, 0, 1);
        return;
      }
      const normal = [0, 0, 0], sign = plane.flip ? -1 : 1;
      normal[axis] = sign;
      this.clip[axis].set(normal[0], normal[1], normal[2], (sign * plane.share * box.size[axis]) / box.scale);
    });
  }

  /// Moves the camera so that all bodies are visible; fragments far away are ignored.
  fit(): void {
    const data = this.data!, n = data.header.vertices, scale = 1 / (2 ** data.header.bits - 1);
    const low = [1, 1, 1], high = [0, 0, 0];
    for (const f of [0, data.frames.length >> 1, data.frames.length - 1])
      for (let axis = 0; axis < 3; ++axis) {
        const used: number[] = [];
        const shown = data.shown[f], stride = Math.max(1, Math.floor(shown.length / 4000));
        for (let i = 0; i < shown.length; i += stride) used.push(data.frames[f][axis * n + data.corners[0][shown[i]]]);
        used.sort((a, b) => a - b);
        const cut = data.header.objects.some((p) => p.solid) ? 0.01 : 0;
        low[axis] = Math.min(low[axis], used[Math.floor(used.length * cut)] * scale);
        high[axis] = Math.max(high[axis], used[Math.ceil(used.length * (1 - cut)) - 1] * scale);
      }
    this.radius = 0.5 * Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    this.frame(low, high, this.radius);
  }

  /// Moves the camera so that a ball around the middle of a box is visible.
  private frame(low: number[], high: number[], radius: number): void {
    this.target.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
    const aspect = this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1) || 1.5;
    this.distance = (radius / Math.sin(0.28)) * Math.max(1, 1 / aspect) * 0.88;
    this.draw();
  }

  /// Moves the camera so that the drawn contacts of the step are in the middle, with what is around them. Without any,
  /// all bodies are visible.
  private fitContacts(): void {
    const data = this.data!, first = data.firstMark[this.motion] ?? 0;
    const count = data.header.motions[this.motion]?.shown ?? 0;
    if (!count) return;
    const low = [1, 1, 1], high = [0, 0, 0];
    for (let i = first; i < first + count; ++i)
      for (let axis = 0; axis < 3; ++axis) {
        low[axis] = Math.min(low[axis], data.marks[axis][i] / 65535);
        high[axis] = Math.max(high[axis], data.marks[axis][i] / 65535);
      }
    const radius = 0.5 * Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    this.frame(low, high, Math.min(this.radius, Math.max(1.5 * radius, 0.3 * this.radius)));
  }

  /// Looks along an axis, or from the initial direction; "contacts": from there at the contacts of the step.
  look(view: string): void {
    const place = this.axes.indexOf("xyz".indexOf(view));
    const [azimuth, elevation] = [[0, 0], [-Math.PI / 2, 0], [-Math.PI / 2, Math.PI / 2 - 0.001]][place] ?? [0.9, 0.45];
    this.azimuth = azimuth;
    this.elevation = elevation;
    this.fit();
    if (view === "contacts") this.fitContacts();
  }

  /// Sets the upward axis, 0 to 2.
  setUp(axis: number): void {
    this.axes = [(axis + 1) % 3, (axis + 2) % 3, axis];
    this.camera.up = this.turned(0, 0, 1);
    this.fit();
  }

  /// A vector from its components along the two horizontal axes and upwards.
  private turned(a: number, b: number, up: number): THREE.Vector3 {
    const v = [0, 0, 0];
    [a, b, up].forEach((value, i) => (v[this.axes[i]] = value));
    return new THREE.Vector3(v[0], v[1], v[2]);
  }

  orbit(azimuth: number, elevation: number): void {
    this.azimuth += azimuth;
    this.elevation = Math.max(-1.57, Math.min(1.57, this.elevation + elevation));
    this.draw();
  }

  zoom(factor: number): void {
    this.distance *= factor;
    this.draw();
  }

  private pan(x: number, y: number): void {
    const size = (2 * this.distance * Math.tan(0.28)) / this.canvas.clientHeight;
    const right = this.turned(-Math.sin(this.azimuth), Math.cos(this.azimuth), 0);
    const s = Math.sin(this.elevation), c = Math.cos(this.elevation);
    const up = this.turned(-s * Math.cos(this.azimuth), -s * Math.sin(this.azimuth), c);
    this.target.addScaledVector(right, -x * size).addScaledVector(up, y * size);
    this.draw();
  }

  private placeCamera(): void {
    const c = Math.cos(this.elevation);
    const direction = this.turned(c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.elevation));
    this.camera.position.copy(this.target).addScaledVector(direction, this.distance);
    this.camera.lookAt(this.target);
    this.camera.near = Math.max(this.distance - 4, this.distance * 0.01);
    this.camera.far = this.distance + 4;
    this.camera.aspect = this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld(true);
  }

  /// Sets the pixels along a side for each pixel of the page, and whether edges of elements may be drawn. Both are
  /// reduced while a sequence plays on a slow machine.
  setDetail(detail: number, lines = true): void {
    this.withoutLines = !lines;
    if (detail !== this.detail) {
      this.detail = detail;
      this.resize();
    }
    this.draw();
  }

  private resize(): void {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2) * this.detail);
    this.renderer.setSize(width, height, false);
    this.drawNow();
  }

  /// The contact nearest to a position on the canvas, within a few pixels: its index among the shown ones of the
  /// step.
  contactAt(x: number, y: number): number|null {
    const data = this.data;
    if (!data || !this.marks) return null;
    const first = data.firstMark[this.motion] ?? 0, count = data.header.motions[this.motion]?.shown ?? 0;
    let best: number|null = null, min = 9 * 9;
    for (let i = 0; i < count; ++i) {
      const p = [0, 1, 2].map((axis) => data.marks[axis][first + i] / 65535);
      if (this.isCut(p)) continue;
      const inter = (data.flags[first + i] & 2) >> 1;
      if (this.markKinds < 2 && inter !== this.markKinds) continue;
      const v = this.onCanvas(p), dx = v.x - x, dy = v.y - y;
      if (v.z < 1 && dx * dx + dy * dy < min) best = i, min = dx * dx + dy * dy;
    }
    return best;
  }

  /// The drawn pair whose line is nearest to a position on the canvas, within a few pixels: its index among those of
  /// the stage in the step, dropped ones first.
  pairAt(x: number, y: number): number|null {
    const {first, dropped, kept} = this.pairs!.range(this.motion, this.stage);
    let best: number|null = null, min = 5;
    for (let i = 0; i < dropped + kept; ++i) {
      const [a, b] = this.data!.pairAt(first + i);
      if (this.isCut(a.map((value, axis) => (value + b[axis]) / 2))) continue;
      const p = this.onCanvas(a), q = this.onCanvas(b), dx = q.x - p.x, dy = q.y - p.y;
      const along = ((x - p.x) * dx + (y - p.y) * dy) / Math.max(dx * dx + dy * dy, 1e-9);
      const share = Math.max(0, Math.min(1, along));
      const distance = Math.hypot(p.x + share * dx - x, p.y + share * dy - y);
      if (distance < min) best = i, min = distance;
    }
    return best;
  }

  /// The kind and outcome of a pair that pairAt() found.
  pair(i: number): {kind: number; dropped: boolean} {
    const {first, dropped} = this.pairs!.range(this.motion, this.stage);
    return {kind: this.data!.pairKinds[first + i], dropped: i < dropped};
  }

  /// Whether a section plane hides a position, given as fractions of the box.
  private isCut(place: number[]): boolean {
    const {box} = this.data!.header;
    return this.planes.some(
        (plane, axis) =>
            plane.on && (plane.flip ? -1 : 1) * (place[axis] - (plane.share * box.size[axis]) / box.scale) > 0);
  }

  /// The image of a position: pixels of the page from the upper left corner of the canvas, and the depth.
  private onCanvas(place: number[]): {x: number; y: number; z: number} {
    const v = new THREE.Vector3(place[0], place[1], place[2]).project(this.camera);
    return {x: ((v.x + 1) / 2) * this.canvas.clientWidth, y: ((1 - v.y) / 2) * this.canvas.clientHeight, z: v.z};
  }

  private listen(): void {
    let from: {x: number; y: number; pan: boolean}|null = null;
    this.canvas.addEventListener("pointerdown", (e) => {
      from = {x: e.clientX, y: e.clientY, pan: e.button !== 0 || e.shiftKey};
      this.canvas.setPointerCapture(e.pointerId);
    });
    this.canvas.addEventListener("pointermove", (e) => {
      if (!from) return;
      const dx = e.clientX - from.x, dy = e.clientY - from.y;
      if (from.pan)
        this.pan(dx, dy);
      else
        this.orbit(-dx * 0.008, dy * 0.008);
      from = {...from, x: e.clientX, y: e.clientY};
    });
    const end = () => (from = null);
    this.canvas.addEventListener("pointerup", end);
    this.canvas.addEventListener("pointercancel", end);
    this.canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    this.canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.zoom(Math.exp(Math.max(-1, Math.min(1, e.deltaY * 0.0015))));
    }, {passive: false});
  }
}
