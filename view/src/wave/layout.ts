/** A cycle as the core lays it out, with times as numbers: parts, sampling points, failures. */
import type { Cycle, CycleCheck, CyclePart } from 'biss';
import { exactTimeText, timeText } from './scale';

/** A stretch of a cycle with a name. */
export interface Part {
  kind: CyclePart['kind'];
  /** From the longest to the shortest: `ACK 3.2 µs, 32 clocks`, `ACK`. */
  texts: string[];
  from: bigint;
  to: bigint;
  wrong: boolean;
}

/** A bit with its sampling point. */
export interface Sample {
  at: bigint;
  level: 0 | 1 | undefined;
  name: string;
  /** It differs from the value that the received data need. */
  wrong: boolean;
  /** A flip of this bit alone would make the checksum right. */
  mends: boolean;
}

export interface CycleLayout {
  parts: Part[];
  /** Shown below the parts: the line delay and CDM, which never overlap. */
  below: Part[];
  samples: Sample[];
  failures: { at: bigint; text: string }[];
  period: bigint;
}

// The short text of a field: the value of a checksum or a flag, the name of data.
function shortText({ kind, text }: CyclePart): string {
  const [name = '', value = ''] = text.split(/[=,]/);
  return kind === 'crc' || kind === 'flag' ? value : name;
}

function partOf(part: CyclePart): Part {
  const { kind, text, brief = '', wrong } = part;
  const texts = [text, brief, shortText(part)].filter((each) => each !== '');
  texts.sort((a, b) => b.length - a.length);
  return { kind, texts, from: BigInt(part.from), to: BigInt(part.to), wrong };
}

// The flips that would make a wrong checksum right.
function mending(cycle: Cycle, { singles }: CycleCheck): string {
  const names = singles.slice(0, 4).map(([payload]) =>
    cycle.bits.find(({ payloadBit }) => payloadBit === payload)?.name ?? `bit ${payload}`);
  return names.length === 0 ? '' : `; corrected by a flip of ${names.join(' or ')}`;
}

export function layOut(cycle: Cycle): CycleLayout {
  const mends = new Set(cycle.checks.flatMap(({ singles }) => singles.map(([bit]) => bit)));
  const samples = cycle.bits
    .filter((bit) => bit.sampledAt !== undefined && bit.name !== '')
    .map((bit) => ({
      at: BigInt(bit.sampledAt ?? '0'),
      level: bit.level,
      name: bit.name,
      wrong: bit.expected !== undefined && bit.expected !== bit.level,
      mends: bit.payloadBit !== undefined && mends.has(bit.payloadBit),
    }));
  const { frame = [], delay = [], CDM = [] } = cycle.tracks;
  // A failure for each of them.
  const wrong = cycle.status === 'crc' ? cycle.checks.filter(({ right }) => !right) : [];
  return {
    parts: frame.map(partOf),
    below: [...delay, ...CDM].map(partOf),
    samples,
    failures: cycle.failures.map(({ time, text }, i) => {
      const check = wrong[i];
      return { at: BigInt(time), text: check === undefined ? text : `${text}${mending(cycle, check)}` };
    }),
    period: BigInt(cycle.period),
  };
}

/** The full text of a part. */
export function partText(part: Part): string {
  const length = timeText(part.to - part.from);
  return `${part.texts[0] ?? ''}, ${length} from ${exactTimeText(part.from)}`;
}
