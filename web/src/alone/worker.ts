//! Runs the module beside the page, so that the page never waits for it.

import type { Answer, Message } from "./module.ts";

/** What crates/seatrial-wasm exports. */
interface Exports {
  readonly memory: WebAssembly.Memory;
  inbox(length: number): number;
  hold(nameLength: number): void;
  ask(): number;
  outbox(): number;
  broken(): number;
  broken_text(): number;
}

let program: Exports | null = null;
let work: Promise<void> = Promise.resolve();

// One after the other, in the order in which they come.
self.onmessage = (event: MessageEvent<Message>) => {
  work = work.then(async () => self.postMessage(await answer(event.data)));
};

async function answer(message: Message): Promise<Answer> {
  try {
    if (message.kind === "load") {
      program = await load(message.packed);
      return { done: null };
    }
    if (program === null) return { broken: "the program is not loaded" };
    if (message.kind === "hold") {
      const name = new TextEncoder().encode(message.name);
      put(program, name, new Uint8Array(message.content));
      program.hold(name.length);
      return { done: null };
    }
    put(program, new TextEncoder().encode(JSON.stringify(message.request)));
    const length = program.ask();
    return JSON.parse(text(program, program.outbox(), length)) as Answer;
  } catch (error) {
    const said = program === null ? "" : text(program, program.broken_text(), program.broken());
    return { broken: said === "" ? String(error) : said };
  }
}

async function load(packed: ArrayBuffer): Promise<Exports> {
  const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const { instance } = await WebAssembly.instantiate(await new Response(unpacked).arrayBuffer());
  return instance.exports as unknown as Exports;
}

/** Puts a message into the inbox. */
function put(program: Exports, ...parts: Uint8Array[]): void {
  const length = parts.reduce((sum, part) => sum + part.length, 0);
  let at = program.inbox(length);
  for (const part of parts) {
    new Uint8Array(program.memory.buffer, at, part.length).set(part);
    at += part.length;
  }
}

function text(program: Exports, at: number, length: number): string {
  return new TextDecoder().decode(new Uint8Array(program.memory.buffer, at, length));
}
