// Loads the script of a scene and decodes it (report/scene_export.hpp has the layout).
import type {SceneEntry, SceneHeader} from "./types";

export class SceneData {
  readonly corners: Uint32Array[] = [];  ///< three columns: vertices of each triangle
  object!: Uint32Array;
  edges!: Uint32Array;
  /// By frame: the triangles that it shows, and positions: all x, all y, all z.
  readonly shown: Uint32Array[] = [];
  readonly frames: Uint16Array[] = [];
  readonly marks: Uint32Array[] = [];  ///< x, y, z, time of contact: numbers of 16 bits
  flags!: Uint32Array;                 ///< 1: edge-edge, 2: between objects, 4: touches at the start
  readonly firstMark: number[] = [0];  ///< by step
  /// Centroids of pairs, two times x, y, z: numbers of header.pair_bits bits. In the order of steps and stages, and
  /// dropped pairs before kept ones.
  readonly pairEnds: Uint32Array[] = [];
  pairKinds!: Uint32Array;             ///< 0: elements, 1: vertex-face test, 2: edge-edge test
  readonly firstPair: number[] = [0];  ///< by step

  constructor(readonly header: SceneHeader, bytes: Uint8Array) {
    const at = {offset: 0};
    const planes = (count: number, width: number): Uint32Array => {
      const values = new Uint32Array(count);
      for (let plane = 0; plane < width; ++plane)
        for (let i = 0; i < count; ++i) values[i] |= bytes[at.offset++] << (8 * plane);
      return values;
    };
    this.readTriangles(planes);
    this.readTopology(planes);
    this.readFrames(bytes, at);
    for (let column = 0; column < 4; ++column) this.marks.push(planes(header.marks, 2));
    this.flags = planes(header.marks, 1);
    this.readPairs(planes);
    header.motions.forEach((motion, k) => {
      this.firstMark.push(this.firstMark[k] + motion.shown);
      this.firstPair.push(motion.pairs.reduce((sum, [dropped, kept]) => sum + dropped + kept, this.firstPair[k]));
    });
  }

  private readPairs(planes: (count: number, width: number) => Uint32Array): void {
    const n = this.header.pairs;
    for (let column = 0; column < 6; ++column) this.pairEnds.push(planes(n, 2));
    for (let axis = 0; axis < 3; ++axis) {
      const from = this.pairEnds[axis], to = this.pairEnds[3 + axis];
      for (let i = 0; i < n; ++i) to[i] = from[i] + unzigzag(to[i]);
    }
    this.pairKinds = planes(n, 1);
  }

  private readTriangles(planes: (count: number, width: number) => Uint32Array): void {
    const n = this.header.triangles;
    for (let column = 0; column < 3; ++column) this.corners.push(planes(n, 4));
    const [a, b, c] = this.corners;
    let before = 0;
    for (let i = 0; i < n; ++i) {
      a[i] = before += unzigzag(a[i]);
      b[i] = a[i] + unzigzag(b[i]);
      c[i] = a[i] + unzigzag(c[i]);
    }
    this.object = planes(n, 2);
    this.edges = planes(n, 1);
  }

  private readTopology(planes: (count: number, width: number) => Uint32Array): void {
    const deltas = planes(this.header.changes, 4);
    let at = 0;
    const list = (count: number) => {
      const values = new Uint32Array(count);
      for (let i = 0, last = 0; i < count; ++i) values[i] = last += deltas[at++];
      return values;
    };
    const visible = new Uint8Array(this.header.triangles);
    for (const frame of this.header.frames) {
      for (const i of list(frame.added)) visible[i] = 1;
      for (const i of list(frame.removed)) visible[i] = 0;
      const same = this.shown.length > 0 && frame.added + frame.removed === 0;
      this.shown.push(same ? this.shown[this.shown.length - 1] : Uint32Array.from(function*() {
        for (let i = 0; i < visible.length; ++i)
          if (visible[i]) yield i;
      }()));
    }
  }

  private readFrames(bytes: Uint8Array, at: {offset: number}): void {
    const n = 3 * this.header.vertices;
    this.header.frames.forEach((frame, f) => {
      const low = at.offset, high = low + n, values = new Uint16Array(n);
      const one = this.frames[f - 1], two = this.frames[f - 2];
      for (let i = 0; i < n; ++i) {
        const difference = unzigzag(bytes[low + i] | (bytes[high + i] << 8));
        const prediction = frame.order === 0 ? (i > 0 ? values[i - 1] : 0) :
            frame.order === 1                ? one[i] :
                                               2 * one[i] - two[i];
        values[i] = prediction + difference;
      }
      at.offset += 2 * n;
      this.frames.push(values);
    });
  }

  /// The centroids of a pair, as fractions of the box.
  pairAt(i: number): [number[], number[]] {
    const end = (columns: Uint32Array[]) => columns.map((column) => column[i] / (2 ** this.header.pair_bits - 1));
    return [end(this.pairEnds.slice(0, 3)), end(this.pairEnds.slice(3))];
  }

  get motions(): number {
    return Math.max(this.frames.length - 1, 0);
  }
  largestFrame(): number {
    return Math.max(...this.shown.map((s) => s.length));
  }
}

function unzigzag(code: number): number {
  return (code >>> 1) ^ -(code & 1);
}

const waiting = new Map<string, (data: string) => void>();
const loaded = new Map<string, Promise<SceneData>>();

window.volccd_scene = (name, data) => waiting.get(name)?.(data);

async function inflate(data: string): Promise<Uint8Array> {
  const text = atob(data), packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) packed[i] = text.charCodeAt(i);
  if (typeof DecompressionStream === "undefined")
    throw new Error("This browser has no DecompressionStream: take Chromium 80, Firefox 113, Safari 16.4 or later.");
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate") as any);
  return new Uint8Array(await new Response(stream as any).arrayBuffer());
}

async function parse(data: string): Promise<SceneData> {
  const bytes = await inflate(data);
  const length = bytes[0] | (bytes[1] << 8) | (bytes[2] << 16) | (bytes[3] << 24);
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length))) as SceneHeader;
  if (header.schema !== 1)
    throw new Error(`The scene has schema ${header.schema}, and this page reads 1: make the report again.`);
  return new SceneData(header, bytes.subarray(4 + length));
}

/// The data of a scene, loaded once. They are in a classic script, because a page from disk may not fetch files.
export function loadScene(entry: SceneEntry): Promise<SceneData> {
  const known = loaded.get(entry.name);
  if (known) return known;
  const promise = new Promise<string>((resolve, reject) => {
                    waiting.set(entry.name, resolve);
                    const script = document.createElement("script");
                    script.src = entry.data!;
                    script.onerror = () => reject(new Error(`${entry.data} cannot be read: is it beside index.html?`));
                    document.head.append(script);
                  }).then(parse);
  loaded.set(entry.name, promise);
  return promise;
}
