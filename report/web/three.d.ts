// The part of three.js that the viewer uses (release 111, as Debian packages it, and later ones).
declare module "three" {
  export const UnsignedByteType: number;
  export const RGBAFormat: number;
  export const NearestFilter: number;
  export const DoubleSide: number;

  export class Vector3 {
    x: number;
    y: number;
    z: number;
    constructor(x?: number, y?: number, z?: number);
    set(x: number, y: number, z: number): this;
    copy(v: Vector3): this;
    clone(): Vector3;
    addScaledVector(v: Vector3, s: number): this;
    project(camera: PerspectiveCamera): this;
    length(): number;
  }
  export class Vector2 {
    constructor(x?: number, y?: number);
    set(x: number, y: number): this;
  }
  export class Vector4 {
    constructor(x?: number, y?: number, z?: number, w?: number);
    set(x: number, y: number, z: number, w: number): this;
  }
  export class Object3D {
    position: Vector3;
    up: Vector3;
    visible: boolean;
    frustumCulled: boolean;
    renderOrder: number;
    add(...objects: Object3D[]): this;
    lookAt(v: Vector3): void;
    updateMatrixWorld(force?: boolean): void;
  }
  export class Scene extends Object3D {}
  export class PerspectiveCamera extends Object3D {
    aspect: number;
    near: number;
    far: number;
    constructor(fov: number, aspect: number, near: number, far: number);
    updateProjectionMatrix(): void;
  }
  export class BufferAttribute {
    array: ArrayBufferView;
    needsUpdate: boolean;
    constructor(array: Uint8Array|Uint16Array|Uint32Array|Float32Array, itemSize: number, normalized?: boolean);
  }
  export class BufferGeometry {
    setAttribute(name: string, attribute: BufferAttribute): this;
    setIndex(index: BufferAttribute): void;
    setDrawRange(start: number, count: number): void;
    dispose(): void;
  }
  export class DataTexture {
    image: {data: Uint8Array};
    needsUpdate: boolean;
    magFilter: number;
    minFilter: number;
    constructor(data: Uint8Array, width: number, height: number, format: number, type: number);
    dispose(): void;
  }
  export interface Uniform {
    value: unknown;
  }
  export class ShaderMaterial {
    uniforms: {[name: string]: Uniform};
    defines: {[name: string]: boolean};
    needsUpdate: boolean;
    constructor(options: {[name: string]: unknown});
    dispose(): void;
  }
  export class Mesh extends Object3D {
    constructor(geometry: BufferGeometry, material: ShaderMaterial);
  }
  export class LineSegments extends Object3D {
    constructor(geometry: BufferGeometry, material: ShaderMaterial);
  }
  export class Points extends Object3D {
    constructor(geometry: BufferGeometry, material: ShaderMaterial);
  }
  export class WebGLRenderer {
    domElement: HTMLCanvasElement;
    constructor(options: {[name: string]: unknown});
    setPixelRatio(ratio: number): void;
    setSize(width: number, height: number, style?: boolean): void;
    setClearColor(colour: number, alpha: number): void;
    render(scene: Scene, camera: PerspectiveCamera): void;
  }
}
