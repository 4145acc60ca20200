// A file of the page as the core pulls it, in a worker.
import type { ByteSource } from 'biss';

/** A source that knows how far it has been read. */
export interface MeasuredSource extends ByteSource {
  /** The end of the last bytes that were asked for. */
  readonly reached: number;
}

export function measuredSource(content: File | Uint8Array): MeasuredSource {
  return content instanceof Uint8Array ? new BytesSource(content) : new FileSource(content);
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

class FileSource implements MeasuredSource {
  reached = 0;
  #reader = new FileReaderSync();

  constructor(private readonly file: File) {}

  get size(): number {
    return this.file.size;
  }

  read(offset: number, length: number): Uint8Array {
    const piece = this.file.slice(offset, offset + length);
    const bytes = new Uint8Array(this.#reader.readAsArrayBuffer(piece));
    this.reached = offset + bytes.length;
    return bytes;
  }
}
