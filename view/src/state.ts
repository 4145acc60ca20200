// All that the parts of the page share, one signal a fact. Times are picoseconds.
import { computed, signal } from '@preact/signals';
import type { About, Column } from 'biss';
import type { Report } from './core/report';
import { shortestSpan } from './wave/scale';

/** A stretch of time, `from` before `to`. */
export interface Range {
  from: bigint;
  to: bigint;
}

export interface Cursors {
  a: bigint | undefined;
  b: bigint | undefined;
}

export type Theme = 'system' | 'light' | 'dark';
export type Units = 'counts' | 'deg' | 'mm';
export type Panel = 'cycle' | 'plots' | 'summary' | 'identify' | 'check' | 'explain' | 'eds';

/** The options for `biss decode`. Empty text: not given. */
export interface Settings {
  format: string;
  ma: string;
  slo: string;
  invertMa: boolean;
  invertSlo: boolean;
  units: Units;
  /** Further options of `biss decode`, as on a command line. */
  further: string;
}

export interface OpenFile {
  /** The name in messages and verbs. */
  name: string;
  bytes: number;
  /** A capture that the page made or contains; a link to the state can name it. */
  example: string | undefined;
}

export interface Progress {
  state: 'none' | 'loading' | 'reading' | 'ended' | 'failed';
  /** The part that has been read, 0 to 1. */
  done: number;
}

export const defaultSettings: Settings = {
  format: '',
  ma: '',
  slo: '',
  invertMa: false,
  invertSlo: false,
  units: 'counts',
  further: '',
};

// The capture and the data read from it; only src/core/reading.ts sets these.
export const file = signal<OpenFile | undefined>(undefined);
export const about = signal<About | undefined>(undefined);
export const progress = signal<Progress>({ state: 'none', done: 0 });
export const columns = signal<readonly Column[]>([]);
export const rowCount = signal(0);
/** Counts the sessions opened: code that keeps rows or drawings drops them when it changes. */
export const generation = signal(0);
/** Messages of the command on stderr, and errors of the page itself. */
export const messages = signal('');
/** The text that a screen reader speaks after a change outside the focus. */
export const announcement = signal('');

/** The data of a report about the whole capture; undefined if the page has no report. */
export const report = signal<Report | undefined>(undefined);

// The user's choices.
export const settings = signal<Settings>(defaultSettings);
/** The time range of the waveform and the plots. Undefined without a capture. */
export const range = signal<Range | undefined>(undefined);
export const selectedRow = signal<number | undefined>(undefined);
export const cursors = signal<Cursors>({ a: undefined, b: undefined });
export const search = signal('');
/** The table shows the rows for which this condition is true; all if it is empty. */
export const filter = signal('');
export const panel = signal<Panel>('cycle');
export const theme = signal<Theme>('system');
export const systemIsDark = signal(false);

/** A part is read in the same way as the whole capture, so that the results of the whole capture hold. */
export const isWhole = computed(() => {
  const whole = report.value?.settings;
  const keys = Object.keys(defaultSettings) as (keyof Settings)[];
  return whole !== undefined && keys.every((key) => whole[key] === settings.value[key]);
});

/** The theme that is shown. Canvases draw again when it changes. */
export const shownTheme = computed<'light' | 'dark'>(() => {
  if (theme.value !== 'system') return theme.value;
  return systemIsDark.value ? 'dark' : 'light';
});

/** The end of the data read so far. */
export const endTime = computed(() => BigInt(about.value?.endTime ?? '0'));

/** The first change of a line, which can be before 0. */
export const beginTime = signal(0n);

/** The whole capture, as far as it has been read. */
export const wholeRange = computed<Range>(() => ({
  from: beginTime.value,
  to: endTime.value > beginTime.value ? endTime.value : beginTime.value + 1n,
}));

/** Shows this stretch, moved or cut to lie in the capture; it keeps its length if possible. */
export function showRange({ from, to }: Range): void {
  const whole = wholeRange.value;
  let length = to - from;
  if (length < shortestSpan) {
    from -= (shortestSpan - length) / 2n;
    length = shortestSpan;
  }
  if (length > whole.to - whole.from) length = whole.to - whole.from;
  if (from < whole.from) from = whole.from;
  if (from + length > whole.to) from = whole.to - length;
  range.value = { from, to: from + length };
}
