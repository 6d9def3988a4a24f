//! The program behind the page: seatrial in WebAssembly, in a worker of its own. Nothing is asked of a network.

import { Refused } from "../api/client.ts";
import ProgramWorker from "./worker.ts?worker&inline";

/** What the worker is told: a file to hold, or a request. */
export type Message =
  | { readonly kind: "load"; readonly packed: ArrayBuffer }
  | { readonly kind: "hold"; readonly name: string; readonly content: ArrayBuffer }
  | { readonly kind: "ask"; readonly request: unknown };

export type Answer = { readonly done: unknown } | { readonly refused: string } | { readonly broken: string };

/** Where the page keeps the module: packed by gzip, as base64. */
const STORE = "program";

export class Program {
  #worker: Worker | null = null;
  #waiting: ((answer: Answer) => void)[] = [];
  #held = new Map<string, ArrayBuffer>();

  /** Holds a file by its name for the requests that follow. */
  async hold(file: File): Promise<void> {
    const content = await file.arrayBuffer();
    this.#held.set(file.name, content);
    await this.#tell({ kind: "hold", name: file.name, content });
  }

  /** The answer to a request; throws what refuses it. */
  async ask<T>(request: object): Promise<T> {
    const answer = await this.#tell({ kind: "ask", request });
    if ("done" in answer) return answer.done as T;
    if ("refused" in answer) throw new Refused("refused", answer.refused);
    this.#worker?.terminate();
    this.#worker = null;
    throw new Refused(
      "broken",
      `The program stopped on this (${answer.broken}). It is started anew; please report the log to the project.`,
    );
  }

  async #tell(message: Message): Promise<Answer> {
    const worker = this.#worker ?? (await this.#start());
    return this.#post(worker, message);
  }

  #post(worker: Worker, message: Message, moved: Transferable[] = []): Promise<Answer> {
    return new Promise((done) => {
      this.#waiting.push(done);
      worker.postMessage(message, moved);
    });
  }

  async #start(): Promise<Worker> {
    const worker = new ProgramWorker();
    this.#worker = worker;
    this.#waiting = [];
    worker.onmessage = (event: MessageEvent<Answer>) => this.#waiting.shift()?.(event.data);
    worker.onerror = (event) => this.#waiting.shift()?.({ broken: event.message });
    const packed = bytesOf(document.getElementById(STORE)?.textContent ?? "");
    await this.#post(worker, { kind: "load", packed }, [packed]);
    for (const [name, content] of this.#held) await this.#post(worker, { kind: "hold", name, content });
    return worker;
  }
}

function bytesOf(base64: string): ArrayBuffer {
  const text = atob(base64.trim());
  const bytes = new Uint8Array(text.length);
  for (let at = 0; at < text.length; at += 1) bytes[at] = text.charCodeAt(at);
  return bytes.buffer;
}
