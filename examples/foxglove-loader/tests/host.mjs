// Foxglove's side of the module: opens a log through it and prints each topic with its messages: node host.mjs MODULE.wasm LOG
// Offsets are those of the canonical ABI for the interface in foxglove_data_loader's wit/loader.wit.

import { readFileSync } from "node:fs";

const [, , modulePath, logPath] = process.argv;
const log = readFileSync(logPath);
const LOADER = "foxglove:loader/loader@0.1.0";
const READER = "foxglove:loader/reader@0.1.0";

let position = 0;
const resources = new Map();
const newResource = (rep) => {
  resources.set(resources.size + 1, rep);
  return resources.size;
};
const imports = {
  [`[export]${LOADER}`]: {
    "[resource-new]data-loader": newResource,
    "[resource-new]message-iterator": newResource,
    "[resource-drop]data-loader": () => {},
    "[resource-drop]message-iterator": () => {},
  },
  [READER]: {
    open: () => 1,
    "[resource-drop]reader": () => {},
    "[method]reader.read": (_reader, at, length) => {
      const part = log.subarray(position, position + length);
      new Uint8Array(memory.buffer).set(part, at);
      position += part.length;
      return BigInt(part.length);
    },
  },
};
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(modulePath)), imports);
const { memory } = exports;
const view = () => new DataView(memory.buffer);
const u32 = (at) => view().getUint32(at, true);
const u64 = (at) => view().getBigUint64(at, true);
const bytes = (at) => new Uint8Array(memory.buffer, u32(at), u32(at + 4));
const text = (at) => new TextDecoder().decode(bytes(at));
const method = (name, ...values) => exports[`${LOADER}#[method]${name}`](...values);

/** Where what a method gave back begins; throws what it refused. */
function succeeded(at, payload) {
  if (view().getUint8(at) === 1) {
    throw new Error(text(at + payload));
  }
  return at + payload;
}

function listOfPaths(path) {
  const encoded = new TextEncoder().encode(path);
  const string = exports.cabi_realloc(0, 0, 1, encoded.length);
  const list = exports.cabi_realloc(0, 0, 4, 8);
  new Uint8Array(memory.buffer).set(encoded, string);
  view().setUint32(list, string, true);
  view().setUint32(list + 4, encoded.length, true);
  return list;
}

const loader = resources.get(exports[`${LOADER}#[constructor]data-loader`](listOfPaths(logPath), 1));
const found = succeeded(method("data-loader.initialize", loader), 8);
const CHANNEL = 40;
const channels = Array.from({ length: u32(found + 4) }, (_, k) => {
  const at = u32(found) + k * CHANNEL;
  return { id: view().getUint16(at, true), topic: text(at + 8), encoding: text(at + 16), count: Number(u64(at + 32)) };
});
const problems = u32(found + 36);

const wanted = exports.cabi_realloc(0, 0, 2, 2 * channels.length);
channels.forEach((channel, k) => view().setUint16(wanted + 2 * k, channel.id, true));
const created = method("data-loader.create-iterator", loader, 0, 0n, 0, 0n, wanted, channels.length);
const iterator = resources.get(u32(succeeded(created, 4)));
const messages = new Map(channels.map((channel) => [channel.id, []]));
for (;;) {
  const next = method("message-iterator.next", iterator);
  if (view().getUint8(next) === 0) {
    break;
  }
  const message = succeeded(next + 8, 8);
  const data = bytes(message + 24);
  messages.get(view().getUint16(message, true)).push(new DataView(data.buffer, data.byteOffset + 4).getFloat64(0, true));
  exports[`cabi_post_${LOADER}#[method]message-iterator.next`](next);
}
for (const { id, topic, encoding, count } of channels) {
  const values = messages.get(id);
  if (values.length !== count || !values.every(Number.isFinite)) {
    throw new Error(`${topic}: ${count} messages are said, ${values.length} came`);
  }
  console.log(topic, encoding, count, Math.min(...values).toFixed(3), Math.max(...values).toFixed(3));
}
console.log("problems", problems);
