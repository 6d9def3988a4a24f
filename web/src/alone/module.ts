//! The program behind the page: seatrial in WebAssembly, in a worker of its own. Nothing is asked of a network.

import { Refused } from "../api/client.ts";
import ProgramWorker from "./worker.ts?worker&inline";

/** What the worker is told: a file to hold, or a request. */
export type Message =
  | { readonly kind: "load"; readonly base64: string }
  | { readonly kind: "hold"; readonly file: File }
  | { readonly kind: "ask"; readonly request: unknown };

export type Answer = ({ readonly done: unknown } | { readonly refused: string } | { readonly broken: string }) & {
  /** Bytes of the module's memory, which never shrinks. */
  readonly memory?: number;
};

/** Where the page keeps the module: packed by gzip, as base64. */
const STORE = "program";

export class Program {
  #worker: Worker | null = null;
  #waiting: ((answer: Answer) => void)[] = [];
  #held = new Map<string, File>();
  /** The most bytes that the module's memory had. */
  memory = 0;

  /** Compiles the program before it is asked for anything. */
  async begin(): Promise<void> {
    if (this.#worker === null) await this.#start();
  }

  /** Holds a file by its name for the requests that follow; its bytes are read when they are asked for. */
  async hold(file: File): Promise<void> {
    this.#held.set(file.name, file);
    await this.#tell({ kind: "hold", file });
  }

  /** The answer to a request; throws what refuses it. */
  async ask<T>(request: object): Promise<T> {
    const answer = await this.#tell({ kind: "ask", request });
    this.memory = Math.max(this.memory, answer.memory ?? 0);
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

  #post(worker: Worker, message: Message): Promise<Answer> {
    return new Promise((done) => {
      this.#waiting.push(done);
      worker.postMessage(message);
    });
  }

  async #start(): Promise<Worker> {
    const worker = new ProgramWorker();
    this.#worker = worker;
    this.#waiting = [];
    worker.onmessage = (event: MessageEvent<Answer>) => this.#waiting.shift()?.(event.data);
    worker.onerror = (event) => this.#waiting.shift()?.({ broken: event.message });
    const base64 = (document.getElementById(STORE)?.textContent ?? "").trim();
    await this.#post(worker, { kind: "load", base64 });
    for (const file of this.#held.values()) await this.#post(worker, { kind: "hold", file });
    return worker;
  }
}
