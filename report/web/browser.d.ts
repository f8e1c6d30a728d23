// Interfaces of browsers that TypeScript 4.8 does not declare, and the globals that the data scripts set.

interface DecompressionStream {
  readonly readable: ReadableStream<Uint8Array>;
  readonly writable: WritableStream<Uint8Array>;
}
declare const DecompressionStream: {new (format: "deflate"): DecompressionStream};

interface Window {
  volccd_report?: unknown;
  volccd_scene?: (name: string, data: string) => void;
  volccd_test?: unknown;
}
