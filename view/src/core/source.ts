// A file of the page as the core pulls it, in a worker.
import type { ByteSource } from 'biss';

/** A source that knows how far it has been read. */
export interface MeasuredSource extends ByteSource {
  /** The end of the last bytes that were asked for. */
  readonly reached: number;
}

/** A file that the page's own server gives in pieces. */
export interface ServedFile {
  /** Whole, with its scheme. */
  address: string;
  size: number;
}

/** All that a capture may be read from. */
export type Content = File | Uint8Array | ServedFile;

export function sizeOf(content: Content): number {
  return content instanceof Uint8Array ? content.length : content.size;
}

export function measuredSource(content: Content): MeasuredSource {
  if (content instanceof Uint8Array) return new BytesSource(content);
  return content instanceof File ? new FileSource(content) : new ServedSource(content);
}

class BytesSource implements MeasuredSource {
  reached = 0;

  constructor(private readonly bytes: Uint8Array) {}

  get size(): number {
    return this.bytes.length;
  }

  read(offset: number, length: number): Uint8Array {
    const piece = this.bytes.subarray(offset, offset + length);
    this.reached = offset + piece.length;
    return piece;
  }
}

// Each read of a file costs a message to another process of the browser. Where a file is read on
// from where the last read ended, as most are, more is read at once.
const aheadBytes = 8 << 20;

class FileSource implements MeasuredSource {
  reached = 0;
  #reader = new FileReaderSync();
  #begin = 0;
  #held = new Uint8Array(0);

  constructor(private readonly file: File) {}

  get size(): number {
    return this.file.size;
  }

  read(offset: number, length: number): Uint8Array {
    const within = offset - this.#begin;
    if (within < 0 || within >= this.#held.length) this.#fetch(offset, length);
    const piece = this.#held.subarray(offset - this.#begin, offset - this.#begin + length);
    this.reached = offset + piece.length;
    return piece;
  }

  #fetch(offset: number, length: number): void {
    const goesOn = offset === this.#begin + this.#held.length && offset > 0;
    const wanted = goesOn ? Math.max(length, aheadBytes) : length;
    this.#held = new Uint8Array(this.#reader.readAsArrayBuffer(this.file.slice(offset, offset + wanted)));
    this.#begin = offset;
  }
}

// Asked for at once, as the core reads: a worker may wait for an answer.
class ServedSource implements MeasuredSource {
  reached = 0;

  constructor(private readonly file: ServedFile) {}

  get size(): number {
    return this.file.size;
  }

  read(offset: number, length: number): Uint8Array {
    const request = new XMLHttpRequest();
    request.open('GET', this.file.address, false);
    request.responseType = 'arraybuffer';
    request.setRequestHeader('Range', `bytes=${offset}-${offset + length - 1}`);
    request.send();
    const bytes = new Uint8Array((request.response as ArrayBuffer | null) ?? new ArrayBuffer(0));
    if (request.status !== 206 || bytes.length === 0 || bytes.length > length) {
      throw new Error(`${this.file.address}: bytes ${offset} to ${offset + length} did not come`);
    }
    this.reached = offset + bytes.length;
    return bytes;
  }
}
