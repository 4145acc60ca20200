// A column against time, as its lowest and highest values, in the worker.
import type { Session } from 'biss';
import type { Range } from '../state';
import { blockRows, blockTimes, cellsOf, keptByBlock, rowsIn, timesOf } from './row_times';

export interface EnvelopeAsk extends Range {
  column: string;
  /** The approximate maximum number of points. */
  points: number;
}

/** Lowest and highest value of a stretch of rows; NaN if it has no value. */
export interface Envelope {
  from: bigint;
  /** The time of the first row of each stretch, in picoseconds from `from`. */
  times: Float64Array;
  low: Float64Array;
  high: Float64Array;
  /** Rows of a stretch; 1: every value is there. */
  rows: number;
}

export interface Extremes {
  low: number;
  high: number;
}

const kept = new Map<string, (session: Session) => readonly Extremes[]>();

// Extremes of each whole block of a column.
function blocksOf(session: Session, column: string): readonly Extremes[] {
  const blocks = kept.get(column) ?? keptByBlock((of, first, end) =>
    groupsOf(cellsOf(of, column, first, end).numbers, blockRows).map((group) => extremes(group)));
  kept.set(column, blocks);
  return blocks(session);
}

function groupsOf(values: Float64Array, each: number): Float64Array[] {
  return Array.from({ length: Math.ceil(values.length / Math.max(1, each)) }, (_, i) =>
    values.subarray(i * each, (i + 1) * each));
}

/** The lowest number of `lows` and the highest one of `highs`; NaN without a number. */
export function extremes(lows: Iterable<number>, highs = lows): Extremes {
  let low = NaN;
  let high = NaN;
  for (const value of lows) if (value < low || Number.isNaN(low)) low = value;
  for (const value of highs) if (value > high || Number.isNaN(high)) high = value;
  return { low, high };
}

export function envelope(session: Session, ask: EnvelopeAsk): Envelope {
  const { first, end } = rowsIn(session, ask.from, ask.to);
  const last = Math.min(end + 1, session.rowCount);
  const each = Math.ceil((last - first) / Math.max(1, ask.points));
  if (each > blockRows) return ofBlocks(session, ask, first, last, each);
  const times = timesOf(session, first, last);
  const groups = groupsOf(cellsOf(session, ask.column, first, last).numbers, each);
  return answerOf(ask.from, each, groups.map((group) => extremes(group)), (i) => Number((times[i * each] ?? 0n) - ask.from));
}

function answerOf(from: bigint, rows: number, found: Extremes[], timeOf: (i: number) => number): Envelope {
  return {
    from,
    times: Float64Array.from(found, (_, i) => timeOf(i)),
    low: Float64Array.from(found, ({ low }) => low),
    high: Float64Array.from(found, ({ high }) => high),
    rows,
  };
}

function ofBlocks(session: Session, ask: EnvelopeAsk, first: number, last: number, each: number): Envelope {
  const times = blockTimes(session);
  const begin = Math.floor(first / blockRows);
  const blocks = blocksOf(session, ask.column).slice(begin, Math.ceil(last / blockRows));
  const step = Math.ceil(each / blockRows);
  const found = Array.from({ length: Math.ceil(blocks.length / step) }, (_, i) => {
    const joined = blocks.slice(i * step, (i + 1) * step);
    return extremes(joined.map(({ low }) => low), joined.map(({ high }) => high));
  });
  return answerOf(ask.from, step * blockRows, found, (i) => (times[begin + i * step] ?? 0) - Number(ask.from));
}
