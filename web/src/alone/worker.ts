//! Runs the module beside the page, so that the page never waits for it.

import type { Answer, Message } from "./module.ts";
import { Pieces } from "./pieces.ts";

/** What crates/seatrial-wasm exports. */
interface Exports {
  readonly memory: WebAssembly.Memory;
  inbox(length: number): number;
  hold(number: number, length: number, nameLength: number): void;
  ask(): number;
  outbox(): number;
  broken(): number;
  broken_text(): number;
}

let program: Exports | null = null;
/** Files by their numbers, and the numbers by their names. */
const files: Pieces[] = [];
const numbers = new Map<string, number>();
let work: Promise<void> = Promise.resolve();

// One after the other, in the order in which they come.
self.onmessage = (event: MessageEvent<Message>) => {
  work = work.then(async () => self.postMessage(await answer(event.data)));
};

async function answer(message: Message): Promise<Answer> {
  try {
    if (message.kind === "load") {
      program = await load(message.base64);
      return { done: null };
    }
    if (program === null) return { broken: "the program is not loaded" };
    if (message.kind === "hold") {
      const { file } = message;
      const number = numbers.get(file.name) ?? files.length;
      numbers.set(file.name, number);
      for (const other of files) other.forget();
      const pieces = (files[number] = new Pieces(file));
      const name = new TextEncoder().encode(file.name);
      put(program, name, await pieces.checkSum());
      program.hold(number, file.size, name.length);
      return { done: null };
    }
    put(program, new TextEncoder().encode(JSON.stringify(message.request)));
    const length = program.ask();
    const answer = JSON.parse(text(program, program.outbox(), length)) as Answer;
    return { ...answer, memory: program.memory.buffer.byteLength };
  } catch (error) {
    const said = program === null ? "" : text(program, program.broken_text(), program.broken());
    return { broken: said === "" ? String(error) : said };
  }
}

async function load(base64: string): Promise<Exports> {
  const packed = atob(base64);
  const bytes = new Uint8Array(packed.length);
  for (let at = 0; at < packed.length; at += 1) bytes[at] = packed.charCodeAt(at);
  const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const response = new Response(unpacked, { headers: { "Content-Type": "application/wasm" } });
  const module = await WebAssembly.compileStreaming(response);
  const instance = await WebAssembly.instantiate(module, { ...stubs(module), page: { read } });
  return instance.exports as unknown as Exports;
}

/**
 * What libraries name and never call here. The reader of workbooks links a source of random numbers, which would have its own loader, and
 * draws none. Whatever is called after all stops the program.
 */
function stubs(module: WebAssembly.Module): WebAssembly.Imports {
  const imports: Record<string, Record<string, () => never>> = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    const stub = (): never => {
      throw new Error(`${from}.${name} is not there`);
    };
    imports[from] = { ...imports[from], [name]: stub };
  }
  return imports;
}

/** What the module asks of the page: bytes of a held file, at an address of its memory; how many there are, -1 where the file is gone. */
function read(number: number, position: number, address: number, length: number): number {
  try {
    const bytes = files[number]?.at(position, length);
    if (program === null || bytes === undefined) return -1;
    new Uint8Array(program.memory.buffer, address, bytes.length).set(bytes);
    return bytes.length;
  } catch {
    return -1;
  }
}

/** Puts a message into the inbox. */
function put(program: Exports, ...parts: Uint8Array[]): void {
  let at = program.inbox(parts.reduce((sum, part) => sum + part.length, 0));
  for (const part of parts) {
    new Uint8Array(program.memory.buffer, at, part.length).set(part);
    at += part.length;
  }
}

function text(program: Exports, at: number, length: number): string {
  return new TextDecoder().decode(new Uint8Array(program.memory.buffer, at, length));
}
