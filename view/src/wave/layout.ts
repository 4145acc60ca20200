/** A cycle as parts beside one another, by name and value, and where it fails and why. */
import type { Cycle, CycleBit } from 'biss';
import { harmlessStatuses, statuses } from '../core/statuses';
import { exactTimeText, timeText } from './scale';

export type PartKind = 'frame' | 'data' | 'flag' | 'crc';

/** A stretch of a cycle with a name. */
export interface Part {
  kind: PartKind;
  /** Of a field of the format: `pos`, `crc.2`. */
  field?: string;
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
  /** It differs from what the data received need. */
  wrong: boolean;
  /** A flip of this bit alone would mend the checksum. */
  mends: boolean;
}

export interface CycleLayout {
  parts: Part[];
  samples: Sample[];
  failures: { at: bigint; text: string }[];
  lastEdge: bigint;
  period: bigint;
}

/** What the table knows of the row. Picoseconds, NaN where a cell is empty. */
export interface RowTimes {
  lineDelay: number;
  ack: number;
}

/** Empty for a status that is no failure of the transmission. */
export function causeOf(status: string): string {
  const harmless = harmlessStatuses.has(status) && !status.startsWith('cut');
  return harmless ? '' : statuses[status] ?? status;
}

// `pos25.2` is bit 25 of the field pos of channel 2.
function fieldOf(name: string): string {
  return name.replace(/^([^\d.]+)\d+(\.\d+)?$/, '$1$2');
}

class Planner {
  readonly parts: Part[] = [];
  readonly #sampled: { bit: CycleBit; at: bigint }[];
  readonly #half: bigint;
  readonly #ackEdge: bigint | undefined;

  constructor(
    private readonly cycle: Cycle,
    private readonly row: RowTimes,
    readonly lastEdge: bigint,
    readonly period: bigint,
    private readonly format: string,
  ) {
    this.#half = period / 2n;
    this.#sampled = cycle.bits
      .filter((bit) => bit.sampledAt !== undefined)
      .map((bit) => ({ bit, at: BigInt(bit.sampledAt ?? '0') }));
    const ack = cycle.bits.find((bit) => bit.clock === 1);
    this.#ackEdge = ack === undefined ? undefined : BigInt(ack.time);
  }

  #add(kind: PartKind, texts: string[], from: bigint, to: bigint, wrong = false): void {
    const before = this.parts[this.parts.length - 1];
    const begin = before !== undefined && before.to > from ? before.to : from;
    if (begin < to) this.parts.push({ kind, texts, from: begin, to, wrong });
  }

  #addNamed(field: string, kind: PartKind, texts: string[], from: bigint, to: bigint, wrong: boolean): void {
    const count = this.parts.length;
    this.#add(kind, texts, from, to, wrong);
    const added = this.parts[count];
    if (added !== undefined) added.field = field;
  }

  plan(): void {
    this.#addRequest();
    for (let i = 0; i < this.#sampled.length; i += 1) i += this.#addBit(i);
  }

  #addRequest(): void {
    const begin = BigInt(this.cycle.time);
    const asked = this.#ackEdge ?? this.lastEdge;
    const last = this.#sampled[this.#sampled.length - 1];
    if (Number.isNaN(this.row.lineDelay) || last === undefined) {
      this.#add('frame', ['request'], begin, asked);
      if (this.#ackEdge !== undefined) this.#add('frame', ['no ACK'], asked, this.lastEdge, true);
      return;
    }
    const fall = asked + BigInt(Math.round(this.row.lineDelay));
    this.#add('frame', ['request', 'req'], begin, asked);
    const delay = `line delay ${timeText(this.row.lineDelay)}`;
    this.#add('frame', [delay, 'delay'], asked, fall);
    const start = this.#sampled.find(({ bit }) => bit.name === 'START');
    if (start === undefined) {
      this.#add('frame', ['ACK'], fall, last.at + this.#half, this.cycle.status === 'no_start');
      return;
    }
    const clocks = start.bit.clock - 1;
    const time = Number.isNaN(this.row.ack) ? '' : ` ${timeText(this.row.ack)}`;
    const texts = [`ACK${time}, ${clocks} clock${clocks === 1 ? '' : 's'}`, `ACK${time}`, 'ACK'];
    this.#add('frame', texts, fall, start.at - this.#half, this.cycle.status === 'ack_range');
  }

  // Returns how many further bits belong to the same part.
  #addBit(i: number): number {
    const one = this.#sampled[i];
    if (one === undefined || one.bit.clock < 2 || one.bit.name === '') return 0;
    const { bit, at } = one;
    const from = at - this.#half;
    const to = at + this.#half;
    if (bit.payloadBit !== undefined) return this.#addField(i);
    const level = bit.level === undefined ? '' : `=${bit.level}`;
    if (bit.name === 'START') this.#add('frame', ['START'], from, to);
    else if (bit.name === 'CDS') {
      this.#add('frame', [`CDS${level}`], from, to, this.cycle.status === 'cds');
    } else if (bit.name === 'STOP') {
      const wrong = this.cycle.status === 'stop_bit';
      this.#add('frame', [bit.level === 0 ? 'STOP' : `STOP${level}`], from, to, wrong);
    }
    return 0;
  }

  #addField(i: number): number {
    const name = fieldOf(this.#sampled[i]?.bit.name ?? '');
    let count = 1;
    while (this.#continues(i + count, name)) count += 1;
    const bits = this.#sampled.slice(i, i + count);
    const first = bits[0];
    const last = bits[count - 1];
    if (first === undefined || last === undefined) return 0;
    const kind = kindOf(name);
    const value = this.#valueOf(name, bits.map(({ bit }) => bit), kind);
    const check = kind === 'crc' ? this.#checkOf(name) : undefined;
    const texts = value === '' ? [name] : [`${name}=${value}`, kind === 'data' ? name : value];
    if (check !== undefined && !check.right) {
      texts.unshift(`${name}=${value}, expected ${hexOf(BigInt(check.expected))}`);
    }
    const wrong = (check !== undefined && !check.right) || (kind === 'flag' && isActive(name, value));
    this.#addNamed(name, kind, texts, first.at - this.#half, last.at + this.#half, wrong);
    return count - 1;
  }

  #continues(i: number, name: string): boolean {
    const next = this.#sampled[i];
    return next?.bit.payloadBit !== undefined && fieldOf(next.bit.name) === name;
  }

  #checkOf(name: string) {
    return this.cycle.checks.find((check) => check.channel === channelOf(name));
  }

  // Decimal where the frame is good, and as received, hexadecimal, where it is not.
  #valueOf(name: string, bits: CycleBit[], kind: PartKind): string {
    if (bits.some(({ level }) => level === undefined)) return '';
    const value = bits.reduce((sum, { level }) => 2n * sum + BigInt(level ?? 0), 0n);
    if (kind === 'flag') return value.toString();
    if (kind === 'crc' || this.cycle.status !== 'ok') return hexOf(value);
    return (this.#isGray(name) ? binaryOf(value) : value).toString();
  }

  #isGray(name: string): boolean {
    const channel = this.format.split('+')[channelOf(name)] ?? '';
    return name.startsWith('st') && /\bst\d+:gray\b/.test(channel);
  }
}

