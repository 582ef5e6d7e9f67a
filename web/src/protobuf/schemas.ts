/**
 * Messages by the schema that came with them (a serialised FileDescriptorSet): of a live channel and of a recording
 * alike. Nothing is known of a message beforehand, so that one of another version reads as far as it goes.
 */

import { createFileRegistry, fromBinary, type DescMessage, type Message } from "@bufbuild/protobuf";
import { FileDescriptorSetSchema } from "@bufbuild/protobuf/wkt";

/** Reads one type of message; throws an Error in words on bytes that are none. */
export type Decode = (data: Uint8Array) => Message;

/** The decoder of the message type `name` in `schema`. Throws an Error in words when the schema is damaged. */
export function decoderOf(name: string, schema: Uint8Array): Decode {
  const type = typeOf(name, schema);
  return (data) => {
    try {
      return fromBinary(type, data);
    } catch (error) {
      throw new Error(`${data.length} bytes are no ${name}: ${error instanceof Error ? error.message : String(error)}`);
    }
  };
}

function typeOf(name: string, schema: Uint8Array): DescMessage {
  let type: DescMessage | undefined;
  try {
    type = createFileRegistry(fromBinary(FileDescriptorSetSchema, schema)).getMessage(name);
  } catch (error) {
    throw new Error(`the schema of ${name} is damaged: ${error instanceof Error ? error.message : String(error)}`);
  }
  if (!type) throw new Error(`the schema of ${name} does not define it`);
  return type;
}
