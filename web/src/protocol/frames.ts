/**
 * The Foxglove WebSocket protocol's frames: bytes and text <-> values, with every length checked.
 * What is malformed throws a ProtocolError that says what, and where; the caller goes on.
 */

export class ProtocolError extends Error {}

/** What the server offers to subscribe to. */
export interface Channel {
  id: number;
  topic: string;
  encoding: string;
  schemaName: string;
  schema: string;
  schemaEncoding: string;
}

export interface PayloadSchema {
  encoding: string;
  schemaName: string;
  schema: string;
}

export interface Service {
  id: number;
  name: string;
  request: PayloadSchema;
  response: PayloadSchema;
}

export type ParameterValue = number | boolean | string | null | ParameterValue[] | { [key: string]: ParameterValue };

export interface Parameter {
  name: string;
  value?: ParameterValue;
  type?: string;
}

export type ServerFrame =
  | { op: "message"; subscription: number; time: bigint; data: Uint8Array }
  | { op: "time"; time: bigint }
  | { op: "serviceResponse"; service: number; call: number; encoding: string; data: Uint8Array }
  | { op: "assetResponse"; request: number; error: string; data: Uint8Array }
  | { op: "playback"; status: number; time: bigint; speed: number };

export type ServerMessage =
  | { op: "serverInfo"; name: string; capabilities: string[]; sessionId: string }
  | { op: "status"; level: number; message: string; id: string }
  | { op: "removeStatus"; statusIds: string[] }
  | { op: "advertise"; channels: Channel[] }
  | { op: "unadvertise"; channelIds: number[] }
  | { op: "parameterValues"; parameters: Parameter[]; id: string }
  | { op: "advertiseServices"; services: Service[] }
  | { op: "unadvertiseServices"; serviceIds: number[] }
  | { op: "serviceCallFailure"; serviceId: number; callId: number; message: string }
  | { op: "connectionGraphUpdate" };

const decoder = new TextDecoder();
const encoder = new TextEncoder();

/** A binary frame of the server. `data` of the result is a view of `buffer`, not a copy. */
export function parseFrame(buffer: ArrayBuffer): ServerFrame {
  const view = new DataView(buffer);
  const need = (bytes: number, what: string): void => {
    if (buffer.byteLength < bytes) {
      throw new ProtocolError(`${what} of ${buffer.byteLength} bytes is cut off: it needs at least ${bytes}`);
    }
  };
  const text = (at: number, what: string): { text: string; end: number } => {
    need(at + 4, what);
    const length = view.getUint32(at, true);
    need(at + 4 + length, what);
    return { text: decoder.decode(new Uint8Array(buffer, at + 4, length)), end: at + 4 + length };
  };
  need(1, "frame");
  const opcode = view.getUint8(0);
  switch (opcode) {
    case 1:
      need(13, "message frame");
      return {
        op: "message",
        subscription: view.getUint32(1, true),
        time: view.getBigUint64(5, true),
        data: new Uint8Array(buffer, 13),
      };
    case 2:
      need(9, "time frame");
      return { op: "time", time: view.getBigUint64(1, true) };
    case 3: {
      const encoding = text(9, "service response");
      return {
        op: "serviceResponse",
        service: view.getUint32(1, true),
        call: view.getUint32(5, true),
        encoding: encoding.text,
        data: new Uint8Array(buffer, encoding.end),
      };
    }
    case 4: {
      const error = text(6, "asset response");
      const failed = view.getUint8(5) !== 0;
      return {
        op: "assetResponse",
        request: view.getUint32(1, true),
        error: failed ? error.text || "the server does not say why" : "",
        data: new Uint8Array(buffer, error.end),
      };
    }
    case 5:
      need(15, "playback state");
      return {
        op: "playback",
        status: view.getUint8(1),
        time: view.getBigUint64(2, true),
        speed: view.getFloat32(10, true),
      };
    default:
      throw new ProtocolError(`unknown opcode ${opcode} of a frame of ${buffer.byteLength} bytes`);
  }
}

type Json = { [key: string]: unknown };

const isObject = (value: unknown): value is Json =>
  typeof value === "object" && value !== null && !Array.isArray(value);
const textOf = (value: unknown): string => (typeof value === "string" ? value : "");

