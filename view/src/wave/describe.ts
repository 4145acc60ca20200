/** The contents of the pictures, in words. */
import { harmlessStatuses } from '../core/statuses';
import * as state from '../state';
import { exactTimeText, rateText, timeText } from './scale';

/** `Δ 1.2 µs (833 kHz)`; empty if a cursor is missing. */
export function differenceText({ a, b }: state.Cursors): string {
  if (a === undefined || b === undefined) return '';
  const difference = b - a;
  if (difference === 0n) return '0 s';
  return `${exactTimeText(difference)} (${rateText(1e12 / Math.abs(Number(difference)))})`;
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

/**
 * For readers who do not see the picture.
 * \param selected the number of the cycle that is selected
 * \param seen the cycles in the picture, in words
 */
export function waveText(selected: number | undefined, seen: string): string {
  const range = state.range.value;
  const cursors = state.cursors.value;
  if (range === undefined) return 'Waveform of MA and SLO: no capture is open.';
  const extent = `${exactTimeText(range.from)} to ${exactTimeText(range.to)}, ${timeText(range.to - range.from)} wide`;
  const parts = [`Waveform of MA and SLO from ${extent}; ${state.rowCount.value} cycles have been read.`];
  if (seen !== '') parts.push(`In the picture: ${seen}.`);
  if (selected !== undefined) parts.push(`Cycle ${selected} is selected.`);
  if (cursors.a !== undefined) parts.push(`Cursor A at ${exactTimeText(cursors.a)}.`);
  if (cursors.b !== undefined) parts.push(`Cursor B at ${exactTimeText(cursors.b)}.`);
  const difference = differenceText(cursors);
  if (difference !== '') parts.push(`B is ${difference} after A.`);
  return parts.join(' ');
}
