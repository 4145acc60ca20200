// A column against time, as its lowest and highest values, in the worker.
import type { Session } from 'biss';
import { blockRows, blockTimes, numbersOf, rowsIn, stretch, timesOf } from './row_times';

export interface EnvelopeAsk {
  column: string;
  from: bigint;
  to: bigint;
  /** About as many points at most. */
  points: number;
}

/** Lowest and highest value of a stretch of rows; NaN where it has no value. */
export interface Envelope {
  from: bigint;
  /** Of the first row of the stretch, in picoseconds from `from`. */
  times: Float64Array;
  low: Float64Array;
  high: Float64Array;
  /** Rows of a stretch; 1: every value is there. */
  rows: number;
}

interface Extremes {
  low: number[];
  high: number[];
}

const kept = new WeakMap<Session, Map<string, Extremes>>();

// Extremes of each whole block of a column.
function blocksOf(session: Session, column: string): Extremes {
  let columns = kept.get(session);
  if (columns === undefined) kept.set(session, (columns = new Map()));
  let blocks = columns.get(column);
  if (blocks === undefined) columns.set(column, (blocks = { low: [], high: [] }));
  const whole = Math.floor(session.rowCount / blockRows);
  while (blocks.low.length < whole) {
    const first = blocks.low.length * blockRows;
    const end = Math.min(first + stretch, whole * blockRows);
    const values = present(session, column, first, end);
    for (let i = 0; i < values.length; i += blockRows) {
      const { low, high } = extremes(values.subarray(i, i + blockRows));
      blocks.low.push(low);
      blocks.high.push(high);
    }
  }
  return blocks;
}

// Values as numbers, NaN where a cell is empty.
function present(session: Session, column: string, from: number, to: number): Float64Array {
  const { present: has, values } = session.column(column, from, to);
  const numbers = numbersOf(values);
  for (let i = 0; i < numbers.length; i += 1) if (has[i] === 0) numbers[i] = NaN;
  return numbers;
}

function extremes(values: Float64Array): { low: number; high: number } {
  let low = NaN;
  let high = NaN;
  for (const value of values) {
    if (!(value >= low)) low = value < low || Number.isNaN(low) ? value : low;
    if (!(value <= high)) high = value > high || Number.isNaN(high) ? value : high;
  }
  return { low, high };
}

export function envelope(session: Session, ask: EnvelopeAsk): Envelope {
  const { first, end } = rowsIn(session, ask.from, ask.to);
  const last = Math.min(end + 1, session.rowCount);
  const each = Math.ceil((last - first) / Math.max(1, ask.points));
  if (each > blockRows) return ofBlocks(session, ask, first, last, each);
  const groups = Math.ceil((last - first) / Math.max(1, each));
  const answer = empty(ask.from, groups, each);
  const values = present(session, ask.column, first, last);
  const times = timesOf(session, first, last);
  for (let i = 0; i < groups; i += 1) {
    const { low, high } = extremes(values.subarray(i * each, (i + 1) * each));
    answer.times[i] = Number((times[i * each] ?? 0n) - ask.from);
    answer.low[i] = low;
    answer.high[i] = high;
  }
  return answer;
}

function empty(from: bigint, count: number, rows: number): Envelope {
  return {
    from,
    times: new Float64Array(count),
    low: new Float64Array(count),
    high: new Float64Array(count),
    rows,
  };
}

function ofBlocks(session: Session, ask: EnvelopeAsk, first: number, last: number, each: number): Envelope {
  const blocks = blocksOf(session, ask.column);
  const times = blockTimes(session);
  const begin = Math.floor(first / blockRows);
  const end = Math.min(blocks.low.length, Math.ceil(last / blockRows));
  const step = Math.ceil(each / blockRows);
  const answer = empty(ask.from, Math.ceil((end - begin) / step), step * blockRows);
  const from = Number(ask.from);
  for (let i = 0; i < answer.times.length; i += 1) {
    const at = begin + i * step;
    const stop = Math.min(at + step, end);
    answer.times[i] = (times[at] ?? 0) - from;
    answer.low[i] = extremes(Float64Array.from(blocks.low.slice(at, stop))).low;
    answer.high[i] = extremes(Float64Array.from(blocks.high.slice(at, stop))).high;
  }
  return answer;
}
