// Finds rows by time, in the worker, and keeps the results of blocks of rows.
import type { Session } from 'biss';
import { firstWhere } from '../core/first_where';

/** Rows of a block; the data about all rows are kept by block. */
export const blockRows = 64;
/** Rows that are read at once. */
export const stretch = 65_536;

/**
 * 64-bit integers as numbers, counted from `from`, without an object for each. Real numbers are
 * returned as they are, not counted from `from`.
 */
export function numbersOf(values: BigUint64Array | BigInt64Array | Float64Array, from = 0n): Float64Array {
  if (values instanceof Float64Array) return values;
  const halves = new Uint32Array(values.buffer, values.byteOffset, 2 * values.length);
  const signed = values instanceof BigInt64Array;
  const fromHigh = Number(from >> 32n);
  const fromLow = Number(BigInt.asUintN(32, from));
  const numbers = new Float64Array(values.length);
  for (let i = 0; i < values.length; i += 1) {
    const high = halves[2 * i + 1] ?? 0;
    numbers[i] = ((signed ? high | 0 : high) - fromHigh) * 4294967296 + ((halves[2 * i] ?? 0) - fromLow);
  }
  return numbers;
}

/** The values of a column as numbers, NaN for an empty cell, and the texts that they are indices of. */
export function cellsOf(session: Session, column: string, from: number, to: number) {
  const { present, values, texts } = session.column(column, from, to);
  const numbers = numbersOf(values);
  for (let i = 0; i < numbers.length; i += 1) if (present[i] === 0) numbers[i] = NaN;
  return { numbers, texts };
}

/** The times of rows, in picoseconds. */
export function timesOf(session: Session, from: number, to: number): BigInt64Array {
  return session.column('time_ns', from, to).values as BigInt64Array;
}

/**
 * Keeps a result for each whole block of a session. `blocksIn` makes the results of the blocks that have
 * been read since the last call, from their first row to before `end`.
 */
export function keptByBlock<T>(blocksIn: (session: Session, first: number, end: number) => T[]) {
  const kept = new WeakMap<Session, T[]>();
  return (session: Session): readonly T[] => {
    const blocks = kept.get(session) ?? [];
    kept.set(session, blocks);
    const whole = Math.floor(session.rowCount / blockRows);
    while (blocks.length < whole) {
      const first = blocks.length * blockRows;
      blocks.push(...blocksIn(session, first, Math.min(first + stretch, whole * blockRows)));
    }
    return blocks;
  };
}

/** The time of the first row of each whole block. */
export const blockTimes = keptByBlock((session, first, end) =>
  [...numbersOf(timesOf(session, first, end))].filter((_, i) => i % blockRows === 0));

/** The first row whose value in a column that never falls is at least this; else the number of rows. */
export function rowFrom(session: Session, least: bigint, column = 'time_ns'): number {
  return firstWhere(session.rowCount, (row) =>
    BigInt(session.column(column, row, row + 1).values[0] ?? 0) >= least);
}

/** Rows visible from `from` to `to`, including the row that began before. */
export function rowsIn(session: Session, from: bigint, to: bigint): { first: number; end: number } {
  const first = Math.max(0, rowFrom(session, from + 1n) - 1);
  return { first, end: Math.max(first, rowFrom(session, to)) };
}
