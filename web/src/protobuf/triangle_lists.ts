/**
 * The vertices of foxglove.TriangleListPrimitive, taken out of a foxglove.SceneUpdate before it is decoded: as
 * messages of their own they are a hundred thousand objects a model, which cost a fifth of a second; as arrays a
 * hundredth of one. Field numbers are those of the published schemas.
 */

export interface TriangleList {
  positions: Float32Array; // vertices x 3
  colors: Uint8Array; // colours x 4; none, or one a vertex
  indices: Uint32Array;
}

export interface Split {
  /** The message without the vertices, colours and indices of its triangle lists. */
  rest: Uint8Array;
  /** By entity, then by triangle list. */
  lists: TriangleList[][];
}

const kEntities = 2; // of SceneUpdate
const kTriangles = 12; // of SceneEntity
const [kPoints, kColors, kIndices] = [2, 4, 5]; // of TriangleListPrimitive
const [kVarint, kFixed64, kDelimited, kFixed32] = [0, 1, 2, 5]; // wire types

/** Walks the fields of the message in data[at, end). */
class Walker {
  number = 0;
  wire = 0;
  tag = 0; // where the field begins
  begin = 0; // its content; at a varint where it begins
  readonly view: DataView;

  constructor(
    readonly data: Uint8Array,
    public at = 0,
    readonly end = data.length,
  ) {
    this.view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  }

  /** The next field, and behind it; false: there is none. Throws an Error in words where the bytes are no message. */
  next(): boolean {
    if (this.at >= this.end) return false;
    this.tag = this.at;
    const key = this.#varint();
    this.number = key >>> 3;
    this.wire = key & 7;
    let length = 0;
    this.begin = this.at;
    if (this.wire === kDelimited) {
      length = this.#varint();
      this.begin = this.at;
    } else if (this.wire === kFixed64) length = 8;
    else if (this.wire === kFixed32) length = 4;
    else if (this.wire === kVarint) this.#varint();
    else throw new Error(`a field of wire type ${this.wire} in a scene`);
    this.at += length;
    if (this.at > this.end) throw new Error("a scene that is cut off");
    return true;
  }

  within(): Walker {
    return new Walker(this.data, this.begin, this.at);
  }

  /** Of 64 bits only the lower 32 are kept: lengths and keys have no more. */
  #varint(): number {
    let value = 0;
    for (let shift = 0; shift < 70; shift += 7) {
      if (this.at >= this.end) throw new Error("a scene that is cut off");
      const byte = this.data[this.at++]!;
      if (shift < 32) value |= (byte & 0x7f) << shift;
      if (byte < 0x80) return value >>> 0;
    }
    throw new Error("a number of more than ten bytes in a scene");
  }
}

/** Throws an Error in words where the bytes are no foxglove.SceneUpdate. */
export function splitTriangles(data: Uint8Array): Split {
  const lists: TriangleList[][] = [];
  const rest = replaced(data, new Walker(data), kEntities, (entity) => {
    const own: TriangleList[] = [];
    lists.push(own);
    return replaced(data, entity, kTriangles, (list) => {
      const [taken, remaining] = takeList(data, list);
      own.push(taken);
      return remaining;
    });
  });
  return { rest: joined(rest), lists };
}

/** The message with other bytes for its fields of this number. */
function replaced(
  data: Uint8Array,
  message: Walker,
  number: number,
  change: (field: Walker) => Uint8Array[],
): Uint8Array[] {
  const parts: Uint8Array[] = [];
  while (message.next()) {
    if (message.number !== number || message.wire !== kDelimited) {
      parts.push(data.subarray(message.tag, message.at));
      continue;
    }
    const content = change(message.within());
    const length = content.reduce((sum, part) => sum + part.length, 0);
    parts.push(Uint8Array.from([...varint((number << 3) | kDelimited), ...varint(length)]), ...content);
  }
  return parts;
}

function takeList(data: Uint8Array, list: Walker): [TriangleList, Uint8Array[]] {
  const rest: Uint8Array[] = [];
  const begin = list.at;
  let [points, colored, indexed] = [0, 0, 0];
  while (list.next()) {
    if (list.number === kPoints) points++;
    else if (list.number === kColors) colored++;
    else if (list.number === kIndices) indexed += (list.at - list.begin) >> 2;
    else rest.push(data.subarray(list.tag, list.at));
  }
  const taken = {
    positions: new Float32Array(3 * points),
    colors: new Uint8Array(4 * colored),
    indices: new Uint32Array(indexed),
  };
  const again = new Walker(data, begin, list.end);
  let [point, color, index] = [0, 0, 0];
  while (again.next()) {
    if (again.number === kPoints) {
      doubles(again, (c, value) => c < 3 && (taken.positions[point + c] = value));
      point += 3;
    } else if (again.number === kColors) {
      doubles(
        again,
        (c, value) => c < 4 && (taken.colors[color + c] = Math.round(255 * Math.min(1, Math.max(0, value)))),
      );
      color += 4;
    } else if (again.number === kIndices) {
      for (let at = again.begin; at + 4 <= again.at; at += 4) taken.indices[index++] = again.view.getUint32(at, true);
    }
  }
  return [taken, rest];
}

/** Numbers of a message of doubles: `set(0, ...)` for field 1. */
function doubles(field: Walker, set: (component: number, value: number) => void): void {
  if (field.wire !== kDelimited) throw new Error("a vertex of a scene that is no message");
  const { data, view, at: end } = field;
  let at = field.begin;
  while (at < end) {
    const key = data[at]!;
    if (key < 0x80 && (key & 7) === kFixed64 && at + 9 <= end) {
      set((key >> 3) - 1, view.getFloat64(at + 1, true));
      at += 9;
    } else {
      const other = new Walker(data, at, end); // a field of a newer schema
      other.next();
      at = other.at;
    }
  }
}

function varint(value: number): number[] {
  const bytes: number[] = [];
  for (let left = value; ; left = Math.floor(left / 128)) {
    if (left < 128) return [...bytes, left];
    bytes.push((left % 128) | 0x80);
  }
}

function joined(parts: Uint8Array[]): Uint8Array {
  const result = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    result.set(part, at);
    at += part.length;
  }
  return result;
}
