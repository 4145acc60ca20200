// A file of the page as the core pulls it, in a worker.
import type { ByteSource } from 'biss';

/** A source that records how far it has been read. */
export interface MeasuredSource extends ByteSource {
  /** The end of the last requested bytes. */
  readonly reached: number;
  /** Fetches the bytes that will be read next, if they are known. A promise: wait, they are needed soon. */
  prefetch?(): Promise<void> | undefined;
}

/** A file that the page's own server gives in pieces. */
export interface ServedFile {
  /** Whole, with its scheme. */
  address: string;
  size: number;
}

/** Everything from which a capture may be read. */
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

// Each read of a file costs a message to another process of the browser. Most files are read in order. If a
// read begins at the end of the last one, more bytes are read at once, and the bytes after them are fetched
// meanwhile.
const aheadBytes = 16 << 20;
const aheadBlocks = 2;
// More bytes than one slice of the reading uses.
const soonBytes = 10 << 20;

interface Ahead {
  begin: number;
  /** Undefined until they have come; empty if they cannot be read. */
  bytes?: Uint8Array<ArrayBuffer>;
  come: Promise<void>;
}

class FileSource implements MeasuredSource {
  reached = 0;
  #reader = new FileReaderSync();
  #begin = 0;
  #held = new Uint8Array(0);
  // The blocks that follow, in order.
  #ahead: Ahead[] = [];

  constructor(private readonly file: File) {}

  get size(): number {
    return this.file.size;
  }

  read(offset: number, length: number): Uint8Array {
    const within = offset - this.#begin;
    if (within < 0 || within >= this.#held.length) this.#take(offset, length);
    const piece = this.#held.subarray(offset - this.#begin, offset - this.#begin + length);
    this.reached = offset + piece.length;
    return piece;
  }

  // A file that is read at scattered places has only short pieces.
  prefetch(): Promise<void> | undefined {
    if (this.#held.length < aheadBytes) return undefined;
    const end = this.#begin + this.#held.length;
    for (let count = this.#ahead.length; count < aheadBlocks; count += 1) {
      const begin = end + count * aheadBytes;
      if (begin < this.size) this.#ahead.push(this.#ask(begin));
    }
    return end - this.reached < soonBytes ? this.#ahead[0]?.come : undefined;
  }

  // If these bytes cannot be read, the read that needs them reports the error.
  #ask(begin: number): Ahead {
    const ahead: Ahead = { begin, come: Promise.resolve() };
    ahead.come = readBeside(this.file.slice(begin, begin + aheadBytes)).then((bytes) => { ahead.bytes = bytes; });
    return ahead;
  }

  #take(offset: number, length: number): void {
    const next = this.#ahead.shift();
    if (next?.begin === offset && next.bytes !== undefined && next.bytes.length > 0) {
      this.#held = next.bytes;
    } else {
      const goesOn = offset === this.#begin + this.#held.length && offset > 0;
      const wanted = goesOn ? Math.max(length, aheadBytes) : length;
      this.#held = new Uint8Array(this.#reader.readAsArrayBuffer(this.file.slice(offset, offset + wanted)));
      if (next?.begin !== offset) this.#ahead = [];
    }
    this.#begin = offset;
  }
}

// A file's bytes come in small messages, which a thread that computes does not take: so another
// worker waits for them.
const readerText = `onmessage = ({ data }) => {
  let bytes = new ArrayBuffer(0);
  try { bytes = new FileReaderSync().readAsArrayBuffer(data); } catch {}
  postMessage(bytes, [bytes]);
};`;
let beside: Worker | undefined;
let isBroken = false;
const asked: ((bytes: Uint8Array<ArrayBuffer>) => void)[] = [];

function startReader(): Worker {
  const worker = new Worker(URL.createObjectURL(new Blob([readerText], { type: 'text/javascript' })));
  worker.onmessage = ({ data }: MessageEvent<ArrayBuffer>) => asked.shift()?.(new Uint8Array(data));
  worker.onerror = () => {
    isBroken = true;
    asked.splice(0).forEach((resolve) => resolve(new Uint8Array(0)));
  };
  return worker;
}

// Reads the pieces in the order of the calls. Returns no bytes if they cannot be read.
async function readBeside(piece: Blob): Promise<Uint8Array<ArrayBuffer>> {
  try {
    if (!isBroken) beside ??= startReader();
  } catch {
    isBroken = true;
  }
  if (isBroken) return new Uint8Array(0);
  return new Promise((resolve) => {
    asked.push(resolve);
    beside?.postMessage(piece);
  });
}

// Requested at once while the core reads: a worker may wait for an answer.
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
      throw new Error(`${this.file.address}: bytes ${offset} to ${offset + length} did not arrive`);
    }
    this.reached = offset + bytes.length;
    return bytes;
  }
}
