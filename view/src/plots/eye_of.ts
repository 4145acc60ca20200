// SLO around the sampling points of a sample of cycles, in the worker.
import type { Cycle, Session } from 'biss';
import type { Range } from '../state';
import { numbersOf, rowsIn } from './row_times';

/** The bins go from one period before the sampling point to one period after it. */
export interface Eye {
  from: bigint;
  /** Mean period of MA in picoseconds; 0 if nothing was sampled. */
  period: number;
  samples: number;
  /** Samples with SLO high or low in the bin. */
  high: Uint32Array;
  low: Uint32Array;
  rising: Uint32Array;
  falling: Uint32Array;
  /** For each cycle examined: its row, its time from `from`, the least distance of a change of SLO from a
   * sampling point, in picoseconds, and the period of MA. */
  rows: Int32Array;
  times: Float64Array;
  margins: Float64Array;
  periods: Float64Array;
  /** The least distances of all, before and after the sampling point; NaN without a change. */
  before: number;
  after: number;
  /** The number of rows in the stretch; the cycles are a sample of them. */
  of: number;
}

type Sampled = NonNullable<ReturnType<typeof sampledOf>>;

// A stretch of SLO shorter than a part of this many is one busy entry.
const viewColumns = 16_384;

/**
 * \param cycles the maximum number of cycles to examine, evenly spread
 * \param bins the number of bins in the two periods around the sampling point
 */
export function eye(session: Session, { from, to, cycles, bins }: Range & { cycles: number; bins: number }): Eye {
  const { first, end } = rowsIn(session, from, to);
  const step = Math.max(1, (end - first) / Math.max(1, cycles));
  const sampled: Sampled[] = [];
  for (let at = first; at < end; at += step) {
    const row = Math.floor(at);
    const cycle = session.cycle(row);
    const one = cycle === undefined ? undefined : sampledOf(session, row, cycle, from);
    if (one !== undefined) sampled.push(one);
  }
  const periods = Float64Array.from(sampled, ({ period }) => period);
  const answer: Eye = {
    from,
    period: periods.length === 0 ? 0 : periods.reduce((sum, each) => sum + each, 0) / periods.length,
    samples: 0,
    high: new Uint32Array(bins),
    low: new Uint32Array(bins),
    rising: new Uint32Array(bins),
    falling: new Uint32Array(bins),
    rows: Int32Array.from(sampled, ({ row }) => row),
    times: Float64Array.from(sampled, ({ time }) => time),
    margins: new Float64Array(sampled.length).fill(NaN),
    periods,
    before: NaN,
    after: NaN,
    of: end - first,
  };
  sampled.forEach((one, i) => {
    answer.margins[i] = addCycle(answer, one);
  });
  return answer;
}

// Sampling points, changes of SLO and the levels after them, from the start of the cycle.
function sampledOf(session: Session, row: number, cycle: Cycle, from: bigint) {
  const bits = cycle.bits.filter((bit) => bit.sampledAt !== undefined && bit.name !== '');
  const firstBit = bits[0];
  const lastBit = bits[bits.length - 1];
  if (firstBit === undefined || lastBit === undefined || bits.length < 3) return undefined;
  const start = BigInt(cycle.time);
  const period = Number(BigInt(lastBit.time) - BigInt(firstBit.time)) /
    (lastBit.clock - firstBit.clock);
  const { times, levels } = session.view('slo', start, BigInt(cycle.end) + 1n, viewColumns);
  const points = Float64Array.from(bits, (bit) => Number(BigInt(bit.sampledAt ?? '0') - start));
  return { row, time: Number(start - from), period, points, changes: numbersOf(times, start), levels };
}

// Returns the least distance of a change from a sampling point.
function addCycle(into: Eye, sampled: Sampled): number {
  const { points, changes, levels, period } = sampled;
  let least = NaN;
  let next = 0;
  for (const point of points) {
    while (next < changes.length && (changes[next] ?? 0) <= point - period) next += 1;
    into.samples += 1;
    addLevels(into, point, sampled, Math.max(0, next - 1));
    for (let i = Math.max(1, next); i < changes.length; i += 1) {
      const distance = (changes[i] ?? 0) - point;
      if (distance >= period) break;
      if (levels[i] === levels[i - 1]) continue;
      addChange(into, distance / period, levels[i] ?? 2);
      const size = Math.abs(distance);
      if (!(least <= size)) least = size;
      if (distance <= 0 && !(into.before <= size)) into.before = size;
      if (distance > 0 && !(into.after <= size)) into.after = size;
    }
  }
  return least;
}

function addChange(into: Eye, place: number, level: number): void {
  const bin = Math.min(into.high.length - 1, Math.floor(((place + 1) / 2) * into.high.length));
  if (level !== 0) into.rising[bin] = (into.rising[bin] ?? 0) + 1;
  if (level !== 1) into.falling[bin] = (into.falling[bin] ?? 0) + 1;
}

function addLevels(into: Eye, point: number, { changes, levels, period }: Sampled, first: number): void {
  const bins = into.high.length;
  const width = (2 * period) / bins;
  let at = first;
  for (let bin = 0; bin < bins; bin += 1) {
    const time = point - period + (bin + 0.5) * width;
    while (at + 1 < changes.length && (changes[at + 1] ?? 0) <= time) at += 1;
    const level = levels[at] ?? 2;
    if (level === 1) into.high[bin] = (into.high[bin] ?? 0) + 1;
    if (level === 0) into.low[bin] = (into.low[bin] ?? 0) + 1;
  }
}