function array(message: Json, key: string): unknown[] {
  const value = message[key];
  if (!Array.isArray(value)) throw new ProtocolError(`"${textOf(message["op"])}": "${key}" is no array`);
  return value;
}

function identifier(message: Json, key: string, op: string): number {
  const value = message[key];
  if (typeof value !== "number" || !Number.isInteger(value) || value < 0 || value > 0xffffffff) {
    throw new ProtocolError(`"${op}": "${key}" is no number of 32 bits`);
  }
  return value;
}

function channelOf(value: unknown): Channel {
  if (!isObject(value) || typeof value["topic"] !== "string")
    throw new ProtocolError('"advertise": a channel has no topic');
  return {
    id: identifier(value, "id", "advertise"),
    topic: value["topic"],
    encoding: textOf(value["encoding"]),
    schemaName: textOf(value["schemaName"]),
    schema: textOf(value["schema"]),
    schemaEncoding: textOf(value["schemaEncoding"]),
  };
}

function serviceOf(value: unknown): Service {
  if (!isObject(value) || typeof value["name"] !== "string") {
    throw new ProtocolError('"advertiseServices": a service has no name');
  }
  const payload = (key: string, older: string): PayloadSchema => {
    const given = value[key];
    return isObject(given)
      ? {
          encoding: textOf(given["encoding"]),
          schemaName: textOf(given["schemaName"]),
          schema: textOf(given["schema"]),
        }
      : { encoding: "", schemaName: "", schema: textOf(value[older]) };
  };
  return {
    id: identifier(value, "id", "advertiseServices"),
    name: value["name"],
    request: payload("request", "requestSchema"),
    response: payload("response", "responseSchema"),
  };
}

/** A text frame of the server; null: an op that this page does not know, which the protocol allows. */
export function parseMessage(text: string): ServerMessage | null {
  let message: unknown;
  try {
    message = JSON.parse(text);
  } catch {
    throw new ProtocolError(`a text frame is no JSON: ${text.slice(0, 60)}`);
  }
  if (!isObject(message)) throw new ProtocolError("a text frame is no JSON object");
  const op = message["op"];
  switch (op) {
    case "serverInfo":
      return {
        op,
        name: textOf(message["name"]),
        capabilities: array(message, "capabilities").filter((item) => typeof item === "string"),
        sessionId: textOf(message["sessionId"]),
      };
    case "status": {
      const level = message["level"];
      return {
        op,
        level: typeof level === "number" ? level : 2,
        message: textOf(message["message"]),
        id: textOf(message["id"]),
      };
    }
    case "removeStatus":
      return { op, statusIds: array(message, "statusIds").map(textOf) };
    case "advertise":
      return { op, channels: array(message, "channels").map(channelOf) };
    case "unadvertise":
      return { op, channelIds: array(message, "channelIds").filter((id) => typeof id === "number") };
    case "parameterValues":
      return {
        op,
        parameters: array(message, "parameters").filter(
          (item): item is Parameter & Json => isObject(item) && typeof item["name"] === "string",
        ),
        id: textOf(message["id"]),
      };
    case "advertiseServices":
      return { op, services: array(message, "services").map(serviceOf) };
    case "unadvertiseServices":
      return { op, serviceIds: array(message, "serviceIds").filter((id) => typeof id === "number") };
    case "serviceCallFailure":
      return {
        op,
        serviceId: identifier(message, "serviceId", op),
        callId: identifier(message, "callId", op),
        message: textOf(message["message"]),
      };
    case "connectionGraphUpdate":
      return { op };
    default:
      return null;
  }
}

/** The binary frame of a service's request. */
export function serviceRequest(
  service: number,
  call: number,
  encoding: string,
  data: Uint8Array,
): Uint8Array<ArrayBuffer> {
  const name = encoder.encode(encoding);
  const frame = new Uint8Array(13 + name.length + data.length);
  const view = new DataView(frame.buffer);
  view.setUint8(0, 2);
  view.setUint32(1, service, true);
  view.setUint32(5, call, true);
  view.setUint32(9, name.length, true);
  frame.set(name, 13);
  frame.set(data, 13 + name.length);
  return frame;
}

/** Bytes of standard base64. Throws a ProtocolError on anything else. */
export function base64Bytes(text: string): Uint8Array {
  let binary: string;
  try {
    binary = atob(text);
  } catch {
    throw new ProtocolError("a schema is no base64");
  }
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}
