// Reads a capture in slices, between which the worker answers.
import type { Session } from 'biss';
import type { ReadingMessage } from './protocol';
import type { MeasuredSource } from './source';

// What is asked meanwhile waits no longer than this.
const sliceMilliseconds = 8;
// The page hears of new rows as often.
const reportMilliseconds = 100;

export class Reader {
  readonly session: Session;
  #generation: number;
  #sources: MeasuredSource[];
  #report: ((message: ReadingMessage) => void) | undefined;
  #ended: (reading: ReadingMessage['reading'] | undefined) => void = () => {};
  /** What is known at the end; undefined where the reader is closed before. */
  readonly ended = new Promise<ReadingMessage['reading'] | undefined>((resolve) => { this.#ended = resolve; });
  #channel = new MessageChannel();
  #reported = 0;
  #messages = '';
  #closed = false;

  /** Without `report` nobody hears of it before its end. */
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
    this.#ended(undefined);
  }

  // A message to ourselves is handled after those that wait.
  #next(): void {
    this.#channel.port2.postMessage(undefined);
  }

  #slice(): void {
    if (this.#closed) return;
    let more = false;
    let error = '';
    try {
      const step = this.session.advance(sliceMilliseconds);
      more = step.more;
      this.#messages += step.messages;
    } catch (thrown) {
      error = thrown instanceof Error ? thrown.message : String(thrown);
    }
    const now = performance.now();
    if (!more || now - this.#reported >= reportMilliseconds) {
      this.#reported = now;
      this.#tell(more, error);
    }
    if (more) this.#next();
  }

  #tell(more: boolean, error: string): void {
    const reading = {
      generation: this.#generation,
      about: this.session.about(),
      columns: this.session.columns,
      rowCount: this.session.rowCount,
      more,
      messages: this.#messages,
      done: more ? this.#done() : 1,
      error,
    };
    this.#report?.({ reading });
    if (!more) this.#ended(reading);
  }

  #done(): number {
    const size = this.#sources.reduce((sum, source) => sum + source.size, 0);
    const reached = this.#sources.reduce((sum, source) => sum + source.reached, 0);
    return size === 0 ? 0 : Math.min(1, reached / size);
  }
}
