// The rows that the table shows, and their cells as far as they have arrived.
import { effect, signal } from '@preact/signals';
import { Superseded } from '../core/client';
import { core } from '../core/core';
import { firstWhere } from '../core/first_where';
import { messageOf } from '../core/texts';
import * as state from '../state';

/** Rows for which the filter is true; undefined if the table shows all rows. */
export const filtered = signal<Int32Array | undefined>(undefined);
/** The problem with the filter. */
export const filterError = signal('');
/** Counts the data that have come, so that the table draws again. */
export const arrived = signal(0);

// The maximum number of rows in a filtered table, so that memory does not grow with the capture.
const mostFiltered = 2_000_000;
// Cells kept in addition to the cells that are shown.
const mostKept = 4_000;
const margin = 40;

const kept = new Map<number, string[]>();

export function shownCount(): number {
  return filtered.value?.length ?? state.rowCount.value;
}

/** The row at a place of the table. */
export function rowAtPlace(place: number): number {
  return filtered.value === undefined ? place : filtered.value[place] ?? -1;
}

/** The place of a row in the table, or of the next one that the filter leaves. */
export function placeOfRow(row: number): number {
  const rows = filtered.value;
  return rows === undefined ? row : firstWhere(rows.length, (place) => rows[place]! >= row);
}

export function cellsOf(row: number): string[] | undefined {
  return kept.get(row);
}

/** Requests the cells of these places, and some around them. */
export async function want(first: number, last: number): Promise<void> {
  const missing: number[] = [];
  for (let place = first; place < last; place += 1) {
    const row = rowAtPlace(place);
    if (row >= 0 && !kept.has(row)) missing.push(row);
  }
  if (missing.length === 0) return;
  const rows: number[] = [];
  const end = Math.min(shownCount(), last + margin);
  for (let place = Math.max(0, first - margin); place < end; place += 1) rows.push(rowAtPlace(place));
  const generation = state.generation.value;
  try {
    const cells = await ask(rows);
    keep(rows, generation === state.generation.value ? cells : []);
  } catch (error) {
    if (!(error instanceof Superseded)) state.messages.value = String(error);
  }
}

function ask(rows: number[]): Promise<string[][]> {
  const [first] = rows;
  const last = rows.at(-1);
  if (first === undefined || last === undefined) return Promise.resolve([]);
  if (last - first === rows.length - 1) {
    return core().ask('cells', { from: first, to: last + 1 }, { lane: 'table' });
  }
  return core().ask('cellsOf', { rows }, { lane: 'table' });
}

function keep(rows: number[], cells: string[][]): void {
  if (kept.size > mostKept) kept.clear();
  rows.forEach((row, i) => {
    const own = cells[i];
    if (own !== undefined) kept.set(row, own);
  });
  arrived.value += 1;
}

let seen = 0;

/** Begins to follow filter and capture, once. */
export function followRows(): void {
  effect(() => {
    const generation = state.generation.value;
    if (generation !== seen) {
      seen = generation;
      kept.clear();
      filtered.value = undefined;
      arrived.value = 0;
    }
  });
  effect(() => {
    const waits = state.filter.value !== '' && state.rowCount.value > 0;
    clearTimeout(timer);
    timer = setTimeout(refilter, waits ? wait() : 0);
  });
}

let timer: ReturnType<typeof setTimeout> | undefined;
let filteredAt = 0;

// While a capture is being read, once a second: each time looks at all rows.
function wait(): number {
  if (state.progress.peek().state !== 'reading') return 0;
  return Math.max(0, filteredAt + 1000 - performance.now());
}

async function refilter(): Promise<void> {
  filteredAt = performance.now();
  const condition = state.filter.value;
  const rows = state.rowCount.value;
  if (condition.trim() === '' || rows === 0) {
    filtered.value = undefined;
    filterError.value = '';
    return;
  }
  try {
    filtered.value = await core().ask('findAll', { condition, most: mostFiltered }, { lane: 'filter' });
    filterError.value = '';
  } catch (error) {
    if (error instanceof Superseded) return;
    filtered.value = undefined;
    filterError.value = messageOf(error);
  }
}
