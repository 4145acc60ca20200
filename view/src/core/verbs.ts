// Verbs that read the whole file run in a worker of their own, so that the waveform stays fluid. A
// new run ends the one under way.
import type { RunResult } from 'biss';
import { Client, CoreError } from './client';
import type { Content } from './source';
import { newWorker } from './start';

export interface NamedContent {
  name: string;
  content: Content;
}

/** The files of the capture, which the verbs read. */
let files: readonly NamedContent[] = [];
let client: Promise<Client> | undefined;
let worker: Worker | undefined;

export function setVerbFiles(given: readonly NamedContent[]): void {
  files = given;
  stopVerbs();
}

/** Ends what is under way; its promise never settles. */
export function stopVerbs(): void {
  worker?.terminate();
  worker = undefined;
  client = undefined;
}

async function started(): Promise<Client> {
  const next = newWorker();
  worker = next.worker;
  await next.loaded;
  for (const file of files) await next.client.ask('addFile', file);
  return next.client;
}

async function ready(): Promise<Client> {
  client ??= started();
  return client;
}

/** Runs a verb on the files of the capture. */
export async function runVerb(args: string[]): Promise<RunResult> {
  return (await ready()).ask('run', { args });
}

/** Gives the verbs a file that is no part of the capture. */
export async function writeFile(name: string, content: Uint8Array): Promise<void> {
  await (await ready()).ask('addFile', { name, content });
}

/** Runs a verb that writes a file, and takes the file. @throws CoreError with its message */
export async function runToFile(args: string[], name: string): Promise<Uint8Array> {
  const core = await ready();
  const { status, err } = await core.ask('run', { args });
  if (status !== 0) throw new CoreError(err, status);
  const bytes = await core.ask('readFile', { name });
  await core.ask('removeFile', { name });
  return bytes;
}

/** Runs a verb on a file that is no capture, such as a dump of registers. */
export async function runOnFile(file: NamedContent, args: string[]): Promise<RunResult> {
  const core = await ready();
  await core.ask('addFile', file);
  try {
    return await core.ask('run', { args });
  } finally {
    await core.ask('removeFile', { name: file.name });
  }
}
