/** What the pictures show, in words. */
import { harmlessStatuses } from '../core/statuses';
import type { Cursors, Range } from '../state';
import { exactTimeText, rateText, timeText } from './scale';

function magnitude(time: bigint): bigint {
  return time < 0n ? -time : time;
}

/** `Δ 1.2 µs (833 kHz)`; empty where a cursor is missing. */
export function differenceText({ a, b }: Cursors): string {
  if (a === undefined || b === undefined) return '';
  const difference = b - a;
  if (difference === 0n) return '0 s';
  return `${exactTimeText(difference)} (${rateText(1e12 / Number(magnitude(difference)))})`;
}

export function rangeText({ from, to }: Range): string {
  return `${exactTimeText(from)} to ${exactTimeText(to)}, ${timeText(to - from)} wide`;
}

export interface Described {
  range: Range | undefined;
  cursors: Cursors;
  /** The number of its cycle. */
  selected: number | undefined;
  rows: number;
  /** Of the cycles in the picture. */
  seen: string;
}

const mostNamed = 5;

/** A cycle in the picture, by its number in the capture. */
export interface SeenCycle {
  number: number;
  status: string;
}

/** `cycles 3 to 5; failed: 4 crc`. */
export function cyclesText(cycles: readonly SeenCycle[]): string {
  const [first] = cycles;
  const last = cycles.at(-1);
  if (first === undefined || last === undefined) return '';
  const failed = cycles.filter(({ status }) => !harmlessStatuses.has(status));
  const named = failed.slice(0, mostNamed).map(({ number, status }) => `${number} ${status}`);
  const more = failed.length > mostNamed ? ` and ${failed.length - mostNamed} more` : '';
  const extent = cycles.length === 1 ? `cycle ${first.number}` : `cycles ${first.number} to ${last.number}`;
  return `${extent}; ${failed.length === 0 ? 'none failed' : `failed: ${named.join(', ')}${more}`}`;
}

/** For who does not see the picture. */
export function waveText({ range, cursors, selected, rows, seen }: Described): string {
  if (range === undefined) return 'Waveform of MA and SLO: no capture is open.';
  const parts = [`Waveform of MA and SLO from ${rangeText(range)}; ${rows} cycles have been read.`];
  if (seen !== '') parts.push(`In the picture: ${seen}.`);
  if (selected !== undefined) parts.push(`Cycle ${selected} is selected.`);
  if (cursors.a !== undefined) parts.push(`Cursor A at ${exactTimeText(cursors.a)}.`);
  if (cursors.b !== undefined) parts.push(`Cursor B at ${exactTimeText(cursors.b)}.`);
  const difference = differenceText(cursors);
  if (difference !== '') parts.push(`B is ${difference} after A.`);
  return parts.join(' ');
}
