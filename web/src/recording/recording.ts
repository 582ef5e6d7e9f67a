/**
 * A recording (MCAP) opened from a file: its topics, its span, its messages by time. A whole file is read by its index,
 * piece by piece; one that was cut off (a recorder that was killed) is read once from its beginning, as far as it goes.
 */

import { McapIndexedReader, McapStreamReader, type McapTypes } from "@mcap/core";
import { kDecompress } from "./decompress.js";

export interface RecordedMessage {
  channel: number;
  time: bigint; // ns, when it was recorded
  data: Uint8Array;
}

export interface RecordedChannel {
  id: number;
  topic: string;
  encoding: string;
  schemaName: string;
  schema: Uint8Array;
}

export interface Span {
  topics: readonly string[];
  from: bigint;
  to: bigint;
  reverse?: boolean;
}

export interface Recording {
  readonly channels: ReadonlyMap<number, RecordedChannel>;
  readonly start: bigint; // ns
  readonly end: bigint;
  /** What was wrong with the file, in words; empty: nothing. */
  readonly problem: string;
  /** Messages of these topics with from <= time <= to, by time. Throws an Error in words where the file is damaged. */
  messages(span: Span): AsyncIterable<RecordedMessage>;
}

const kMagic = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
const kMostUnindexed = 1 << 30; // bytes, of a file that has to be read whole

const words = (error: unknown): string => (error instanceof Error ? error.message : String(error));

function channelOf(channel: McapTypes.Channel, schema: McapTypes.Schema | undefined): RecordedChannel {
  return {
    id: channel.id,
    topic: channel.topic,
    encoding: channel.messageEncoding,
    schemaName: schema?.name ?? "",
    schema: schema?.data ?? new Uint8Array(),
  };
}

/** Opens `file`. Throws an Error in words when it is no recording. */
export async function openRecording(file: Blob): Promise<Recording> {
  const head = new Uint8Array(await file.slice(0, 8).arrayBuffer());
  if (head.length < 8 || kMagic.some((byte, i) => head[i] !== byte)) {
    throw new Error("it does not begin as an MCAP file does: choose a file that prehend record or a launch wrote");
  }
  const readable = {
    size: () => Promise.resolve(BigInt(file.size)),
    read: async (offset: bigint, size: bigint) => {
      if (offset + size > BigInt(file.size)) throw new Error(`it ends before byte ${offset + size}`);
      return new Uint8Array(await file.slice(Number(offset), Number(offset + size)).arrayBuffer());
    },
  };
  try {
    const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: kDecompress });
    if (reader.chunkIndexes.length > 0) return indexed(reader);
  } catch (error) {
    return unindexed(file, `its end is missing or damaged (${words(error).slice(0, 160)}): shown as far as it goes`);
  }
  return unindexed(file, "");
}

function indexed(reader: McapIndexedReader): Recording {
  const channels = new Map<number, RecordedChannel>();
  for (const channel of reader.channelsById.values()) {
    channels.set(channel.id, channelOf(channel, reader.schemasById.get(channel.schemaId)));
  }
  const chunks = reader.chunkIndexes.filter((chunk) => chunk.messageEndTime > 0n);
  const start = chunks.reduce(
    (least, { messageStartTime: at }) => (at < least ? at : least),
    chunks[0]?.messageStartTime ?? 0n,
  );
  const end = chunks.reduce((most, { messageEndTime: at }) => (at > most ? at : most), 0n);
  return {
    channels,
    start,
    end,
    problem: "",
    messages: async function* ({ topics, from, to, reverse = false }: Span) {
      if (topics.length === 0 || from > to) return; // the reader takes no topics for all of them
      for await (const message of reader.readMessages({ topics, startTime: from, endTime: to, reverse })) {
        yield { channel: message.channelId, time: message.logTime, data: message.data };
      }
    },
  };
}

async function unindexed(file: Blob, why: string): Promise<Recording> {
  if (file.size > kMostUnindexed) {
    throw new Error(`it has no index and ${(file.size / 1e9).toFixed(1)} GB: repair it by prehend bag recover`);
  }
  const channels = new Map<number, RecordedChannel>();
  const schemas = new Map<number, McapTypes.Schema>();
  const kept: RecordedMessage[] = [];
  let problem = why;
  try {
    const reader = new McapStreamReader({ decompressHandlers: kDecompress, validateCrcs: true });
    reader.append(new Uint8Array(await file.arrayBuffer()));
    for (let record; (record = reader.nextRecord());) {
      if (record.type === "Schema") schemas.set(record.id, record);
      else if (record.type === "Channel") channels.set(record.id, channelOf(record, schemas.get(record.schemaId)));
      else if (record.type === "Message") {
        kept.push({ channel: record.channelId, time: record.logTime, data: record.data });
      }
    }
  } catch (error) {
    problem = `it is damaged (${words(error).slice(0, 160)}): shown up to there`;
  }
  if (kept.length === 0) throw new Error(problem || "there is no message in it");
  kept.sort((a, b) => (a.time < b.time ? -1 : a.time > b.time ? 1 : 0));
  return {
    channels,
    start: kept[0]!.time,
    end: kept.at(-1)!.time,
    problem,
    messages: async function* ({ topics, from, to, reverse = false }: Span) {
      const wanted = new Set(topics);
      const count = kept.length;
      for (let i = 0; i < count; i++) {
        const message = kept[reverse ? count - 1 - i : i]!;
        if (message.time < from || message.time > to) continue;
        if (wanted.has(channels.get(message.channel)?.topic ?? "")) yield message;
      }
    },
  };
}
