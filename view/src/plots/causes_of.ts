// How many cycles have each status, flag, limit and verdict, and when; in the worker.
import type { Column, Session } from 'biss';
import { causesIn } from '../core/statuses';
import { numbersOf, stretch, timesOf } from './row_times';

export interface CausesAsk {
  /** Stretches of the capture that are counted each. */
  bins: number;
}

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

class Counter {
  readonly #found = new Map<string, Cause>();

  constructor(private readonly bins: number) {}

  /** Adds what was counted by bin. */
  add(column: string, name: string, over: Uint32Array): void {
    const key = `${column} ${name}`;
    let cause = this.#found.get(key);
    if (cause === undefined) {
      cause = { column, name, count: 0, over: new Uint32Array(this.bins) };
      this.#found.set(key, cause);
    }
    for (let bin = 0; bin < over.length; bin += 1) {
      cause.count += over[bin] ?? 0;
      cause.over[bin] = (cause.over[bin] ?? 0) + (over[bin] ?? 0);
    }
  }

  /** By column in the order of the table, and within it the most frequent one first. */
  sorted(columns: readonly string[]): Cause[] {
    return [...this.#found.values()].sort((a, b) =>
      columns.indexOf(a.column) - columns.indexOf(b.column) || b.count - a.count);
  }
}

export function causes(session: Session, { bins }: CausesAsk): Causes {
  const counter = new Counter(bins);
  const rows = session.rowCount;
  const read = session.columns.filter(({ role }) => role !== 'value');
  const begin = rows === 0 ? 0 : Number(timesOf(session, 0, 1)[0] ?? 0n);
  const last = rows === 0 ? 0 : Number(timesOf(session, rows - 1, rows)[0] ?? 0n);
  for (let first = 0; first < rows; first += stretch) {
    const end = Math.min(first + stretch, rows);
    const times = numbersOf(timesOf(session, first, end));
    const share = bins / Math.max(1, last - begin);
    const bin = Uint16Array.from(times, (time) => Math.min(bins - 1, (time - begin) * share));
    for (const column of read) countColumn(counter, session, column, first, end, bin, bins);
  }
  return { rows, causes: counter.sorted(read.map(({ name }) => name)) };
}

function countColumn(
  counter: Counter,
  session: Session,
  column: Column,
  first: number,
  end: number,
  bin: Uint16Array,
  bins: number,
): void {
  const counts: Uint32Array[] = [];
  const { present, values: exact, texts } = session.column(column.name, first, end);
  const values = numbersOf(exact);
  for (let i = 0; i < values.length; i += 1) {
    if (present[i] === 0) continue;
    const value = values[i] ?? 0;
    const over = (counts[value] ??= new Uint32Array(bins));
    const at = bin[i] ?? 0;
    over[at] = (over[at] ?? 0) + 1;
  }
  counts.forEach((over, value) => {
    for (const cause of causesIn(column, texts[value] ?? '')) counter.add(column.name, cause, over);
  });
}
