// The 3-D view of one motion of a scene: surface, section planes, contacts. three.js draws, on WebGL 2.
import * as THREE from "three";
import type {SceneData} from "./scene_data";

const kSurfaceVertex = `
attribute vec4 p0;
attribute vec4 p1;
uniform float t;
uniform float factor;
uniform sampler2D parts;
uniform float partCount;
varying vec3 place;
varying vec3 eye;
varying vec3 distance3;
varying vec4 colour;
void main() {
  place = mix(p0.xyz, p1.xyz, t) * factor;
  float part = floor(p0.w * 65535.0 + 0.5);
  float code = floor(p1.w * 65535.0 + 0.5);
  float corner = mod(code, 4.0);
  float mask = floor(code / 4.0);
  vec3 bary = vec3(corner == 0.0 ? 1.0 : 0.0, corner == 1.0 ? 1.0 : 0.0, corner == 2.0 ? 1.0 : 0.0);
  // Edge i lies opposite to corner i + 2; a diagonal of an element's face gets no line.
  float e0 = mod(mask, 2.0), e1 = mod(floor(mask / 2.0), 2.0), e2 = mod(floor(mask / 4.0), 2.0);
  distance3 = bary + vec3(1.0 - e1, 1.0 - e2, 1.0 - e0) * 2.0;
  colour = texture2D(parts, vec2((part + 0.5) / partCount, 0.5));
  // Linear light, nearly: shading is done in it, and the fragment's square root takes it back.
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
varying vec3 distance3;
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
    // The back of a closed surface, seen through a section: hatched, without shading.
    float stripe = step(0.72, fract((gl_FragCoord.x + gl_FragCoord.y) / 9.0));
    shade = mix(mix(base, vec3(1.0), 0.45), base * 0.72, stripe * 0.6);
    gl_FragColor = vec4(shade, 1.0);
    return;
  }
#endif
#ifdef LINES
  {
    vec3 width = fwidth(distance3);
    vec3 near = smoothstep(vec3(0.0), width * 1.2, distance3);
    float line = 1.0 - min(min(near.x, near.y), near.z);
    float small = smoothstep(0.28, 0.07, max(max(width.x, width.y), width.z));
    shade *= 1.0 - 0.41 * line * small;
  }
#endif
  gl_FragColor = vec4(shade, 1.0);
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

/// Whether a program draws and no graphics card: smooth edges would take half of its time.
function drawnBySoftware(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  const info = context?.getExtension("WEBGL_debug_renderer_info");
  const name = context && info ? String(context.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export interface Plane {
  on: boolean;
  share: number;  ///< of the box along the axis, 0 to 1
  flip: boolean;
}

export class Viewer {
  readonly canvas: HTMLCanvasElement;
  readonly planes: Plane[] = [0, 1, 2].map(() => ({on: false, share: 0.5, flip: false}));
  lines = true;
  marks = true;
  markKinds = 2;  ///< 0: within a part, 1: between parts, 2: both
  onDraw: () => void = () => {};
  private renderer: THREE.WebGLRenderer;
  private scene = new THREE.Scene();
  private camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
  private data: SceneData|null = null;
  private geometry: THREE.BufferGeometry|null = null;
  private markGeometry: THREE.BufferGeometry|null = null;
  private material: THREE.ShaderMaterial|null = null;
  private markMaterials: THREE.ShaderMaterial[] = [];
  private points: THREE.Points[] = [];
  private texture: THREE.DataTexture|null = null;
  private attribute: THREE.BufferAttribute[] = [];
  private clip = [0, 1, 2].map(() => new THREE.Vector4());
  private key = "";
  private motion = 0;
  private t = 0;
  private wanted = false;
  private detail = 1;
  private axes = [0, 1, 2];  ///< two level ones, and the one that points upwards
  private azimuth = 0.9;
  private elevation = 0.45;
  private distance = 2.5;
  private radius = 0.8;
  private target = new THREE.Vector3();

  constructor() {
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    const context = this.canvas.getContext("webgl2", {antialias: !drawnBySoftware(), preserveDrawingBuffer: true});
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
    this.key = "";
    const {header} = data, capacity = 3 * data.largestFrame();
    this.attribute = [0, 1].map(() => new THREE.BufferAttribute(new Uint16Array(4 * capacity), 4, true));
    this.geometry = new THREE.BufferGeometry();
    this.geometry.setAttribute("p0", this.attribute[0]).setAttribute("p1", this.attribute[1]);
    // three.js counts vertices by this one.
    this.geometry.setAttribute("position", this.attribute[0]);
    this.texture = new THREE.DataTexture(
        new Uint8Array(4 * header.parts.length), header.parts.length, 1, THREE.RGBAFormat, THREE.UnsignedByteType);
    this.texture.magFilter = this.texture.minFilter = THREE.NearestFilter;
    this.material = new THREE.ShaderMaterial({
      vertexShader: kSurfaceVertex,
      fragmentShader: kSurfaceFragment,
      side: THREE.DoubleSide,
      extensions: {derivatives: true},
      defines: {},
      uniforms: {
        t: {value: 0},
        factor: {value: 65535 / (2 ** header.bits - 1)},
        parts: {value: this.texture},
        partCount: {value: header.parts.length},
        planes: {value: this.clip}
      },
    });
    const mesh = new THREE.Mesh(this.geometry, this.material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    this.addMarks();
    this.setHiddenParts(new Set());
    this.fit();
  }

  private addMarks(): void {
    const most = Math.max(1, ...this.data!.header.motions.map((m) => m.shown));
    this.markGeometry = new THREE.BufferGeometry();
    const at = new THREE.BufferAttribute(new Float32Array(3 * most), 3);
    this.markGeometry.setAttribute("at", at).setAttribute("position", at);
    this.markGeometry.setAttribute("kind", new THREE.BufferAttribute(new Float32Array(2 * most), 2));
    // Twice: pale where a surface is in front, and as they are.
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
    this.geometry?.dispose();
    this.markGeometry?.dispose();
    this.material?.dispose();
    this.texture?.dispose();
    for (const material of this.markMaterials) material.dispose();
    this.markMaterials = [];
    this.points = [];
    this.scene = new THREE.Scene();
  }

  setHiddenParts(hidden: Set<number>): void {
    const data = this.texture!.image.data;
    this.data!.header.parts.forEach((part, i) => {
      const rgb = parseInt(part.colour.slice(1), 16);
      data.set([rgb >> 16, (rgb >> 8) & 255, rgb & 255, hidden.has(i) ? 0 : part.solid ? 255 : 128], 4 * i);
    });
    this.texture!.needsUpdate = true;
    this.draw();
  }

  /// The motion from frame `motion` to the next one, at t in [0, 1].
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
    if (!this.data || !this.geometry || !this.material || this.canvas.clientWidth === 0) return;
    this.gather();
    this.placePlanes();
    this.material.uniforms.t.value = this.t;
    this.compile();
    const ratio = Math.min(devicePixelRatio, 2) * this.detail;
    const count = this.data.header.motions[this.motion]?.shown ?? 0;
    this.markMaterials.forEach((material, i) => {
      this.points[i].visible = this.marks && count > 0;
      material.uniforms.size.value = ratio * (count > 600 ? 7 : 10);
      material.uniforms.show.value = this.markKinds;
    });
    this.placeCamera();
    this.renderer.render(this.scene, this.camera);
    this.onDraw();
  }

  /// Takes a program without what is not shown: `discard` alone keeps hidden fragments from being skipped.
  private compile(): void {
    const cut = this.planes.some((p) => p.on), {defines} = this.material!;
    if (!!defines.CUT === cut && !!defines.LINES === this.lines) return;
    this.material!.defines = {...(cut && {CUT: true}), ...(this.lines && {LINES: true})};
    this.material!.needsUpdate = true;
  }

  /// Copies positions and contacts of the motion, if another one was drawn last.
  private gather(): void {
    const data = this.data!, next = Math.min(this.motion + 1, data.frames.length - 1);
    if (this.key === `${this.motion}`) return;
    this.key = `${this.motion}`;
    const n = data.header.vertices, shown = data.shown[this.motion];
    [this.motion, next].forEach((frame, which) => {
      const from = data.frames[frame], to = this.attribute[which].array as Uint16Array;
      let o = 0;
      for (let i = 0; i < shown.length; ++i) {
        const triangle = shown[i], mask = data.edges[triangle] << 2, part = data.part[triangle];
        for (let corner = 0; corner < 3; ++corner) {
          const v = data.corners[corner][triangle];
          to[o] = from[v];
          to[o + 1] = from[n + v];
          to[o + 2] = from[2 * n + v];
          to[o + 3] = which === 0 ? part : mask | corner;
          o += 4;
        }
      }
      this.attribute[which].needsUpdate = true;
    });
    this.geometry!.setDrawRange(0, 3 * shown.length);
    this.gatherMarks();
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

  /// Looks at the bodies from where all of them are seen: fragments far away do not count.
  fit(): void {
    const data = this.data!, n = data.header.vertices, scale = 1 / (2 ** data.header.bits - 1);
    const low = [1, 1, 1], high = [0, 0, 0];
    for (const f of [0, data.frames.length >> 1, data.frames.length - 1])
      for (let axis = 0; axis < 3; ++axis) {
        const used: number[] = [];
        const shown = data.shown[f], stride = Math.max(1, Math.floor(shown.length / 4000));
        for (let i = 0; i < shown.length; i += stride) used.push(data.frames[f][axis * n + data.corners[0][shown[i]]]);
        used.sort((a, b) => a - b);
        const cut = data.header.parts.some((p) => p.solid) ? 0.01 : 0;
        low[axis] = Math.min(low[axis], used[Math.floor(used.length * cut)] * scale);
        high[axis] = Math.max(high[axis], used[Math.ceil(used.length * (1 - cut)) - 1] * scale);
      }
    this.target.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
    this.radius = 0.5 * Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    const aspect = this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1) || 1.5;
    this.distance = (this.radius / Math.sin(0.28)) * Math.max(1, 1 / aspect) * 0.88;
    this.draw();
  }

  /// Looks along an axis, or from the corner that a scene begins with.
  look(view: string): void {
    const place = this.axes.indexOf("xyz".indexOf(view));
    const [azimuth, elevation] = [[0, 0], [-Math.PI / 2, 0], [-Math.PI / 2, Math.PI / 2 - 0.001]][place] ?? [0.9, 0.45];
    this.azimuth = azimuth;
    this.elevation = elevation;
    this.fit();
  }

  /// The axis that points upwards: 0 to 2.
  setUp(axis: number): void {
    this.axes = [(axis + 1) % 3, (axis + 2) % 3, axis];
    this.camera.up = this.turned(0, 0, 1);
    this.fit();
  }

  /// A vector given along the two level axes and upwards.
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

  /// Pixels along a side for each pixel of the page: less while it plays on a slow machine.
  setDetail(detail: number): void {
    if (detail === this.detail) return;
    this.detail = detail;
    this.resize();
  }

  private resize(): void {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2) * this.detail);
    this.renderer.setSize(width, height, false);
    this.drawNow();
  }

  /// The contact nearest to a place of the canvas, within some pixels: its index among the shown ones of the motion.
  contactAt(x: number, y: number): number|null {
    const data = this.data;
    if (!data || !this.marks) return null;
    const first = data.firstMark[this.motion] ?? 0, count = data.header.motions[this.motion]?.shown ?? 0;
    let best: number|null = null, least = 9 * 9;
    for (let i = 0; i < count; ++i) {
      const p = [0, 1, 2].map((axis) => data.marks[axis][first + i] / 65535);
      if (this.planes.some(
              (q, axis) => q.on &&
                  (q.flip ? -1 : 1) * (p[axis] - (q.share * data.header.box.size[axis]) / data.header.box.scale) > 0))
        continue;
      const inter = (data.flags[first + i] & 2) >> 1;
      if (this.markKinds < 2 && inter !== this.markKinds) continue;
      const v = new THREE.Vector3(p[0], p[1], p[2]).project(this.camera);
      const dx = ((v.x + 1) / 2) * this.canvas.clientWidth - x, dy = ((1 - v.y) / 2) * this.canvas.clientHeight - y;
      if (v.z < 1 && dx * dx + dy * dy < least) best = i, least = dx * dx + dy * dy;
    }
    return best;
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
