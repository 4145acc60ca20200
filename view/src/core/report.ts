// The data of a report about a whole capture. The report contains only a part of the capture;
// verbs/report/part.cpp writes it. The part is a capture of its own; its rows are found by their times.
import type { Access, ColumnValues, Cycle, RunResult, Session } from 'biss';
import { firstWhere } from './first_where';
import { cellsOfCsv, objectsOf } from './texts';
import type { Causes } from '../plots/causes_of';
import type { Envelope, EnvelopeAsk } from '../plots/envelope';
import type { Settings } from '../state';

/** For each stretch of rows; `null`: there is no value. */
type Extremes = Record<'low' | 'high', (number | null)[]>;

export interface Report {
  name: string;
  /** With other settings the page shows results of the part only. */
  settings: Settings;
  /** Request cycles of the whole capture, and those that failed. */
  cycles: number;
  failed: number;
  /** The contents of the part and the data left out, one sentence each. */
  notes: string[];
  summary: string;
  /** Output of verbs for the whole capture. */
  verbs: Record<string, { status: RunResult['status']; out: string; err: string }>;
  envelope: { from: string; rows: number; times: number[]; columns: Record<string, Extremes> };
  causes: { rows: number; causes: { column: string; name: string; count: number; over: number[] }[] };
  /** Header and rows of the cycles in the part, as `biss decode --to csv` writes them. */
  rows: string;
}

/** The values of a column over the whole capture; undefined if the report does not have the column. */
export function wholeEnvelope(report: Report, { column, from, to }: EnvelopeAsk): Envelope | undefined {
  const { envelope } = report;
  const values = envelope.columns[column];
  if (values === undefined) return undefined;
  const shift = Number(BigInt(envelope.from) - from);
  const length = Number(to - from);
  const { times } = envelope;
  const after = (time: number) => firstWhere(times.length, (i) => (times[i] ?? 0) + shift > time);
  const first = Math.max(0, after(0) - 1);
  const end = Math.max(first, after(length));
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

// A time of the CSV, in nanoseconds with up to three decimals.
function picoseconds(text: string): bigint {
  const [whole = '', places = ''] = text.split('.');
  return BigInt(whole + places.padEnd(3, '0'));
}

/** The rows of the whole capture whose cycles are in the part; with other settings, the rows of the part. */
export class PartSession implements Session {
  #names: string[];
  // For each row of the report: its cells, and its index by its time.
  #cells: string[][];
  #places = new Map<bigint, number>();
  // For each row that is shown: its row in the part, and its index in the report.
  #rows: (number | undefined)[] = [];
  #place: number[] = [];
  #looked = 0;
  // The accesses are taken from the report: in the part, they are cut if cycles are missing.
  readonly #accesses: readonly Access[];
  #ends = new Map<number, bigint | undefined>();

  /** \param isWhole the settings are the same as in the report */
  constructor(private readonly part: Session, readonly report: Report, readonly isWhole: boolean) {
    const [names = [], ...cells] = cellsOfCsv(report.rows);
    this.#names = names;
    this.#cells = cells;
    this.#accesses = isWhole ? objectsOf<Access>(report.verbs['registers']?.out ?? '') : [];
    cells.forEach((_, place) => this.#places.set(picoseconds(this.#text(place, 'time_ns')), place));
  }

  #text(place: number, name: string): string {
    return this.#cells[place]?.[this.#names.indexOf(name)] ?? '';
  }

  #number(row: number): number {
    return Number(this.#text(this.#place[row] ?? NaN, 'cycle') || NaN);
  }

  advance(milliseconds: number): { more: boolean; messages: string } {
    const { more, messages } = this.part.advance(milliseconds);
    const end = this.part.rowCount;
    const { values } = this.part.column('time_ns', this.#looked, end);
    for (let i = 0; i < end - this.#looked; i += 1) {
      const place = this.#places.get(BigInt(values[i] ?? 0));
      if (place === undefined) continue;
      if (!this.isWhole) this.#place.push(place);
      this.#rows[this.isWhole ? place : this.#place.length - 1] = this.#looked + i;
    }
    this.#looked = end;
    if (this.isWhole && !more) this.#place = this.#cells.map((_, place) => place);
    return { more, messages: this.isWhole ? '' : messages };
  }

  about() {
    const about = this.part.about();
    return {
      ...about,
      cycles: this.isWhole ? this.report.cycles : this.rowCount,
      accesses: this.#accesses.length,
    };
  }

  accesses(from: number, to: number): Access[] {
    return this.#accesses.filter(({ cycle, cycles }) => cycle < to && cycle + Math.max(1, cycles) > from);
  }

  get columns() {
    return this.part.columns;
  }

  get rowCount(): number {
    return this.#place.length;
  }

  csv(from: number, to: number): string {
    const rows = this.cells(from, to).map((cells) => `${cells.join(',')}\n`);
    return `${this.part.csv(0, 0)}${rows.join('')}`;
  }

  cells(from: number, to: number): string[][] {
    return this.#place.slice(from, to).map((place, i) => {
      if (this.isWhole) return this.#cells[place] ?? [];
      const row = this.#rows[from + i] ?? 0;
      const cells = this.part.cells(row, row + 1)[0] ?? [];
      return cells.map((cell, k) => (this.columns[k]?.name === 'cycle' ? this.#text(place, 'cycle') : cell));
    });
  }

  column(name: string, from: number, to: number): ColumnValues {
    const column = this.columns.findIndex((each) => each.name === name);
    const { kind } = this.columns[column] ?? {};
    if (kind === undefined) throw new RangeError(`no column ${name}`);
    const cells = this.cells(from, to).map((row) => row[column] ?? '');
    const present = Uint8Array.from(cells, (text) => (text === '' ? 0 : 1));
    if (kind === 'bits') return { kind, present, values: new BigUint64Array(0), texts: [] };
    if (kind === 'real') return { kind, present, values: Float64Array.from(cells, Number), texts: [] };
    const texts = kind === 'text' ? [...new Set(cells)] : kind === 'flag' ? ['0', '1'] : [];
    const valueOf = kind === 'text' ? (text: string) => BigInt(texts.indexOf(text))
      : kind === 'time' ? picoseconds : BigInt;
    const Type = kind === 'time' || kind === 'signed' ? BigInt64Array : BigUint64Array;
    const values = new Type(cells.length);
    cells.forEach((text, i) => { if (text !== '') values[i] = valueOf(text); });
    return { kind, present, values, texts };
  }

  view(line: 'ma' | 'slo', from: bigint, to: bigint, columns: number) {
    return this.part.view(line, from, to, columns);
  }

  summary(): string {
    return this.isWhole ? this.report.summary : this.part.summary();
  }

  cycle(row: number): Cycle | undefined {
    const inPart = this.#rows[row];
    return inPart === undefined ? undefined : this.part.cycle(inPart, this.#number(row));
  }

  /** The time from which the line is not known after a row; undefined if the next row follows at once. */
  endBeforeGap(row: number): bigint | undefined {
    if (this.#number(row + 1) === this.#number(row) + 1) return undefined;
    if (!this.#ends.has(row)) {
      const end = this.cycle(row)?.end;
      this.#ends.set(row, end === undefined ? undefined : BigInt(end));
    }
    return this.#ends.get(row);
  }

  close(): void {
    this.part.close();
  }
}
