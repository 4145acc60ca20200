// The core from the page's side: a typed request to the worker, a promise for its answer.
import type { AnswerMessage, ReadingMessage, RequestMessage, RequestName, Requests } from './protocol';

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

/** Calls with whether any request waits, when that may have changed. */
export function watchWaiting(watch: (isWaiting: boolean) => void): void {
  whenAnswered = watch;
}

function addWaiting(count: number): void {
  allWaiting += count;
  whenAnswered(allWaiting > 0);
}

interface Waiting {
  resolve: (answer: never) => void;
  reject: (error: Error) => void;
}

interface Queued {
  message: RequestMessage;
  transfer: Transferable[];
}

/**
 * Requests on a lane: one is under way, and of those that wait only the newest is sent; the others
 * are rejected with `Superseded`. Requests without a lane are all sent at once.
 */
export class Client {
  #worker: Worker;
  #nextId = 1;
  #waiting = new Map<number, Waiting>();
  #busy = new Map<string, number>();
  #queued = new Map<string, Queued>();
  #laneOf = new Map<number, string>();
  /** Called as the worker reads on. */
  onReading: (reading: ReadingMessage['reading']) => void = () => {};

  constructor(worker: Worker) {
    this.#worker = worker;
    worker.onmessage = (event: MessageEvent<AnswerMessage | ReadingMessage>) => {
      if ('reading' in event.data) this.onReading(event.data.reading);
      else this.#answered(event.data);
    };
    worker.onerror = (event) => this.#broken(event.message || 'the core has stopped');
  }

  ask<K extends RequestName>(
    name: K,
    ask: Requests[K]['ask'],
    options: { lane?: string; transfer?: Transferable[] } = {},
  ): Promise<Requests[K]['answer']> {
    const id = this.#nextId++;
    const message: RequestMessage = { id, name, ask };
    const answer = new Promise<Requests[K]['answer']>((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      addWaiting(1);
    });
    const { lane, transfer = [] } = options;
    if (lane === undefined) this.#worker.postMessage(message, transfer);
    else this.#queue(lane, { message, transfer });
    return answer;
  }

  #queue(lane: string, queued: Queued): void {
    this.#laneOf.set(queued.message.id, lane);
    if (!this.#busy.has(lane)) {
      this.#send(lane, queued);
      return;
    }
    const older = this.#queued.get(lane);
    if (older !== undefined) this.#settle(older.message.id)?.reject(new Superseded());
    this.#queued.set(lane, queued);
  }

  #send(lane: string, { message, transfer }: Queued): void {
    this.#busy.set(lane, message.id);
    this.#worker.postMessage(message, transfer);
  }

  #settle(id: number): Waiting | undefined {
    const found = this.#waiting.get(id);
    if (this.#waiting.delete(id)) addWaiting(-1);
    this.#laneOf.delete(id);
    return found;
  }

  #answered({ id, answer, error, status, isClosed }: AnswerMessage): void {
    const lane = this.#laneOf.get(id);
    const settled = this.#settle(id);
    if (lane !== undefined) {
      this.#busy.delete(lane);
      const next = this.#queued.get(lane);
      this.#queued.delete(lane);
      if (next !== undefined) this.#send(lane, next);
    }
    if (error === undefined) settled?.resolve(answer as never);
    else if (isClosed === true) settled?.reject(new Superseded());
    else settled?.reject(new CoreError(error, status ?? 3));
  }

  /** Of a worker that has been ended: its promises never settle. */
  close(): void {
    addWaiting(-this.#waiting.size);
    this.#waiting.clear();
  }

  #broken(message: string): void {
    const all = [...this.#waiting.values()];
    this.close();
    this.#busy.clear();
    this.#queued.clear();
    this.#laneOf.clear();
    all.forEach(({ reject }) => reject(new CoreError(message, 3)));
  }
}
