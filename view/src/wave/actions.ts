/** The user's actions on the waveform, from keys, pointer and buttons. */
import { core } from '../core/core';
import { selectRow, zoomToRow } from '../selection';
import type { Key } from '../shell/keys';
import * as state from '../state';
import { around, centred, moved, zoomed } from './scale';

export function zoom(factor: number, share = 0.5): void {
  const range = state.range.value;
  if (range !== undefined) state.showRange(zoomed(range, factor, share));
}

export function pan(share: number): void {
  const range = state.range.value;
  if (range !== undefined) state.showRange(moved(range, share));
}

export const moveKeys: readonly Key[] = [
  { keys: ['ArrowLeft'], help: 'Move left', run: () => pan(-1 / 8) },
  { keys: ['ArrowRight'], help: 'Move right', run: () => pan(1 / 8) },
];

export function showAll(): void {
  state.showRange(state.wholeRange.value);
}

/** The beginning or the end of the capture, as much of it as is shown now. */
export function showEnd(end: 'first' | 'last'): void {
  const range = state.range.value;
  if (range === undefined) return;
  const whole = state.wholeRange.value;
  const span = range.to - range.from;
  state.showRange(end === 'first'
    ? { from: whole.from, to: whole.from + span }
    : { from: whole.to - span, to: whole.to });
}

/** Selects the cycle that has begun at this time. */
export async function selectAt(time: bigint): Promise<void> {
  const row = await core().ask('rowAt', { time });
  if (row !== undefined) await selectRow(row);
}

/** Shows the selected cycle alone. */
export function showSelected(): void {
  const row = state.selectedRow.value;
  if (row !== undefined) void zoomToRow(row);
}

export function selectNext(step: 1 | -1): void {
  const row = state.selectedRow.value;
  const last = state.rowCount.value - 1;
  if (last < 0) return;
  void selectRow(row === undefined ? 0 : Math.max(0, Math.min(last, row + step)));
}

export function setCursor(which: 'a' | 'b', time: bigint | undefined): void {
  state.cursors.value = { ...state.cursors.value, [which]: time };
}

/** Sets a cursor, and brings it into the picture. */
export function moveCursor(which: 'a' | 'b', time: bigint): void {
  setCursor(which, time);
  const range = state.range.value;
  if (range !== undefined && (time < range.from || time >= range.to)) state.showRange(centred(range, time));
}

export function clearCursors(): void {
  state.cursors.value = { a: undefined, b: undefined };
}

/** Shows the range between the cursors. */
export function showCursors(): void {
  const { a, b } = state.cursors.value;
  if (a === undefined || b === undefined || a === b) return;
  state.showRange(a < b ? around(a, b, 0.1) : around(b, a, 0.1));
}
