// The surface in the form that the graphics card draws: indexed triangles, and the edges of elements as lines.
import type {SceneData} from "./scene_data";

/// Numbers pairs of whole numbers below 2^26 in the order in which they first occur.
class PairNumbers {
  private numbers = new Map<number, number>();
  readonly first: number[] = [];
  readonly second: number[] = [];

  of(a: number, b: number): number {
    const key = a * 2 ** 26 + b;
    const known = this.numbers.get(key);
    if (known !== undefined) return known;
    const number = this.first.length;
    this.numbers.set(key, number);
    this.first.push(a);
    this.second.push(b);
    return number;
  }
}

/// A drawn vertex belongs to one object, because it has the colour of its object.
export class SurfaceMesh {
  readonly vertexOf: Uint32Array;  ///< by drawn vertex
  readonly objectOf: Uint32Array;
  private corners: Uint32Array[];  ///< drawn vertices of each triangle, three columns
  private edges: Int32Array[];     ///< edges of each triangle, three columns; -1: a diagonal of an element's face
  private ends: Uint32Array[];     ///< drawn vertices of each edge, two columns
  private seen: Uint32Array;       ///< by edge: the last call of fill() that wrote it
  private calls = 0;

  constructor(data: SceneData) {
    const n = data.header.triangles, drawn = new PairNumbers(), edges = new PairNumbers();
    this.corners = data.corners.map((column) => Uint32Array.from(column, (v, i) => drawn.of(v, data.object[i])));
    this.vertexOf = Uint32Array.from(drawn.first);
    this.objectOf = Uint32Array.from(drawn.second);
    this.edges = [0, 1, 2].map(() => new Int32Array(n).fill(-1));
    for (let i = 0; i < n; ++i)
      for (let k = 0; k < 3; ++k) {
        if (!(data.edges[i] & (1 << k))) continue;
        const a = this.corners[k][i], b = this.corners[(k + 1) % 3][i];
        this.edges[k][i] = a < b ? edges.of(a, b) : edges.of(b, a);
      }
    this.ends = [Uint32Array.from(edges.first), Uint32Array.from(edges.second)];
    this.seen = new Uint32Array(edges.first.length);
  }

  /// Number of edges of elements in all frames.
  get edgeCount(): number {
    return this.seen.length;
  }

  /// Writes the drawn vertices of these triangles to `triangles`, and those of the edges of these triangles, each once,
  /// to `lines`. Returns how many numbers were written to `lines`. There must be room for two numbers for each edge,
  /// and for three for each triangle.
  fill(shown: Uint32Array, triangles: Uint32Array, lines: Uint32Array): number {
    const [a, b, c] = this.corners, [from, to] = this.ends;
    ++this.calls;
    let written = 0;
    for (let i = 0; i < shown.length; ++i) {
      const triangle = shown[i];
      triangles[3 * i] = a[triangle];
      triangles[3 * i + 1] = b[triangle];
      triangles[3 * i + 2] = c[triangle];
      for (const column of this.edges) {
        const edge = column[triangle];
        if (edge < 0 || this.seen[edge] === this.calls) continue;
        this.seen[edge] = this.calls;
        lines[written++] = from[edge];
        lines[written++] = to[edge];
      }
    }
    return written;
  }

  /// Mean length of the edges of elements in a frame, as a fraction of the box; 0 without edges. Uses a sample of the
  /// edges.
  meanEdge(positions: Uint16Array, vertices: number, scale: number): number {
    const stride = Math.max(1, Math.floor(this.edgeCount / 2000));
    let sum = 0, count = 0;
    for (let e = 0; e < this.edgeCount; e += stride, ++count) {
      const p = this.vertexOf[this.ends[0][e]], q = this.vertexOf[this.ends[1][e]];
      sum += Math.hypot(...[0, 1, 2].map((axis) => positions[axis * vertices + p] - positions[axis * vertices + q]));
    }
    return count ? (sum * scale) / count : 0;
  }
}
