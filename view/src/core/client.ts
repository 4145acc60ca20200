// The core from the page's side: a typed request to the worker, a promise for its answer.
import type { Answer, AnswerMessage, Ask, Reading, ReadingMessage, RequestMessage, RequestName } from './protocol';

/** An answer that failed, with the message of the command. */
export class CoreError extends Error {
  constructor(message: string, readonly status: number) {
    super(message);
    this.name = 'CoreError';
  }
}

/** A request that a newer one on the same lane replaced, or whose capture was closed. */
export class Superseded extends Error {
  constructor() {
    super('superseded');
    this.name = 'Superseded';
  }
}

// Requests that wait for their answers, of all workers.
let allWaiting = 0;
let whenAnswered: (isWaiting: boolean) => void = () => {};

/** Calls the function with whether any request waits, when that may have changed. */
export function watchWaiting(watch: (isWaiting: boolean) => void): void {
  whenAnswered = watch;
}

function addWaiting(count: number): void {
  allWaiting += count;
  whenAnswered(allWaiting > 0);
}

interface Waiting {
  lane: string | undefined;
  resolve: (answer: never) => void;
  reject: (error: Error) => void;
}

/**
 * Requests on a lane: one is under way, and of those that wait only the newest is sent; the others
 * are rejected with `Superseded`. Requests without a lane are all sent at once.
 */
export class Client {
  #worker: Worker;
  #nextId = 1;
  #waiting = new Map<number, Waiting>();
  // Lanes with a request under way, and the newest request that waits for its end.
  #lanes = new Map<string, RequestMessage | undefined>();
  /** Called while the worker reads. */
  onReading: (reading: Reading) => void = () => {};

  constructor(worker: Worker) {
    this.#worker = worker;
    worker.onmessage = (event: MessageEvent<AnswerMessage | ReadingMessage>) => {
      if ('reading' in event.data) this.onReading(event.data.reading);
      else this.#answered(event.data);
    };
    worker.onerror = (event) => this.#broken(event.message || 'the core has stopped');
  }

  ask<K extends RequestName>(name: K, ask: Ask<K>, { lane }: { lane?: string } = {}): Promise<Answer<K>> {
    const message: RequestMessage = { id: this.#nextId++, name, ask };
    const answer = new Promise<Answer<K>>((resolve, reject) => {
      this.#waiting.set(message.id, { lane, resolve, reject });
      addWaiting(1);
    });
    if (lane === undefined || !this.#lanes.has(lane)) this.#send(message, lane);
    else this.#queue(message, lane);
    return answer;
  }

  #send(message: RequestMessage, lane: string | undefined): void {
    if (lane !== undefined) this.#lanes.set(lane, undefined);
    this.#worker.postMessage(message);
  }

  #queue(message: RequestMessage, lane: string): void {
    const older = this.#lanes.get(lane);
    if (older !== undefined) this.#settle(older.id)?.reject(new Superseded());
    this.#lanes.set(lane, message);
  }

  #settle(id: number): Waiting | undefined {
    const found = this.#waiting.get(id);
    if (this.#waiting.delete(id)) addWaiting(-1);
    return found;
  }

  #answered({ id, answer, error, status, isClosed }: AnswerMessage): void {
    const settled = this.#settle(id);
    const lane = settled?.lane;
    if (lane !== undefined) {
      const next = this.#lanes.get(lane);
      this.#lanes.delete(lane);
      if (next !== undefined) this.#send(next, lane);
    }
    if (error === undefined) settled?.resolve(answer as never);
    else if (isClosed === true) settled?.reject(new Superseded());
    else settled?.reject(new CoreError(error, status ?? 3));
  }

  /** To be called when the worker has been ended: its promises never settle. */
  close(): void {
    addWaiting(-this.#waiting.size);
    this.#waiting.clear();
  }

  #broken(message: string): void {
    const all = [...this.#waiting.values()];
    this.close();
    this.#lanes.clear();
    all.forEach(({ reject }) => reject(new CoreError(message, 3)));
  }
}
