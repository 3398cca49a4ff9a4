// SPDX-License-Identifier: Apache-2.0
// Writes and reads recordings with the libraries of Foxglove, which share no code with segserve.
//
//   node recording.js write SPEC.json FILE.mcap    messages as SPEC says
//   node recording.js read FILE.mcap [PROTO]       everything by the file's index, as one JSON object
//   node recording.js check                        nothing, if the libraries are there
//
// SPEC: {compression: "", "lz4" or "zstd", chunks: bool, profile, metadata: {name: {key: value}}, channels: [{topic, type,
// encoding, schemaEncoding, schema, messages: [{logTime, message or data}]}]}. Bytes are in base64, times are strings. A
// `message` is encoded as CDR or protobuf by the channel's schema; `data` are the bytes of one. PROTO holds the schemas of
// messages in protobuf. NODE_PATH must lead to the packages that recordings.py names.
'use strict';
const fs = require('fs');
const {McapIndexedReader, McapStreamReader, McapWriter} = require('@mcap/core');
const {loadDecompressHandlers} = require('@mcap/support');
const {MessageReader, MessageWriter} = require('@foxglove/rosmsg2-serialization');
const {parse} = require('@foxglove/rosmsg');
const protobuf = require('protobufjs');
const zstd = require('@foxglove/wasm-zstd');
const lz4 = require('lz4js');

class FileWriter {
  constructor(path) { this.file = fs.openSync(path, 'w'); this.size = 0; }
  async write(bytes) { fs.writeSync(this.file, bytes); this.size += bytes.length; }
  position() { return BigInt(this.size); }
}

class FileReader {
  constructor(path) { this.file = fs.openSync(path, 'r'); }
  async size() { return BigInt(fs.fstatSync(this.file).size); }
  async read(offset, length) {
    const bytes = new Uint8Array(Number(length));
    fs.readSync(this.file, bytes, 0, bytes.length, Number(offset));
    return bytes;
  }
}

/** Bytes instead of the texts in base64 under the keys `data`. */
function withBytes(message) {
  if (Array.isArray(message)) return message.map(withBytes);
  if (message === null || typeof message !== 'object') return message;
  return Object.fromEntries(Object.entries(message).map(
      ([key, value]) => [key, key === 'data' ? new Uint8Array(Buffer.from(value, 'base64')) : withBytes(value)]));
}

/** The type of that name in the text of a schema. */
function protobufType(text, name) {
  return protobuf.parse(text, {keepCase: true}).root.lookupType(name);
}

/** What turns a message of a channel into bytes. */
function encoderOf(channel) {
  if (channel.encoding === 'cdr') {
    const writer = new MessageWriter(parse(channel.schema, {ros2: true}));
    return (message) => writer.writeMessage(withBytes(message));
  }
  if (channel.encoding !== 'protobuf') return null;
  const type = protobufType(channel.schema, channel.type);
  return (message) => type.encode(type.fromObject(withBytes(message))).finish();
}

const compressions = {
  lz4: (bytes) => ({compression: 'lz4', compressedData: Uint8Array.from(lz4.compress(bytes))}),
  zstd: (bytes) => ({compression: 'zstd', compressedData: new Uint8Array(zstd.compress(bytes))}),
};

async function write(specPath, path) {
  await zstd.isLoaded;
  const spec = JSON.parse(fs.readFileSync(specPath));
  const writer = new McapWriter({writable: new FileWriter(path), useChunks: spec.chunks, chunkSize: 20000,
                                 compressChunk: compressions[spec.compression]});
  await writer.start({profile: spec.profile, library: 'test'});
  const messages = [];
  for (const channel of spec.channels) {
    const schemaId = await writer.registerSchema({name: channel.type, encoding: channel.schemaEncoding,
                                                  data: Buffer.from(channel.schema)});
    const channelId = await writer.registerChannel(
        {topic: channel.topic, schemaId, messageEncoding: channel.encoding, metadata: new Map([['of', 'test']])});
    const encode = encoderOf(channel);
    channel.messages.forEach((message, sequence) => {
      const data = message.data !== undefined ? Buffer.from(message.data, 'base64')
                                              : encode(message.message);
      messages.push({channelId, sequence, logTime: BigInt(message.logTime), publishTime: BigInt(message.logTime), data});
    });
  }
  messages.sort((a, b) => Number(a.logTime - b.logTime));
  for (const message of messages) await writer.addMessage(message);
  for (const [name, metadata] of Object.entries(spec.metadata ?? {})) {
    await writer.addMetadata({name, metadata: new Map(Object.entries(metadata))});
  }
  await writer.end();
}

/** Reads the file from its beginning, which checks every CRC. */
async function readAsStream(path, decompressHandlers) {
  const reader = new McapStreamReader({decompressHandlers, validateCrcs: true});
  reader.append(fs.readFileSync(path));
  let messages = 0;
  for (let record; (record = reader.nextRecord());) messages += record.type === 'Message' ? 1 : 0;
  if (!reader.done()) throw new Error('the file does not end as it should');
  return messages;
}

async function read(path, proto) {
  const decompressHandlers = await loadDecompressHandlers();
  const reader = await McapIndexedReader.Initialize({readable: new FileReader(path), decompressHandlers});
  const messages = [];
  for await (const message of reader.readMessages({validateCrcs: true})) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    let decoded = null;
    if (channel.messageEncoding === 'cdr') {
      const text = Buffer.from(schema.data).toString();
      decoded = new MessageReader(parse(text, {ros2: true})).readMessage(message.data);
    } else if (channel.messageEncoding === 'protobuf') {
      const type = protobufType(fs.readFileSync(proto, 'utf8'), schema.name);
      decoded = type.toObject(type.decode(message.data), {longs: Number, bytes: String});
    }
    messages.push({topic: channel.topic, type: schema.name, logTime: message.logTime, sequence: message.sequence,
                   publishTime: message.publishTime, data: Buffer.from(message.data).toString('base64'), decoded});
  }
  const metadata = {};
  for await (const record of reader.readMetadata()) metadata[record.name] = Object.fromEntries(record.metadata);
  const streamed = await readAsStream(path, decompressHandlers);
  if (streamed !== messages.length) throw new Error(`${streamed} messages as a stream, ${messages.length} by the index`);
  const topics = [...reader.channelsById.values()].map((channel) => channel.topic);
  process.stdout.write(JSON.stringify(
      {profile: reader.header.profile, messages, metadata, topics, count: reader.statistics.messageCount,
       chunks: reader.chunkIndexes.length},
      (key, value) => typeof value === 'bigint' ? value.toString()
                      : ArrayBuffer.isView(value) ? Buffer.from(value).toString('base64') : value));
}

const commands = {write, read, check: async () => {}};
commands[process.argv[2]](...process.argv.slice(3)).catch((error) => {
  console.error(error);
  process.exit(1);
});
