// The result of each row, for the strip of all cycles and the boxes of single ones; in the worker.
import type { Access, Column, Role, Session } from 'biss';
import { causesIn, cutStatuses, markOf } from '../core/statuses';
import type { Range } from '../state';
import { blockRows, blockTimes, cellsOf, keptByBlock, numbersOf, rowsIn, stretch, timesOf } from './row_times';

/** The class by which a row is drawn; the larger one is the worse. */
export const rowClass = { good: 0, cut: 1, flagged: 2, failed: 3 } as const;

/** Cycles that begin within each column of the screen. */
export interface Strip extends Range {
  rows: number;
  all: Uint32Array;
  failed: Uint32Array;
  flagged: Uint32Array;
}

export interface Row extends Range {
  row: number;
  /** The number of the cycle in the whole capture; a report has only a part of them. */
  number: number;
  class: number;
  status: string;
  safety: string;
  /** Flags that are set: `nE=0`, `marginal`, limits. */
  notes: string;
  position: string;
}

export interface Rows {
  count: number;
  /** Empty if there are too many rows. Each ends when the next one begins, or the line is no longer known. */
  rows: Row[];
  /** Accesses to registers, and commands, that take place in these rows. */
  accesses: Access[];
}

type Cells = Column & ReturnType<typeof cellsOf>;

function textOf(cells: Cells | undefined, i: number): string {
  return cells?.texts[cells.numbers[i] ?? NaN] ?? '';
}

// The results of rows, by their place after the first one.
function verdictsOf(session: Session, from: number, to: number) {
  const columns = session.columns.filter(({ role }) => role !== 'value' && role !== 'check_at_0')
    .map((column) => {
      const cells = cellsOf(session, column.name, from, to);
      return { ...column, ...cells, marks: cells.texts.map((text) => markOf(column.role, text)) };
    });
  const flags = columns.filter(({ role }) => role !== 'status');
  const status = columns.find(({ role }) => role === 'status')!;
  const classes = status.texts.map((text, k) =>
    (status.marks[k] !== '' ? rowClass.failed : cutStatuses.has(text) ? rowClass.cut : rowClass.good));
  return {
    classOf(i: number): number {
      const found = classes[status.numbers[i] ?? NaN] ?? rowClass.failed;
      if (found === rowClass.failed) return found;
      for (const { numbers, marks } of flags) if (marks[numbers[i] ?? NaN]) return rowClass.flagged;
      return found;
    },
    textOf: (wanted: Role, i: number) => textOf(columns.find(({ role }) => role === wanted), i),
    notes: (i: number) => flags.filter(({ role }) => role !== 'verdict')
      .flatMap((cells) => causesIn(cells, textOf(cells, i))).join(', '),
  };
}

// How many rows of each block failed and are flagged.
const blockCounts = keptByBlock((session, first, end) => {
  const verdicts = verdictsOf(session, first, end);
  return Array.from({ length: (end - first) / blockRows }, (_, block) => {
    const counts = { failed: 0, flagged: 0 };
    for (let i = block * blockRows; i < (block + 1) * blockRows; i += 1) {
      const found = verdicts.classOf(i);
      if (found === rowClass.failed) counts.failed += 1;
      else if (found === rowClass.flagged) counts.flagged += 1;
    }
    return counts;
  });
});

export function strip(session: Session, { from, to, columns }: Range & { columns: number }): Strip {
  const { first, end } = rowsIn(session, from, to);
  const answer: Strip = {
    from,
    to,
    rows: end - first,
    all: new Uint32Array(columns),
    failed: new Uint32Array(columns),
    flagged: new Uint32Array(columns),
  };
  const perPs = columns / Math.max(1, Number(to - from));
  const columnOf = (offset: number) =>
    Math.max(0, Math.min(columns - 1, Math.floor(offset * perPs)));
  const addRows = (begin: number, stop: number) => {
    const verdicts = verdictsOf(session, begin, stop);
    const times = timesOf(session, begin, stop);
    for (let i = 0; i < stop - begin; i += 1) {
      add(answer, columnOf(Number((times[i] ?? 0n) - from)), 1, verdicts.classOf(i));
    }
  };
  if (end - first <= stretch) addRows(first, end);
  else addBlocks(session, first, end, answer, (time) => columnOf(time - Number(from)), addRows);
  return answer;
}

function add(into: Strip, column: number, count: number, found: number): void {
  into.all[column] = (into.all[column] ?? 0) + count;
  if (found === rowClass.failed) into.failed[column] = (into.failed[column] ?? 0) + count;
  if (found === rowClass.flagged) into.flagged[column] = (into.flagged[column] ?? 0) + count;
}

// Whole blocks within a column are counted as such; others row by row.
function addBlocks(
  session: Session,
  first: number,
  end: number,
  into: Strip,
  columnOf: (time: number) => number,
  addRows: (begin: number, stop: number) => void,
): void {
  const times = blockTimes(session);
  const counts = blockCounts(session);
  let row = first;
  while (row < end) {
    const block = Math.floor(row / blockRows);
    const stop = Math.min(end, (block + 1) * blockRows);
    const next = times[block + 1];
    const column = columnOf(times[block] ?? 0);
    const whole = stop - row === blockRows && next !== undefined && columnOf(next) === column;
    if (whole) {
      const { failed, flagged } = counts[block]!;
      add(into, column, failed, rowClass.failed);
      add(into, column, flagged, rowClass.flagged);
      add(into, column, blockRows - failed - flagged, rowClass.good);
    } else {
      addRows(row, stop);
    }
    row = stop;
  }
}

/** A session of a part of a capture: between some rows the line is not known. */
interface WithGaps extends Session {
  /** The end of a row before such a gap. */
  endBeforeGap(row: number): bigint | undefined;
}

/** With more rows than `most` only their number is given. */
export function rows(session: Session & Partial<WithGaps>, { from, to, most }: Range & { most: number }): Rows {
  const { first, end } = rowsIn(session, from, to);
  const count = end - first;
  const stop = count > most ? first : end;
  const verdicts = verdictsOf(session, first, stop);
  const position = session.column('position', first, stop);
  const numbers = numbersOf(session.column('cycle', first, stop).values);
  const times = timesOf(session, first, stop + 1);
  const found = Array.from(numbers, (number, i): Row => ({
    row: first + i,
    number,
    from: times[i] ?? 0n,
    to: session.endBeforeGap?.(first + i) ?? times[i + 1] ?? BigInt(session.about().endTime),
    class: verdicts.classOf(i),
    status: verdicts.textOf('status', i),
    safety: verdicts.textOf('verdict', i),
    notes: verdicts.notes(i),
    position: position.present[i] === 1 ? String(position.values[i]) : '',
  }));
  const accesses = found.length === 0 ? [] : session.accesses(numbers[0] ?? 0, (numbers.at(-1) ?? 0) + 1);
  return { count, rows: found, accesses };
}
