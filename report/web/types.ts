// Contents of data/report.js and of the header of a scene, as report/scene_export.hpp describes them.

export interface Machine {
  version?: string;
  commit?: string;
  compiler?: string;
  build_type?: string;
  flags?: string;
  cpu?: string;
  cores?: number;
  allowed_cores?: number|null;
  isa?: string;
  kernel?: string;
  load?: number|null;
  load_at_end?: number|null;
  date?: string;
}

export interface Provenance extends Machine {
  setting?: string;
  rounds?: number;
  threads?: number;
  inputs?: {scene: string; file: string; fnv1a: string}[];
  scenes?: {[scene: string]: Machine};
}

export interface DataTable {
  title: string;
  note: string;
  header: string[];
  rows: string[][];
}

export interface DataRecord {
  name: string;
  description: string;
  file: string;
  command: string;
  row_count: number;
  provenance: Provenance;
  tables: DataTable[];
  curves: {scene: string; values: {[name: string]: number[]}}[];
}

export interface SceneEntry {
  scene: string;
  name: string;
  file: string;
  records: string[];
  missing?: string;
  picture?: string;  ///< path of a picture of the scene
  data?: string;
  title?: string;
  fnv1a?: string;
  source?: string;
  license?: string;
  steps?: number;
  frames?: number;
  stride?: number;
  triangles?: number;
  elements?: number;
  contacts?: number;
  bytes?: number;
  notes?: string[];
}

export interface Report {
  schema: number;
  folder: string;
  made: Machine;
  records: DataRecord[];
  points: {texts: string[]; columns: {[name: string]: (number | null)[]}}|null;
  scenes: SceneEntry[];
}

export interface StageCount {
  role: string;
  name: string;
  in : number;
  out: number;
  prepare_seconds: number;
  seconds: number;
}

export interface MotionStats {
  element_pairs: number;
  adjacent_pairs: number;
  surviving_pairs: number;
  owned_tests: number;
  orphan_tests: number;
  vf_tests: number;
  ee_tests: number;
  contacts: number;
  contacts_at_start: number;
  undecided: number;
  earliest_toi: number|null;
  seconds: number;
  stages: StageCount[];
}

export interface Motion {
  shown: number;
  inter: number;
  pairs: [number, number][];  ///< numbers of drawn pairs of each stage: dropped, kept
  stats: MotionStats;
}

export interface SceneHeader {
  schema: number;
  name: string;
  file: string;
  fnv1a: string;
  title: string;
  source: string;
  license: string;
  units: string;
  time_unit: string;
  steps: number;
  box: {low: number[]; size: number[]; scale: number};
  bits: number;
  stride: number;
  vertices: number;
  triangles: number;
  changes: number;
  marks: number;
  pairs: number;
  pair_bits: number;
  objects: {id: number; name: string; colour: string; solid: boolean}[];
  frames: {step: number; time: number; cells: number; order: number; added: number; removed: number}[];
  motions: Motion[];
  detection: {pipeline: {name: string; guarantee: string}; shells: string; edges: string; threads: number}|null;
  made: Machine;
  notes: string[];
}
