/** What the user does with the waveform, however it is asked for. */
import { core } from '../core/core';
import * as state from '../state';
import { around, moved, zoomed } from './scale';

function show({ from, to }: state.Range): void {
  state.showRange(from, to);
}

export function zoom(factor: number, share = 0.5): void {
  const range = state.range.value;
  if (range !== undefined) show(zoomed(range, factor, share));
}

export function pan(share: number): void {
  const range = state.range.value;
  if (range !== undefined) show(moved(range, share));
}

export function showAll(): void {
  show(state.wholeRange.value);
}

/** The beginning or the end of the capture, as much of it as is shown now. */
export function showEnd(end: 'first' | 'last'): void {
  const range = state.range.value;
  if (range === undefined) return;
  const whole = state.wholeRange.value;
  const span = range.to - range.from;
  show(end === 'first'
    ? { from: whole.from, to: whole.from + span }
    : { from: whole.to - span, to: whole.to });
}

/** When a cycle begins and the next one begins. */
export async function extentOf(row: number): Promise<state.Range | undefined> {
  const { values } = await core().ask('column', { name: 'time_ns', from: row, to: row + 2 });
  const [from, to] = values;
  if (from === undefined) return undefined;
  return { from: BigInt(from), to: BigInt(to ?? state.wholeRange.value.to) };
}

/** A cycle alone. */
export async function showCycle(row: number): Promise<void> {
  const extent = await extentOf(row);
  if (extent === undefined || state.selectedRow.value !== row) return;
  const cycle = await core().ask('cycle', { row });
  const end = cycle === undefined ? extent.to : BigInt(cycle.end);
  show(around(extent.from, end > extent.from ? end : extent.to, 0.06));
}

/** Moves so that a cycle is seen; nothing where it is. */
export async function reveal(row: number): Promise<void> {
  const extent = await extentOf(row);
  const range = state.range.value;
  if (extent === undefined || range === undefined || state.selectedRow.value !== row) return;
  const isSeen = extent.from >= range.from && extent.from < range.to &&
    (extent.to <= range.to || extent.to - extent.from > range.to - range.from);
  if (isSeen) return;
  const span = range.to - range.from;
  const length = extent.to - extent.from;
  const lead = span > length ? (span - length) / 2n : span / 20n;
  show({ from: extent.from - lead, to: extent.from - lead + span });
}

/** Selects the cycle that has begun at this time. */
export async function selectAt(time: bigint): Promise<void> {
  const row = await core().ask('rowAt', { time });
  if (row !== undefined) state.selectedRow.value = row;
}

export function selectNext(step: 1 | -1): void {
  const row = state.selectedRow.value;
  const last = state.rowCount.value - 1;
  if (last < 0) return;
  state.selectedRow.value = row === undefined ? 0 : Math.max(0, Math.min(last, row + step));
}

export function setCursor(which: 'a' | 'b', time: bigint | undefined): void {
  state.cursors.value = { ...state.cursors.value, [which]: time };
}

export function clearCursors(): void {
  state.cursors.value = { a: undefined, b: undefined };
}

/** What is between the cursors. */
export function showCursors(): void {
  const { a, b } = state.cursors.value;
  if (a === undefined || b === undefined || a === b) return;
  show(a < b ? around(a, b, 0.1) : around(b, a, 0.1));
}
