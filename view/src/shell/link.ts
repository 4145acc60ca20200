// The state of the view as the part of the address after #, and back.
import { effect } from '@preact/signals';
import { selectRow } from '../selection';
import * as state from '../state';
import { carriedView, openCarried } from './carried';
import { openSimulated } from './examples';
import { panels } from './panels';
import { play } from './simulate';

/** The view as text. A capture of the user is named, not contained. */
export function linkText(): string {
  const link = new URLSearchParams();
  const put = (name: string, value: string | undefined, usual = '') => {
    if (value !== undefined && value !== usual) link.set(name, value);
  };
  const { settings, file, range, cursors } = state;
  put('file', file.value?.example === undefined ? file.value?.name : undefined);
  put('simulate', file.value?.example);
  const texts = ['format', 'ma', 'slo', 'units', 'further'] as const;
  for (const name of texts) put(name, settings.value[name], state.defaultSettings[name]);
  put('invert', [settings.value.invertMa && 'ma', settings.value.invertSlo && 'slo'].filter(Boolean).join(','));
  put('from', range.value?.from.toString());
  put('to', range.value?.to.toString());
  put('row', state.selectedRow.value?.toString());
  put('a', cursors.value.a?.toString());
  put('b', cursors.value.b?.toString());
  put('search', state.search.value);
  put('filter', state.filter.value);
  put('panel', state.panel.value, 'cycle');
  put('theme', state.theme.value, 'system');
  return link.toString();
}

function oneOf<T extends string>(value: string | null, values: readonly T[], usual: T): T {
  return values.includes(value as T) ? (value as T) : usual;
}

// A link to a capture of the user, until this file is opened.
let waiting: URLSearchParams | undefined;

// Shows the view of a link. The capture must be open.
function goTo(link: URLSearchParams): void {
  const numberOf = (name: string) => {
    const text = link.get(name) ?? '';
    return /^-?\d{1,19}$/.test(text) ? BigInt(text) : undefined;
  };
  const [from, to, row] = [numberOf('from'), numberOf('to'), numberOf('row')];
  const range = from !== undefined && to !== undefined && from < to ? { from, to } : undefined;
  if (range !== undefined) state.range.value = range;
  state.cursors.value = { a: numberOf('a'), b: numberOf('b') };
  if (row === undefined) return;
  // As soon as it has been read. With a range in the link, that range stays.
  const stop = effect(() => {
    if (state.rowCount.value <= row) return;
    if (range !== undefined) state.selectedRow.value = Number(row);
    else void selectRow(Number(row));
    queueMicrotask(() => stop());
  });
}

/** Applies the settings in the address, and from then on updates the address. */
export async function followLink(): Promise<void> {
  const link = new URLSearchParams(location.hash.length > 1 ? location.hash.slice(1) : carriedView());
  const invert = (link.get('invert') ?? '').split(',');
  state.settings.value = {
    format: link.get('format') ?? '',
    ma: link.get('ma') ?? '',
    slo: link.get('slo') ?? '',
    invertMa: invert.includes('ma'),
    invertSlo: invert.includes('slo'),
    units: oneOf(link.get('units'), ['counts', 'deg', 'mm'], 'counts'),
    further: link.get('further') ?? '',
  };
  state.search.value = link.get('search') ?? '';
  state.filter.value = link.get('filter') ?? '';
  state.panel.value = oneOf(link.get('panel'), panels.map(({ id }) => id), 'cycle');
  state.theme.value = oneOf(link.get('theme'), ['system', 'light', 'dark'], 'system');
  const simulate = link.get('simulate');
  const file = link.get('file');
  if (link.has('play')) {
    play(link.get('play') ?? '');
  } else if (simulate !== null) {
    await openSimulated(simulate, state.settings.value.format);
    goTo(link);
  } else if (await openCarried()) {
    goTo(link);
  } else if (file !== null) {
    waiting = link;
    state.messages.value = `The link is to a view of ${file}. Open this file to see it.`;
  }
  effect(keepInStep);
}

/** Called after a file of the user has been opened. */
export function opened(): void {
  if (waiting !== undefined && state.file.value?.name === waiting.get('file')) goTo(waiting);
  waiting = undefined;
}

let timer: ReturnType<typeof setTimeout> | undefined;

// Not with every step of a movement: browsers limit how often an address may change.
function keepInStep(): void {
  const text = linkText();
  if (waiting !== undefined || state.file.value === undefined) return;
  clearTimeout(timer);
  timer = setTimeout(() => history.replaceState(null, '', `#${text}`), 400);
}
