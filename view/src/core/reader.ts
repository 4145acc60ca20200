// Reads a capture in slices, between which the worker answers.
import type { Session } from 'biss';
import type { Reading, ReadingMessage } from './protocol';
import type { MeasuredSource } from './source';
import { messageOf } from './texts';

// A request during reading waits no longer than this.
const sliceMilliseconds = 16;
// New rows are reported to the page at this interval.
const reportMilliseconds = 100;
// Analyses of the rows so far take at most this share of the reading time; unused time is kept, up
// to a limit.
const analysesShare = 0.05;
const mostSavedMilliseconds = 50;

export class Reader {
  readonly session: Session;
  #generation: number;
  #sources: MeasuredSource[];
  #report: ((message: ReadingMessage) => void) | undefined;
  #ended: (reading: Reading | undefined) => void = () => {};
  /** The result at the end of the capture; undefined if the reader is closed before. */
  readonly ended = new Promise<Reading | undefined>((resolve) => { this.#ended = resolve; });
  #channel = new MessageChannel();
  #reported = 0;
  #messages = '';
  #closed = false;
  #isReading = true;
  #saved = mostSavedMilliseconds;
  #analyses: (() => void)[] = [];

  /** Without `report` only the end is reported, by `ended`. */
  constructor(session: Session, generation: number, sources: MeasuredSource[],
    report?: (message: ReadingMessage) => void) {
    this.session = session;
    this.#generation = generation;
    this.#sources = sources;
    this.#report = report;
    this.#channel.port1.onmessage = () => this.#slice();
    this.#next();
  }

  close(): void {
    if (this.#closed) return;
    this.#closed = true;
    this.#channel.port1.close();
    this.session.close();
    this.#analyse();
    this.#ended(undefined);
  }

  /** The result of an analysis, which delays the reading: it is made when there is time for it. */
  analysed<T>(analysis: (session: Session) => T): Promise<T> {
    return new Promise((resolve, reject) => {
      this.#analyses.push(() => {
        try {
          if (this.#closed) throw new Error('the capture has been closed');
          resolve(analysis(this.session));
        } catch (error) {
          reject(error);
        }
      });
      this.#analyse();
    });
  }

  #analyse(): void {
    while (this.#analyses.length > 0 && (this.#saved > 0 || !this.#isReading || this.#closed)) {
      const began = performance.now();
      this.#analyses.shift()?.();
      this.#saved -= performance.now() - began;
    }
  }

  // A message to ourselves is handled after those that wait.
  #next(): void {
    this.#channel.port2.postMessage(undefined);
  }

  #slice(): void {
    if (this.#closed) return;
    let more = false;
    let error = '';
    const began = performance.now();
    try {
      const step = this.session.advance(sliceMilliseconds);
      more = step.more;
      this.#messages += step.messages;
    } catch (thrown) {
      error = messageOf(thrown);
    }
    const now = performance.now();
    this.#saved = Math.min(mostSavedMilliseconds, this.#saved + (now - began) * analysesShare);
    this.#isReading = more;
    if (!more || now - this.#reported >= reportMilliseconds) {
      this.#reported = now;
      this.#tell(more, error);
    }
    this.#analyse();
    if (more) void Promise.all(this.#sources.map((source) => source.prefetch?.())).then(() => this.#next());
  }

  #tell(more: boolean, error: string): void {
    const reading = this.reading(more, error);
    this.#report?.({ reading });
    if (!more) this.#ended(reading);
  }

  /**
   * The capture as far as it has been read; `done` is the part of the file, 0 to 1.
   * \param error empty, or why reading ended, such as memory
   */
  reading(more: boolean, error: string) {
    return {
      generation: this.#generation,
      about: this.session.about(),
      columns: this.session.columns,
      rowCount: this.session.rowCount,
      more,
      messages: this.#messages,
      done: more ? this.#done() : 1,
      error,
    };
  }

  #done(): number {
    const size = this.#sources.reduce((sum, source) => sum + source.size, 0);
    const reached = this.#sources.reduce((sum, source) => sum + source.reached, 0);
    return size === 0 ? 0 : Math.min(1, reached / size);
  }
}
