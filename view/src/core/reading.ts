// Opens captures and keeps the state in step with the data that the worker has read.
import { batch } from '@preact/signals';
import * as state from '../state';
import { decodeArguments } from './arguments';
import { core, startCore } from './core';
import type { Opened, Reading } from './protocol';
import type { Report } from './report';
import { sizeOf, type ServedFile } from './source';
import { messageOf } from './texts';
import { setVerbFiles, endVerbs, type NamedContent } from './verbs';

let files: NamedContent[] = [];
let loaded: Promise<void> | undefined;
// The first rows of a new capture choose what is shown.
let rangeIsOpen = false;
// The messages of the command when it opened the capture.
let openMessages = '';

/** Starts the core; resolves when it is ready. */
export function start(): Promise<void> {
  loaded = startCore();
  core().onReading = take;
  loaded.catch((error: Error) => fail(error.message));
  return loaded;
}

// Captures are opened one after the other. If a newer one replaces a capture that waits, the older one is not
// opened.
let turn = Promise.resolve();
let newestFiles = 0;
let newestReading = 0;

/** Opens files as one capture; `example` as in OpenFile, `report` if they are from a report. */
export function openFiles(contents: NamedContent[], example?: string, report?: Report): Promise<void> {
  const own = ++newestFiles;
  newestReading += 1;
  endBehind();
  return inTurn(() => (own === newestFiles ? openNow(contents, example, report) : undefined));
}

/** Reads the same files again, with the settings as they are now. */
export function reopen(): Promise<void> {
  const own = ++newestReading;
  endBehind();
  return inTurn(() => (own === newestReading ? read() : undefined));
}

// A request of the user does not wait until a file that has grown is read again.
function endBehind(): void {
  core().ask('endBehind', {}).catch(() => {}); // A core that has failed is reported by start().
}

// A request that fails does not stop the requests after it.
function inTurn(action: () => Promise<void> | undefined): Promise<void> {
  turn = turn.then(action).catch((error: unknown) => fail(messageOf(error)));
  return turn;
}

async function openNow(contents: NamedContent[], example?: string, report?: Report): Promise<void> {
  if (contents.length === 0) return;
  await loaded;
  await core().ask('close', {});
  await Promise.all(files.map(({ name }) => core().ask('removeFile', { name })));
  files = contents.map(({ name, content }) => ({ name: safeName(name), content }));
  await Promise.all(files.map((file) => core().ask('addFile', file)));
  setVerbFiles(files);
  await core().ask('report', { report });
  batch(() => {
    state.file.value = {
      name: files.map(({ name }) => name).join(', '),
      bytes: contents.reduce((sum, { content }) => sum + sizeOf(content), 0),
      example,
    };
    state.report.value = report;
    state.about.value = undefined;
    state.columns.value = [];
    state.rowCount.value = 0;
    state.range.value = undefined;
    state.selectedRow.value = undefined;
    state.cursors.value = { a: undefined, b: undefined };
  });
  await read();
}

/** The names of the capture's files, for the arguments of verbs. */
export function fileNames(): string[] {
  return files.map(({ name }) => name);
}

/** The capture that is open is this file of the server. */
export function isServed({ address }: ServedFile): boolean {
  const held = files.length === 1 ? files[0]!.content : undefined;
  return held !== undefined && 'address' in held && held.address === address;
}

/**
 * Reads a file of the server again after it has grown. It reads the whole file, in the background, so that a
 * row that was cut becomes complete. Returns false if another capture has been opened.
 */
export async function readOn(name: string, content: ServedFile): Promise<boolean> {
  const isOpen = () => isServed(content);
  const { state: reading } = state.progress.value;
  if (reading === 'reading' || reading === 'loading') return isOpen();
  if (!isOpen()) return false;
  // There is nothing to keep: the header of the file may have been incomplete.
  if (state.rowCount.value === 0) {
    await openFiles([{ name, content }]);
    return isOpen();
  }
  await inTurn(() => (isOpen() ? replaceGrown({ name: files[0]!.name, content }) : undefined));
  return isOpen();
}

