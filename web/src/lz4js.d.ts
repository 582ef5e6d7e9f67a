// The package has no types of its own.
declare module "lz4js" {
  /** Decompresses one LZ4 frame. Throws on what is no frame. */
  export function decompress(frame: Uint8Array, maxSize?: number): Uint8Array;
}
