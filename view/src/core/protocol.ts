// The messages between the page and the worker. An answer has the number of its request.
import type { Column } from 'biss';
import type { Reader } from './reader';
import type { Handlers } from './worker';

export type RequestName = keyof Handlers;
/** The argument of a request; an empty object if it has none. */
export type Ask<K extends RequestName> =
  Parameters<Handlers[K]> extends [infer Asked] ? Asked : Record<string, never>;
export type Answer<K extends RequestName> = Awaited<ReturnType<Handlers[K]>>;

export interface Opened {
  generation: number;
  columns: readonly Column[];
  messages: string;
  /** Only for a capture that has been read to its end. */
  reading?: Reading;
}

export interface RequestMessage {
  id: number;
  name: RequestName;
  ask: unknown;
}

export interface AnswerMessage {
  id: number;
  answer?: unknown;
  /** The text of the thrown value. */
  error?: string;
  status?: number;
  /** The capture was closed before the request came. */
  isClosed?: boolean;
}

export type Reading = ReturnType<Reader['reading']>;

/** Sent by the worker without a request while it reads. */
export interface ReadingMessage {
  reading: Reading;
}
