//! A file read in pieces where they are asked for: a log as long as a day does not have to fit into memory.

/** Of workers alone, and so not among the types of pages. */
declare class FileReaderSync {
  readAsArrayBuffer(blob: Blob): ArrayBuffer;
}

/** A longer file is read in pieces of this length. */
const PIECE = 4 << 20;
/** A file of at most this length is kept: a log is read three times. */
const MOST_KEPT = 128 << 20;

/** Bytes of the file from a place on. */
interface Part {
  readonly from: number;
  readonly bytes: Uint8Array;
}

const NOTHING: Part = { from: 0, bytes: new Uint8Array() };

export class Pieces {
  readonly #file: File;
  #part = NOTHING;

  constructor(file: File) {
    this.#file = file;
  }

  /** SHA-256 of a file that is kept; nothing of a longer one, or where the browser has none. */
  async checkSum(): Promise<Uint8Array> {
    const isKept = this.#file.size <= MOST_KEPT;
    // Absent where the page comes from a server without encryption.
    const subtle = self.crypto.subtle as SubtleCrypto | undefined;
    if (!isKept || subtle === undefined) return new Uint8Array();
    // What cannot be read is refused where a reader wants it.
    const whole = await this.#file.arrayBuffer().catch(() => null);
    if (whole === null) return new Uint8Array();
    this.#part = { from: 0, bytes: new Uint8Array(whole) };
    return new Uint8Array(await subtle.digest("SHA-256", whole));
  }

  /** Gives the memory back; the file is read again where it is asked for. */
  forget(): void {
    this.#part = NOTHING;
  }

  /** Bytes from a position on: as many as are wanted, or to the end of what is read at once. Throws where the file is gone. */
  at(position: number, length: number): Uint8Array {
    if (position >= this.#file.size) return NOTHING.bytes;
    const { from, bytes } = this.#part;
    const isThere = from <= position && position < from + bytes.length;
    const part = isThere ? this.#part : this.#read(position);
    return part.bytes.subarray(position - part.from, position - part.from + length);
  }

  #read(position: number): Part {
    const isKept = this.#file.size <= MOST_KEPT;
    const from = isKept ? 0 : position;
    const part = isKept ? this.#file : this.#file.slice(from, from + PIECE);
    this.#part = { from, bytes: new Uint8Array(new FileReaderSync().readAsArrayBuffer(part)) };
    return this.#part;
  }
}
