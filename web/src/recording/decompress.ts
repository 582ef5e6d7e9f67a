/** Chunks of recordings, in plain JavaScript: the page's policy lets no WebAssembly in. */

import { decompress as zstd } from "fzstd";
import { decompress as lz4 } from "lz4js";

const kMostBytes = 512n << 20n;

function checked(name: string, decompress: (data: Uint8Array, size: number) => Uint8Array) {
  return (data: Uint8Array, size: bigint): Uint8Array => {
    if (size > kMostBytes) throw new Error(`a chunk says that it has ${size} bytes: more than ${kMostBytes}`);
    let result: Uint8Array;
    try {
      result = decompress(data, Number(size));
    } catch (error) {
      throw new Error(`a chunk is no ${name}: ${error instanceof Error ? error.message : String(error)}`);
    }
    if (result.length !== Number(size)) throw new Error(`a chunk (${name}) has ${result.length} bytes, not ${size}`);
    return result;
  };
}

export const kDecompress = {
  zstd: checked("Zstandard frame", (data, size) => zstd(data, new Uint8Array(size))),
  lz4: checked("LZ4 frame", (data, size) => lz4(data, size)),
};
