// How many cycles have each status, flag, limit and verdict, and when; in the worker.
import type { ColumnValues, Session } from 'biss';
import { stretch, timesOf } from './row_times';

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

  add(column: string, name: string, bin: number): void {
    const key = `${column} ${name}`;
    let cause = this.#found.get(key);
    if (cause === undefined) {
      cause = { column, name, count: 0, over: new Uint32Array(this.bins) };
      this.#found.set(key, cause);
    }
    cause.count += 1;
    cause.over[bin] = (cause.over[bin] ?? 0) + 1;
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
  const names = session.columns.map(({ name }) => name);
  const read = names.filter((name) =>
    /^(status|limits|safety|marginal|n[EW]\d*|crc\d*_ok)$/.test(name));
  const begin = rows === 0 ? 0n : timesOf(session, 0, 1)[0] ?? 0n;
  const length = rows === 0 ? 1 : Number((timesOf(session, rows - 1, rows)[0] ?? 0n) - begin) + 1;
  for (let first = 0; first < rows; first += stretch) {
    const end = Math.min(first + stretch, rows);
    const times = timesOf(session, first, end);
    const bin = Uint16Array.from(times, (time) => Math.floor((Number(time - begin) / length) * bins));
    for (const name of read) countColumn(counter, name, session.column(name, first, end), bin);
  }
  return { rows, causes: counter.sorted(names) };
}

function countColumn(counter: Counter, name: string, column: ColumnValues, bin: Uint16Array): void {
  const { kind, present, values, texts } = column;
  const bad = name === 'marginal' ? 1n : 0n;
  for (let i = 0; i < present.length; i += 1) {
    if (present[i] === 0) continue;
    if (kind === 'text') {
      const text = texts[Number(values[i])] ?? '';
      for (const one of text === '' ? [] : text.split(';')) counter.add(name, one, bin[i] ?? 0);
    } else if (values[i] === bad) {
      counter.add(name, bad === 1n ? name : `${name}=0`, bin[i] ?? 0);
    }
  }
}
