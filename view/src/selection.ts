// The row that table, waveform and plots have selected, and how it comes into view.
import { batch } from '@preact/signals';
import { core } from './core/core';
import * as state from './state';
import { centred } from './wave/scale';

/** Selects a row. If the waveform does not show the row, it moves there and keeps its zoom. */
export async function selectRow(row: number): Promise<void> {
  if (row < 0 || row >= state.rowCount.value) return;
  state.selectedRow.value = row;
  const { from, to } = await stretchOf(row);
  const shown = state.range.value;
  if (state.selectedRow.value !== row) return;
  if (shown !== undefined && from >= shown.from && from < shown.to) return;
  const length = shown === undefined ? to - from : shown.to - shown.from;
  // A row that is longer than the picture is shown from its beginning.
  const middle = to - from < length ? from + (to - from) / 2n : from - length / 20n + length / 2n;
  state.showRange(centred(shown ?? { from, to }, middle));
}

/** Selects a row, and shows its cycle alone. */
export async function zoomToRow(row: number): Promise<void> {
  if (row < 0 || row >= state.rowCount.value) return;
  const [{ from, to }, cycle] = await Promise.all([stretchOf(row), core().ask('cycle', { row })]);
  const end = cycle === undefined || BigInt(cycle.end) <= from ? to : BigInt(cycle.end);
  const margin = (end - from) / 20n;
  batch(() => {
    state.selectedRow.value = row;
    state.showRange({ from: from - margin, to: end + margin });
  });
}

/** From the request of a row to the next one; of the last row, to the end of the capture. */
async function stretchOf(row: number): Promise<state.Range> {
  const { values } = await core().ask('column', { name: 'time_ns', from: row, to: row + 2 });
  const from = BigInt(values[0] ?? 0);
  const next = values[1] === undefined ? state.endTime.value : BigInt(values[1]);
  return { from, to: next > from ? next : from + 1_000n };
}
