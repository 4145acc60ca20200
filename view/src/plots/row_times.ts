// Finds rows by time, in the worker. Of each block of rows the first time is kept.
import type { Session } from 'biss';

/** Rows of a block; whatever is kept of all rows is kept by block. */
export const blockRows = 64;
/** Rows that are read at once. */
export const stretch = 65_536;

/** 64-bit integers as numbers, without an object for each. */
export function numbersOf(values: BigUint64Array | BigInt64Array | Float64Array): Float64Array {
  if (values instanceof Float64Array) return values;
  const halves = new Uint32Array(values.buffer, values.byteOffset, 2 * values.length);
  const signed = values instanceof BigInt64Array;
  const numbers = new Float64Array(values.length);
  for (let i = 0; i < values.length; i += 1) {
    const high = halves[2 * i + 1] ?? 0;
    numbers[i] = (signed ? high | 0 : high) * 4294967296 + (halves[2 * i] ?? 0);
  }
  return numbers;
}

/** The times of rows, in picoseconds. */
export function timesOf(session: Session, from: number, to: number): BigInt64Array {
  return session.column('time_ns', from, to).values as BigInt64Array;
}

/** The first row of each whole block. */
class BlockTimes {
  #times: number[] = [];

  constructor(private readonly session: Session) {}

  /** As many times as there are whole blocks by now. */
  get(): readonly number[] {
    const whole = Math.floor(this.session.rowCount / blockRows);
    while (this.#times.length < whole) {
      const first = this.#times.length * blockRows;
      const end = Math.min(first + stretch, whole * blockRows);
      const times = numbersOf(timesOf(this.session, first, end));
      for (let i = 0; i < times.length; i += blockRows) this.#times.push(times[i] ?? 0);
    }
    return this.#times;
  }
}

const kept = new WeakMap<Session, BlockTimes>();

export function blockTimes(session: Session): readonly number[] {
  let times = kept.get(session);
  if (times === undefined) {
    times = new BlockTimes(session);
    kept.set(session, times);
  }
  return times.get();
}

/** The first index for which `test` is true; `test` is false before it and true from there on. */
export function firstWhere(count: number, test: (index: number) => boolean): number {
  let low = 0;
  let high = count;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (test(middle)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** The first row that begins at or after `time`; the number of rows where there is none. */
export function rowFrom(session: Session, time: bigint): number {
  const blocks = blockTimes(session);
  const sought = Number(time);
  // A number is not as exact as a time: one block more on both sides.
  const block = firstWhere(blocks.length, (i) => (blocks[i] ?? 0) >= sought);
  const first = Math.max(0, block - 2) * blockRows;
  const end = Math.min(session.rowCount, (block + 2) * blockRows);
  const times = timesOf(session, first, end);
  return first + firstWhere(times.length, (i) => (times[i] ?? 0n) >= time);
}

/** Rows that are seen from `from` to `to`: the one that has begun before included. */
export function rowsIn(session: Session, from: bigint, to: bigint): { first: number; end: number } {
  const first = Math.max(0, rowFrom(session, from + 1n) - 1);
  return { first, end: Math.max(first, rowFrom(session, to)) };
}
