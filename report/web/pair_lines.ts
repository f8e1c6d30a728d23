// Pairs of elements or features that a stage dropped or kept, as lines between their centroids.
import * as THREE from "three";
import type {SceneData} from "./scene_data";

const kVertex = `
attribute vec3 from;
attribute vec3 to;
attribute vec3 corner;  // which end (0 or 1), which side (-1 or 1), dropped (1) or kept (0)
uniform vec2 viewport;
uniform float halfWidth;
uniform vec4 planes[3];
varying float across;
varying float along;
varying float dropped;
void main() {
  vec4 a = projectionMatrix * modelViewMatrix * vec4(from, 1.0);
  vec4 b = projectionMatrix * modelViewMatrix * vec4(to, 1.0);
  vec2 d = 0.5 * viewport * (b.xy / b.w - a.xy / a.w);
  float pixels = length(d);
  // The two centroids of a self pair are the same; it is drawn as a square.
  d = pixels > 0.01 ? d / pixels : vec2(1.0, 0.0);
  across = corner.y;
  along = corner.x * pixels / halfWidth;
  dropped = corner.z;
  gl_Position = corner.x < 0.5 ? a : b;
  vec2 offset = halfWidth * (corner.y * vec2(-d.y, d.x) + (2.0 * corner.x - 1.0) * d);
  gl_Position.xy += 2.0 * offset / viewport * gl_Position.w;
  for (int i = 0; i < 3; ++i)
    if (dot(planes[i].xyz, 0.5 * (from + to)) > planes[i].w) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;

const kFragment = `
uniform float opacity;
varying float across;
varying float along;
varying float dropped;
void main() {
  if (dropped > 0.5 && fract(along / 6.0) > 0.62) discard;
  vec3 body = dropped > 0.5 ? vec3(0.835, 0.369, 0.0) : vec3(0.0, 0.42, 0.3);
  gl_FragColor = vec4(abs(across) > 0.6 ? vec3(1.0) : body, opacity);
}`;

export class PairLines {
  readonly meshes: THREE.Mesh[] = [];
  private geometry = new THREE.BufferGeometry();
  private materials: THREE.ShaderMaterial[] = [];
  private ends: Float32Array[] = [];
  private corner = new Float32Array(0);

  constructor(private data: SceneData, planes: THREE.Vector4[]) {
    const max = Math.max(0, ...data.header.motions.flatMap((m) => m.pairs.map(([dropped, kept]) => dropped + kept)));
    this.ends = [0, 1].map(() => new Float32Array(12 * max));
    this.corner = new Float32Array(12 * max);
    const [from, to] = this.ends.map((array) => new THREE.BufferAttribute(array, 3));
    this.geometry.setAttribute("from", from).setAttribute("position", from).setAttribute("to", to);
    this.geometry.setAttribute("corner", new THREE.BufferAttribute(this.corner, 3));
    const index = new Uint32Array(6 * max);
    for (let i = 0; i < max; ++i) index.set([0, 1, 2, 2, 1, 3].map((k) => 4 * i + k), 6 * i);
    this.geometry.setIndex(new THREE.BufferAttribute(index, 1));
    // Drawn twice, as contacts are: pale lines behind surfaces, and full lines in front.
    for (const behind of [true, false]) {
      const material = new THREE.ShaderMaterial({
        vertexShader: kVertex,
        fragmentShader: kFragment,
        transparent: true,
        depthTest: !behind,
        depthWrite: false,
        side: THREE.DoubleSide,
        uniforms: {
          opacity: {value: behind ? 0.3 : 1},
          halfWidth: {value: 2},
          viewport: {value: new THREE.Vector2(1, 1)},
          planes: {value: planes}
        },
      });
      const mesh = new THREE.Mesh(this.geometry, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = behind ? 3 : 4;
      this.materials.push(material);
      this.meshes.push(mesh);
    }
    this.take(0, null);
  }

  /// Where the pairs of a stage in a step begin in the data, and how many are drawn: dropped ones, then kept ones.
  range(motion: number, stage: number|null): {first: number; dropped: number; kept: number} {
    const counts = this.data.header.motions[motion]?.pairs;
    if (stage === null || !counts) return {first: 0, dropped: 0, kept: 0};
    const first = counts.slice(0, stage).reduce((sum, [a, b]) => sum + a + b, this.data.firstPair[motion]);
    return {first, dropped: counts[stage][0], kept: counts[stage][1]};
  }

  /// Shows the pairs of a stage in a step; null: no pairs.
  take(motion: number, stage: number|null): void {
    const {first, dropped, kept} = this.range(motion, stage);
    for (const mesh of this.meshes) mesh.visible = dropped + kept > 0;
    if (dropped + kept === 0) return;
    for (let i = 0; i < dropped + kept; ++i) {
      const ends = this.data.pairAt(first + i);
      for (let corner = 0; corner < 4; ++corner) {
        this.ends.forEach((array, which) => array.set(ends[which], 12 * i + 3 * corner));
        this.corner.set([corner >> 1, corner & 1 ? 1 : -1, i < dropped ? 1 : 0], 12 * i + 3 * corner);
      }
    }
    for (const name of ["from", "to", "corner"]) (this.geometry as any).attributes[name].needsUpdate = true;
    this.geometry.setDrawRange(0, 6 * (dropped + kept));
  }

  /// The size of the picture in pixels, and the number of them for each pixel of the page.
  resize(width: number, height: number, ratio: number): void {
    for (const {uniforms} of this.materials) {
      (uniforms.viewport.value as THREE.Vector2).set(width, height);
      uniforms.halfWidth.value = 2.6 * ratio;
    }
  }

  dispose(): void {
    this.geometry.dispose();
    for (const material of this.materials) material.dispose();
  }
}
