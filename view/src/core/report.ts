// What a report knows of a capture of which it has a part; cli/report/part.cpp writes it. The part is a
// capture of its own; its rows are known by their times.
import type { Access, ColumnValues, Cycle, RunResult, Session } from 'biss';
import type { Causes } from '../plots/causes_of';
import type { Envelope, EnvelopeAsk } from '../plots/envelope';
import type { Settings } from '../state';

/** `null` where there is no value. */
interface Extremes {
  low: (number | null)[];
  high: (number | null)[];
}

export interface Report {
  name: string;
  /** With other ones everything that is shown is that of the part. */
  settings: Settings;
  /** Request cycles of the whole capture, and those that failed. */
  cycles: number;
  failed: number;
  /** What the part contains and what was left out, a sentence each. */
  notes: string[];
  summary: string;
  /** What verbs say of the whole capture. */
  verbs: Record<string, { status: RunResult['status']; out: string; err: string }>;
  envelope: { from: string; rows: number; times: number[]; columns: Record<string, Extremes> };
  causes: { rows: number; causes: { column: string; name: string; count: number; over: number[] }[] };
  rows: {
    /** Of the rows that the part shows as the whole capture does, in picoseconds. */
    times: string[];
    numbers: number[];
    /** What the part alone does not give: place of the row, column, text as in the CSV. */
    cells: [number, string, string][];
  };
}

/** The values of a column over the whole capture; undefined where the report does not have it. */
export function wholeEnvelope(report: Report, { column, from, to }: EnvelopeAsk): Envelope | undefined {
  const { envelope } = report;
  const values = envelope.columns[column];
  if (values === undefined) return undefined;
  const shift = Number(BigInt(envelope.from) - from);
  const length = Number(to - from);
  const { times } = envelope;
  let first = 0;
  while (first + 1 < times.length && (times[first + 1] ?? 0) + shift <= 0) first += 1;
  let end = first;
  while (end < times.length && (times[end] ?? 0) + shift <= length) end += 1;
  const numbers = (all: (number | null)[]) =>
    Float64Array.from(all.slice(first, end + 1), (value) => value ?? NaN);
  return {
    from,
    times: Float64Array.from(times.slice(first, end + 1), (time) => time + shift),
    low: numbers(values.low),
    high: numbers(values.high),
    rows: envelope.rows,
  };
}

export function wholeCauses({ causes }: Report): Causes {
  return {
    rows: causes.rows,
    causes: causes.causes.map((cause) => ({ ...cause, over: Uint32Array.from(cause.over) })),
  };
}

type Values = ColumnValues['values'];

/** The rows of the part that are those of the whole capture, with the numbers that they have there. */
export class PartSession implements Session {
  #places = new Map<bigint, number>();
  #cells = new Map<string, string>();
  // Of each row: its row in the part, and its place in the report.
  #rows: number[] = [];
  #place: number[] = [];
  #looked = 0;
  #known: readonly Access[] | undefined;
  #ends = new Map<number, bigint | undefined>();

