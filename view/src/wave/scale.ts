/** The axis of time: the place of a time on the screen, and round marks with a unit that fits. */

import type { Range } from '../state';

/** The shortest stretch that is shown: an edge alone. */
export const shortestSpan = 1000n;

/** Times to pixels. Numbers are offsets from `from`, so that no digit is lost in a long capture. */
export class TimeScale {
  readonly from: bigint;
  readonly span: number;
  readonly width: number;

  constructor(range: Range, width: number) {
    this.from = range.from;
    this.span = Math.max(1, Number(range.to - range.from));
    this.width = Math.max(1, width);
  }

  get pixelsPerPs(): number {
    return this.width / this.span;
  }

  x(time: bigint): number {
    return Number(time - this.from) * this.pixelsPerPs;
  }

  time(x: number): bigint {
    return this.from + BigInt(Math.round(x / this.pixelsPerPs));
  }
}

/** `factor` below 1 shows less; the time at `share` of the width keeps its place. */
export function zoomed(range: Range, factor: number, share: number): Range {
  const span = Number(range.to - range.from);
  const next = Math.max(span * factor, Number(shortestSpan));
  const from = range.from + BigInt(Math.round((span - next) * share));
  return { from, to: from + BigInt(Math.round(next)) };
}

/** Moved by a share of its length. */
export function moved(range: Range, share: number): Range {
  const by = BigInt(Math.round(Number(range.to - range.from) * share));
  return { from: range.from + by, to: range.to + by };
}

/** Moved so that this time is in the middle. */
export function centred({ from, to }: Range, time: bigint): Range {
  const begin = time - (to - from) / 2n;
  return { from: begin, to: begin + (to - from) };
}

/** The stretch from `from` to `to` with a margin of `share` of it on both sides. */
export function around(from: bigint, to: bigint, share: number): Range {
  const margin = BigInt(Math.round(Math.max(Number(to - from), 2000) * share));
  return { from: from - margin, to: to + margin };
}

/** Units with their sizes, the largest one first. */
export type Units = readonly [string, number][];

export const timeUnits: Units = [['s', 1e12], ['ms', 1e9], ['µs', 1e6], ['ns', 1e3], ['ps', 1]];
const rateUnits: Units = [['GHz', 1e9], ['MHz', 1e6], ['kHz', 1e3], ['Hz', 1], ['mHz', 1e-3]];

/** The largest unit that fits in a value; else the smallest one. */
export function unitOf(value: number, units = timeUnits): [string, number] {
  return units.find(([, factor]) => Math.abs(value) >= factor) ?? units.at(-1)!;
}

function trimmed(value: number, digits: number): string {
  const text = value.toPrecision(digits);
  if (text.includes('e')) return String(Number(text));
  return text.includes('.') ? text.replace(/\.?0+$/, '') : text;
}

/** `1.234 µs`, with at most this many digits. */
export function timeText(ps: number | bigint, digits = 4): string {
  const value = Number(ps);
  if (value === 0) return '0 s';
  const [name, factor] = unitOf(value);
  return `${trimmed(value / factor, digits).replace('-', '−')} ${name}`;
}

/** To the picosecond: `12.000345678901 s`, `345.5 ns`. */
export function exactTimeText(ps: bigint): string {
  if (ps === 0n) return '0 s';
  const sign = ps < 0n ? '−' : '';
  const size = ps < 0n ? -ps : ps;
  const [name, factor] = unitOf(Number(size));
  const unit = BigInt(factor);
  const digits = String(factor).length - 1;
  const rest = (size % unit).toString().padStart(digits, '0').replace(/0+$/, '');
  return `${sign}${size / unit}${rest === '' ? '' : `.${rest}`} ${name}`;
}

/** `2.5 MHz`. */
export function rateText(hertz: number, digits = 4): string {
  const [name, factor] = unitOf(hertz, rateUnits);
  return `${trimmed(hertz / factor, digits)} ${name}`;
}

/** 1, 2 or 5 times a power of ten, at least `least`. */
export function roundStep(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= least * (1 - 1e-9)) ?? 10;
  return step * power;
}

/**
 * Marks at round times, at least `room` pixels from one another. If the times have many digits in common, the
 * marks count from the time `base`. `x` is in pixels.
 */
export function timeMarks(scale: TimeScale, room: number) {
  const step = BigInt(Math.max(1, Math.round(roundStep((room / scale.width) * scale.span))));
  const end = scale.time(scale.width);
  let first = (scale.from / step) * step;
  if (first < scale.from) first += step;
  const marks: { x: number; text: string }[] = [];
  const size = Math.max(Math.abs(Number(end)), Math.abs(Number(scale.from)));
  const far = size / Number(step) >= 1e5;
  const [name, factor] = unitOf(far ? scale.span : Math.max(size, Number(step)));
  const places = Math.max(0, Math.ceil(Math.log10(factor / Number(step)) - 1e-9));
  for (let time = first; time <= end && marks.length < 100; time += step) {
    const value = Number(time - (far ? first : 0n)) / factor;
    const text = `${far ? '+' : ''}${value.toFixed(places)} ${name}`;
    marks.push({ x: scale.x(time), text });
  }
  return { marks, base: far ? exactTimeText(first) : undefined };
}
