// What the plots compute in the worker, beside the capture: values go in by column, envelopes come
// out. A function here sees the whole session and must stop at the rows it was given.
import type { Session } from 'biss';

/** The names of what can be asked by `client.ask('analyse.NAME', …)`. */
export interface Analyses {
  envelope: { ask: EnvelopeAsk; answer: Envelope };
}

export interface EnvelopeAsk {
  column: string;
  from: number;
  to: number;
  /** At most as many buckets. */
  points: number;
}

/** Lowest and highest value of each bucket of rows; NaN where a bucket has no value. */
export interface Envelope {
  /** Time of the first row of a bucket, in picoseconds. */
  times: Float64Array;
  low: Float64Array;
  high: Float64Array;
}

type Analysis<K extends keyof Analyses> = (
  session: Session,
  ask: Analyses[K]['ask'],
) => Analyses[K]['answer'];

export const analyses: { [K in keyof Analyses]: Analysis<K> } = {
  envelope,
};

// Rows are read in stretches, so that memory does not grow with the capture.
const stretch = 65_536;

function envelope(session: Session, { column, from, to, points }: EnvelopeAsk): Envelope {
  const count = Math.max(0, Math.min(to, session.rowCount) - from);
  const buckets = Math.min(points, count);
  const result: Envelope = {
    times: new Float64Array(buckets).fill(NaN),
    low: new Float64Array(buckets).fill(NaN),
    high: new Float64Array(buckets).fill(NaN),
  };
  for (let begin = from; begin < from + count; begin += stretch) {
    const end = Math.min(begin + stretch, from + count);
    const { present, values } = session.column(column, begin, end);
    const times = session.column('time_ns', begin, end).values;
    for (let i = 0; i < end - begin; i += 1) {
      const bucket = Math.floor(((begin + i - from) * buckets) / count);
      if (Number.isNaN(result.times[bucket])) result.times[bucket] = Number(times[i]);
      if (present[i] !== 0) widen(result, bucket, Number(values[i]));
    }
  }
  return result;
}

function widen(into: Envelope, bucket: number, value: number): void {
  const low = into.low[bucket] ?? NaN;
  const high = into.high[bucket] ?? NaN;
  if (!(low <= value)) into.low[bucket] = value;
  if (!(high >= value)) into.high[bucket] = value;
}