async function replaceGrown(file: NamedContent): Promise<void> {
  const before = { end: state.endTime.value, whole: state.wholeRange.value };
  files = [file];
  await core().ask('addFile', file);
  const grown = await open('openBehind');
  if (grown?.reading === undefined) return;
  const { reading } = grown;
  setVerbFiles(files);
  batch(() => {
    state.generation.value = reading.generation;
    openMessages = grown.messages;
    state.messages.value = openMessages;
    if (state.file.value !== undefined) {
      state.file.value = { ...state.file.value, bytes: sizeOf(file.content) };
    }
    take(reading);
    goWithTheEnd(before);
  });
}

// A view of the end stays a view of the end, and a view of all stays a view of all.
function goWithTheEnd({ end, whole }: { end: bigint; whole: state.Range }): void {
  const range = state.range.value;
  if (range === undefined || range.to < end) return;
  const now = state.endTime.value;
  state.range.value = { from: range.from <= whole.from ? range.from : range.from + now - end, to: now };
}

// A name is an argument of the command: it has no folder and does not look like an option.
function safeName(name: string): string {
  return name.replace(/[/\0]/g, '_').replace(/^-/, '_');
}

async function read(): Promise<void> {
  if (files.length === 0) return;
  state.progress.value = { state: 'loading', done: 0 };
  try {
    const opened = (await open('open'))!;
    endVerbs();
    batch(() => {
      state.columns.value = opened.columns;
      state.rowCount.value = 0;
      state.about.value = undefined;
      state.generation.value = opened.generation;
      openMessages = opened.messages;
      state.messages.value = opened.messages;
      state.progress.value = { state: 'reading', done: 0 };
      rangeIsOpen = state.range.value === undefined;
    });
  } catch (error) {
    fail(messageOf(error));
  }
}

// Uses the scale and the velocity if the format allows them. If no lines look like MA and SLO, it shows the
// busiest lines and the message of the command.
async function open(name: 'open' | 'openBehind'): Promise<Opened | undefined> {
  const all = decodeArguments(fileNames(), state.settings.value);
  const errors: unknown[] = [];
  const isWhole = state.isWhole.value;
  for (const args of all) {
    try {
      const opened = await core().ask(name, { args, anyLines: false, isWhole });
      // The user requested a scale; the velocity is an extra.
      const refused = all.length > 2 && errors.length > 0 ? messageOf(errors[0]) : '';
      return withWarning(opened, refused);
    } catch (error) {
      errors.push(error);
    }
  }
  const error = errors.at(-1);
  try {
    const opened = await core().ask(name, { args: all.at(-1)!, anyLines: true, isWhole });
    return withWarning(opened, messageOf(error));
  } catch {
    throw error;
  }
}

function withWarning(opened: Opened | undefined, warning: string): Opened | undefined {
  return opened && { ...opened, messages: `${warning}${opened.messages}` };
}

/** Shows why there is no capture. */
export function fail(message: string): void {
  batch(() => {
    state.messages.value = message;
    state.progress.value = { state: 'failed', done: 0 };
  });
}

function take(reading: Reading): void {
  if (reading.generation !== state.generation.value) return;
  batch(() => {
    state.about.value = reading.about;
    state.columns.value = reading.columns;
    state.rowCount.value = reading.rowCount;
    if (reading.messages !== '') state.messages.value = `${openMessages}${reading.messages}`;
    state.progress.value = {
      state: reading.error !== '' ? 'failed' : reading.more ? 'reading' : 'ended',
      done: reading.done,
    };
    if (reading.error !== '') state.messages.value = reading.error;
  });
  if (rangeIsOpen) void chooseRange(reading.more);
}

// How many requests the first picture shows.
const firstRequests = 3;

// Shows the first requests, or all if the capture has fewer.
async function chooseRange(more: boolean): Promise<void> {
  const rows = state.rowCount.value;
  if (rows <= firstRequests && more) return;
  rangeIsOpen = false;
  state.beginTime.value = await core().ask('beginTime', {});
  if (rows <= firstRequests) {
    state.range.value = state.wholeRange.value;
    return;
  }
  const { values } = await core().ask('column', { name: 'time_ns', from: 0, to: firstRequests + 1 });
  const from = BigInt(values[0] ?? 0);
  const to = BigInt(values[firstRequests] ?? 0);
  if (state.range.value === undefined) state.showRange({ from: from - (to - from) / 30n, to });
}