  /** \param isWhole the settings are those of the report */
  constructor(private readonly part: Session, readonly report: Report, readonly isWhole: boolean) {
    report.rows.times.forEach((time, place) => this.#places.set(BigInt(time), place));
    if (!isWhole) return;
    for (const [place, column, text] of report.rows.cells) this.#cells.set(`${place} ${column}`, text);
  }

  advance(milliseconds: number): { more: boolean; messages: string } {
    const { more, messages } = this.part.advance(milliseconds);
    const end = this.part.rowCount;
    const { values } = this.part.column('time_ns', this.#looked, end);
    for (let i = 0; i < end - this.#looked; i += 1) {
      const place = this.#places.get(BigInt(values[i] ?? 0));
      if (place === undefined) continue;
      this.#rows.push(this.#looked + i);
      this.#place.push(place);
    }
    this.#looked = end;
    return { more, messages: this.isWhole ? '' : messages };
  }

  about() {
    const about = this.part.about();
    return {
      ...about,
      cycles: this.isWhole ? this.report.cycles : this.rowCount,
      accesses: this.isWhole ? this.#accesses().length : 0,
    };
  }

  // Those of the part are broken off where cycles are missing.
  #accesses(): readonly Access[] {
    this.#known ??= (this.report.verbs['registers']?.out ?? '').split('\n')
      .filter((line) => line !== '').map((line) => JSON.parse(line) as Access);
    return this.#known;
  }

  accesses(from: number, to: number): Access[] {
    if (!this.isWhole) return [];
    return this.#accesses().filter(({ cycle, cycles }) => cycle < to && cycle + Math.max(1, cycles) > from);
  }

  get columns() {
    return this.part.columns;
  }

  get rowCount(): number {
    return this.#rows.length;
  }

  csv(from: number, to: number): string {
    const rows = this.cells(from, to).map((cells) => `${cells.join(',')}\n`);
    return `${this.part.csv(0, 0)}${rows.join('')}`;
  }

  cells(from: number, to: number): string[][] {
    return this.#rows.slice(from, to).map((row, i) => {
      const place = this.#place[from + i] ?? 0;
      const cells = this.part.cells(row, row + 1)[0] ?? [];
      return cells.map((cell, k) => {
        const { name = '' } = this.columns[k] ?? {};
        if (name === 'cycle') return String(this.report.rows.numbers[place] ?? '');
        return this.#cells.get(`${place} ${name}`) ?? cell;
      });
    });
  }

  column(name: string, from: number, to: number): ColumnValues {
    const rows = this.#rows.slice(from, to);
    const first = rows[0] ?? 0;
    const all = this.part.column(name, first, (rows.at(-1) ?? first - 1) + 1);
    const present = Uint8Array.from(rows, (row) => all.present[row - first] ?? 0);
    const values = valuesLike(all.values, rows.length);
    const texts = [...all.texts];
    rows.forEach((row, i) => {
      const place = this.#place[from + i] ?? 0;
      if (all.values.length > 0) values[i] = all.values[row - first]!;
      if (name === 'cycle') values[i] = BigInt(this.report.rows.numbers[place] ?? 0);
      const text = this.#cells.get(`${place} ${name}`);
      if (text === undefined) return;
      present[i] = text === '' ? 0 : 1;
      if (all.kind === 'real') values[i] = Number(text);
      if (all.kind === 'text') values[i] = BigInt(texts.push(text) - 1);
    });
    return { ...all, present, values, texts };
  }

  view(line: 'ma' | 'slo', from: bigint, to: bigint, columns: number) {
    return this.part.view(line, from, to, columns);
  }

  summary(): string {
    return this.isWhole ? this.report.summary : this.part.summary();
  }

  cycle(row: number): Cycle | undefined {
    const cycle = this.part.cycle(this.#rows[row] ?? 0);
    if (cycle === undefined) return undefined;
    const number = this.report.rows.numbers[this.#place[row] ?? 0] ?? 0;
    const title = cycle.title.replace(/\bcycle \d+/, `cycle ${number}`);
    return { ...cycle, number, title };
  }

  /** Where the line is not known after a row. */
  endBeforeGap(row: number): bigint | undefined {
    const number = (at: number) => this.report.rows.numbers[this.#place[at] ?? NaN];
    if (number(row + 1) === (number(row) ?? NaN) + 1) return undefined;
    if (!this.#ends.has(row)) {
      const end = this.part.cycle(this.#rows[row] ?? 0)?.end;
      this.#ends.set(row, end === undefined ? undefined : BigInt(end));
    }
    return this.#ends.get(row);
  }

  close(): void {
    this.part.close();
  }
}

// Typed arrays of both kinds, written alike.
function valuesLike(values: Values, length: number): Values & Record<number, bigint | number> {
  const made = values instanceof Float64Array ? new Float64Array(length)
    : values instanceof BigInt64Array ? new BigInt64Array(length) : new BigUint64Array(length);
  return made as Values & Record<number, bigint | number>;
}
