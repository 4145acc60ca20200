// How many cycles have each status, flag, limit and verdict, and when; in the worker.
import type { Session } from 'biss';
import { causesIn } from '../core/statuses';
import { cellsOf, numbersOf, stretch, timesOf } from './row_times';

export interface Cause {
  /** The column that has it. */
  column: string;
  /** `crc`, `nE=0`, `clock_max`. */
  name: string;
  /** A condition of the search. */
  count: number;
  /** By stretch of the capture. */
  over: Uint32Array;
}

export interface Causes {
  rows: number;
  causes: Cause[];
}

/** \param bins stretches of the capture that are counted each */
export function causes(session: Session, { bins }: { bins: number }): Causes {
  const rows = session.rowCount;
  const counted = session.columns.filter(({ role }) => role !== 'value')
    .map((column) => ({ column, found: new Map<string, Cause>() }));
  const timeOf = (row: number) => Number(timesOf(session, row, row + 1)[0] ?? 0n);
  const begin = timeOf(0);
  const share = bins / Math.max(1, timeOf(rows - 1) - begin);
  for (let first = 0; first < rows; first += stretch) {
    const end = Math.min(first + stretch, rows);
    const times = numbersOf(timesOf(session, first, end));
    const binOf = Uint16Array.from(times, (time) => Math.min(bins - 1, (time - begin) * share));
    for (const { column, found } of counted) {
      const { numbers, texts } = cellsOf(session, column.name, first, end);
      const causesOf = texts.map((text) => causesIn(column, text).map((name) => {
        const cause = found.get(name) ?? { column: column.name, name, count: 0, over: new Uint32Array(bins) };
        return found.set(name, cause).get(name)!;
      }));
      numbers.forEach((value, i) => causesOf[value]?.forEach((cause) => {
        cause.count += 1;
        cause.over[binOf[i] ?? 0]! += 1;
      }));
    }
  }
  // By column in the order of the table, and within it the most frequent one first.
  const sorted = counted.map(({ found }) =>
    [...found.values()].filter(({ count }) => count > 0).sort((a, b) => b.count - a.count));
  return { rows, causes: sorted.flat() };
}
