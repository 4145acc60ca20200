// Search: "next crc", "previous nW=0", "position > 1000". The grammar of conditions is in
// core/condition.ts.
import { effect, signal } from '@preact/signals';
import { Superseded } from '../core/client';
import { parseCondition } from '../core/condition';
import { core } from '../core/core';
import { messageOf } from '../core/texts';
import { selectRow } from '../selection';
import * as state from '../state';

/** How many rows match; the error of the condition. */
export const found = signal<{ count: number | undefined; error: string }>({ count: undefined, error: '' });

const most = 1_000_000;

function parse(text: string) {
  const [, word = '', condition = ''] = /^\s*(?:(next|prev(?:ious)?|first|last)\b)?\s*(.*?)\s*$/i.exec(text) ?? [];
  return { direction: word.toLowerCase(), condition };
}

/** The condition of the search field alone. */
export function searchedCondition(): string {
  return parse(state.search.value).condition;
}

/** Goes to the next row for which the condition is true, or the one before. */
export async function searchOn(step: 1 | -1, text = state.search.value): Promise<void> {
  const { direction, condition } = parse(text);
  if (condition === '' || state.rowCount.value === 0) return;
  const back = direction.startsWith('prev') || direction === 'last' ? -1 : 1;
  const forward = (step * back) as 1 | -1;
  const start = forward > 0 ? -1 : state.rowCount.value;
  const fromEdge = direction === 'first' || direction === 'last';
  const from = fromEdge ? start : state.selectedRow.value ?? start;
  const edge = forward > 0 ? 'From the beginning. ' : 'From the end. ';
  try {
    let row = await core().ask('find', { condition, from, step: forward });
    const note = row === undefined ? edge : '';
    row ??= await core().ask('find', { condition, from: start, step: forward });
    if (row !== undefined) await selectRow(row);
    state.announcement.value = row === undefined ? `No row: ${condition}` : `${note}Row ${row}: ${condition}`;
    found.value = { ...found.value, error: '' };
  } catch (error) {
    found.value = { count: undefined, error: messageOf(error) };
  }
}

/** Begins to count matches as the field changes, once. */
export function followSearch(): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  effect(() => {
    const { condition } = parse(state.search.value);
    const rows = state.rowCount.value;
    clearTimeout(timer);
    timer = setTimeout(() => void count(condition, rows), 150);
  });
}

async function count(condition: string, rows: number): Promise<void> {
  if (condition === '' || rows === 0) {
    found.value = { count: undefined, error: '' };
    return;
  }
  try {
    parseCondition(condition, state.columns.value);
    const matches = await core().ask('findAll', { condition, most }, { lane: 'count' });
    found.value = { count: matches.length, error: '' };
  } catch (error) {
    if (error instanceof Superseded) return;
    found.value = { count: undefined, error: messageOf(error) };
  }
}