// Counted from 0.
function channelOf(field: string): number {
  return Number(/\.(\d+)$/.exec(field)?.[1] ?? 1) - 1;
}

function binaryOf(gray: bigint): bigint {
  let value = gray;
  for (let shifted = gray >> 1n; shifted > 0n; shifted >>= 1n) value ^= shifted;
  return value;
}

function hexOf(value: bigint): string {
  return `0x${value.toString(16).toUpperCase()}`;
}

function kindOf(field: string): PartKind {
  if (/^crc/i.test(field)) return 'crc';
  return /^n?[EW](\.\d+)?$/.test(field) ? 'flag' : 'data';
}

// nE and nW are active when 0, E and W when 1.
function isActive(field: string, value: string): boolean {
  return value === (field.startsWith('n') ? '0' : '1');
}

/** From the last edge of MA until the encoder releases SLO. */
export function timeoutPart(from: bigint, to: bigint): Part {
  const texts = [`timeout ${timeText(to - from)}`, 'timeout'];
  return { kind: 'frame', texts, from, to, wrong: false };
}

function failuresOf(cycle: Cycle, parts: Part[], lastEdge: bigint) {
  const failures: CycleLayout['failures'] = [];
  for (const check of cycle.status === 'crc' ? cycle.checks : []) {
    if (check.right) continue;
    const name = check.channel === 0 ? 'crc' : `crc.${check.channel + 1}`;
    const part = parts.find(({ field }) => field === name);
    const got = hexOf(BigInt(check.received));
    const text = `${cycle.status}: ${name} is ${got}, the data need ${hexOf(BigInt(check.expected))}`;
    failures.push({ at: part?.from ?? lastEdge, text: text + mending(cycle, check.singles) });
  }
  const cause = causeOf(cycle.status);
  if (failures.length === 0 && cause !== '') {
    const part = parts.find(({ wrong }) => wrong);
    failures.push({ at: part?.from ?? lastEdge, text: `${cycle.status}: ${cause}` });
  }
  return failures;
}

function mending(cycle: Cycle, singles: number[][]): string {
  const names = singles.slice(0, 4).map(([payload]) =>
    cycle.bits.find(({ payloadBit }) => payloadBit === payload)?.name ?? `bit ${payload}`);
  return names.length === 0 ? '' : `; mended by a flip of ${names.join(' or ')}`;
}

/** `format` as `About` has it; empty where none is known. */
export function layOut(cycle: Cycle, row: RowTimes, format: string): CycleLayout {
  const first = cycle.bits[0];
  const last = cycle.bits[cycle.bits.length - 1];
  const start = BigInt(cycle.time);
  const lastEdge = last === undefined ? start : BigInt(last.time);
  const clocks = first === undefined || last === undefined ? 0 : last.clock - first.clock;
  const span = lastEdge - BigInt(first?.time ?? start);
  const period = clocks > 0 ? span / BigInt(clocks) : BigInt(cycle.end) - start;
  const planner = new Planner(cycle, row, lastEdge, period, format);
  planner.plan();
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
  const failures = failuresOf(cycle, planner.parts, lastEdge);
  return { parts: planner.parts, samples, failures, lastEdge, period };
}

/** What a part says where there is room for all. */
export function partText(part: Part): string {
  const length = timeText(part.to - part.from);
  return `${part.texts[0] ?? ''}, ${length} from ${exactTimeText(part.from)}`;
}
