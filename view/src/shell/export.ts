// Export of the present view: rows as CSV, lines as VCD, the waveform as PNG.
import { verbFurther } from '../core/arguments';
import { core } from '../core/core';
import { fileNames } from '../core/reading';
import { messageOf } from '../core/texts';
import { runToFile } from '../core/verbs';
import * as state from '../state';
import type { Action } from './menu';
import { rowAtPlace, shownCount } from './table_rows';

export const exportActions: readonly Action[] = [
  { name: 'CSV of the waveform', about: 'the rows of the cycles that it shows', run: () => void attempt(rowsOfRange) },
  { name: 'CSV of the table', about: 'all rows, or the rows that the filter leaves', run: () => void attempt(rowsOfTable) },
  { name: 'VCD of the waveform', about: 'MA and SLO, every edge that it shows', run: () => void attempt(linesOfRange) },
  { name: 'PNG of the waveform', run: () => void attempt(() => picture('.wave')) },
  { name: 'PNG of the plots', run: () => void attempt(() => picture('.plots')) },
];

async function attempt(action: () => Promise<void>): Promise<void> {
  try {
    await action();
  } catch (error) {
    state.messages.value = messageOf(error);
  }
}

// Gives the user a file to keep: its name is the name of the capture with this ending.
export function save(ending: string, parts: BlobPart[], type: string): void {
  const capture = state.file.value?.name.split(', ')[0] ?? 'capture';
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob(parts, { type }));
  link.download = `${capture.replace(/(\.[a-z0-9]{1,5}){1,2}$/i, '')}${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  state.announcement.value = `Saved ${link.download}.`;
}

// Rows are brought in stretches, so that the worker answers others meanwhile.
const stretch = 20_000;

async function csvOf(from: number, to: number): Promise<string[]> {
  const parts: string[] = [];
  for (let begin = from; begin < to || parts.length === 0; begin += stretch) {
    const text = await core().ask('csv', { from: begin, to: Math.min(to, begin + stretch) });
    parts.push(parts.length === 0 ? text : text.slice(text.indexOf('\n') + 1));
  }
  return parts;
}

async function rowsOfRange(): Promise<void> {
  const range = state.range.value;
  if (range === undefined) return;
  const last = await core().ask('rowAt', { time: range.to - 1n });
  const before = await core().ask('rowAt', { time: range.from });
  save('_rows.csv', await csvOf(before ?? 0, last === undefined ? 0 : last + 1), 'text/csv');
}

async function rowsOfTable(): Promise<void> {
  if (state.filter.value === '') {
    save('_rows.csv', await csvOf(0, state.rowCount.value), 'text/csv');
    return;
  }
  const parts = await csvOf(0, 0);
  const count = shownCount();
  for (let begin = 0; begin < count; begin += stretch) {
    const rows = Array.from({ length: Math.min(stretch, count - begin) }, (_, i) => rowAtPlace(begin + i));
    const cells = await core().ask('cellsOf', { rows });
    parts.push(...cells.map((row) => `${row.join(',')}\n`));
  }
  save('_rows.csv', parts, 'text/csv');
}

// The output file of the verbs, until it is saved.
const linesName = 'lines_of_range.vcd';

// The name that `convert` gives to a line: with the file name only if another file has a line of this name.
function nameOfLine(line: string): string {
  const plain = (name: string) => (fileNames().length > 1 ? name.slice(name.indexOf(':') + 1) : name);
  const same = state.about.value?.lines.filter((other) => plain(other) === plain(line)) ?? [];
  return same.length > 1 ? line : plain(line);
}

async function linesOfRange(): Promise<void> {
  const range = state.range.value;
  const { about } = state;
  if (range === undefined || about.value === undefined) return;
  const lines = [about.value.ma, about.value.slo].flatMap((line) => ['--line', nameOfLine(line)]);
  const bytes = await runToFile([
    'convert', ...fileNames(), ...verbFurther('convert', state.settings.value), ...lines,
    '--since', `${range.from}ps`, '--until', `${range.to}ps`, '-o', linesName,
  ], linesName);
  save('_lines.vcd', [new Uint8Array(bytes)], 'text/plain');
}

// A picture of all canvases in a part of the page, in their places; undefined if there are no canvases.
async function pictureOf(selector: string): Promise<Blob | undefined> {
  const part = document.querySelector(selector);
  const canvases = [...(part?.querySelectorAll('canvas') ?? [])].filter((canvas) => canvas.width > 0);
  if (part === null || canvases.length === 0) return undefined;
  const scale = devicePixelRatio;
  const boxes = canvases.map((canvas) => canvas.getBoundingClientRect());
  const left = Math.min(...boxes.map((box) => box.left));
  const top = Math.min(...boxes.map((box) => box.top));
  const picture = document.createElement('canvas');
  picture.width = Math.ceil((Math.max(...boxes.map((box) => box.right)) - left) * scale);
  picture.height = Math.ceil((Math.max(...boxes.map((box) => box.bottom)) - top) * scale);
  const context = picture.getContext('2d')!;
  context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--page');
  context.fillRect(0, 0, picture.width, picture.height);
  canvases.forEach((canvas, i) => {
    const box = boxes[i]!;
    context.drawImage(canvas, (box.left - left) * scale, (box.top - top) * scale, box.width * scale, box.height * scale);
  });
  return new Promise((resolve) => { picture.toBlob((blob) => resolve(blob ?? undefined), 'image/png'); });
}

async function picture(part: string): Promise<void> {
  const blob = await pictureOf(part);
  if (blob === undefined) throw new Error('The plots are not shown; open their panel first.');
  save(`_${part.slice(1)}.png`, [blob], 'image/png');
}
