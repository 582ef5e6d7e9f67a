/**
 * Fields of a message whose type is known at run time only: what is absent or of another type than expected reads as
 * protobuf's default, so that a foreign or newer message never breaks a panel. Names are protobuf's in camel case
 * (`frame_id` is `frameId`, `X_WC` is `XWC`).
 */

export type Fields = { readonly [name: string]: unknown };

const kNone: Fields = Object.freeze({});

export function fieldsOf(value: unknown): Fields {
  return typeof value === "object" && value !== null ? (value as Fields) : kNone;
}

/** A number of any width; NaN and infinities of the wire pass. */
export function number(from: Fields, name: string, otherwise = 0): number {
  const value = from[name];
  if (typeof value === "number") return value;
  return typeof value === "bigint" ? Number(value) : otherwise;
}

/** A number that may be absent (proto3 optional). */
export function optionalNumber(from: Fields, name: string): number | undefined {
  const value = from[name];
  return typeof value === "number" ? value : undefined;
}

export function integer64(from: Fields, name: string): bigint {
  const value = from[name];
  if (typeof value === "bigint") return value;
  return typeof value === "number" && Number.isSafeInteger(value) ? BigInt(value) : 0n;
}

export function text(from: Fields, name: string): string {
  const value = from[name];
  return typeof value === "string" ? value : "";
}

export function truth(from: Fields, name: string): boolean {
  return from[name] === true;
}

export function bytes(from: Fields, name: string): Uint8Array {
  const value = from[name];
  return value instanceof Uint8Array ? value : new Uint8Array();
}

export function has(from: Fields, name: string): boolean {
  return from[name] !== undefined && from[name] !== null;
}

export function child(from: Fields, name: string): Fields {
  return fieldsOf(from[name]);
}

export function children(from: Fields, name: string): Fields[] {
  const value = from[name];
  return Array.isArray(value) ? value.map(fieldsOf) : [];
}

export function numbers(from: Fields, name: string): number[] {
  const value = from[name];
  return Array.isArray(value) ? value.map((item) => (typeof item === "number" ? item : Number(item))) : [];
}

export function texts(from: Fields, name: string): string[] {
  const value = from[name];
  return Array.isArray(value) ? value.filter((item): item is string => typeof item === "string") : [];
}
