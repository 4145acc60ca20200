// Verbs that read the whole file run in a worker of their own, so that the waveform stays fluid. A
// new capture, or other settings, end the run that is under way.
import type { RunResult } from 'biss';
import { CoreError, type Client } from './client';
import { newWorker } from './core';
import type { Content } from './source';

export interface NamedContent {
  name: string;
  content: Content;
}

/** The files of the capture, which the verbs read. */
let files: readonly NamedContent[] = [];
// The worker, once it is needed.
let verbs: { worker: Worker; client: Client; ready: Promise<Client> } | undefined;
let underWay = 0;
let making = 0;

export function setVerbFiles(given: readonly NamedContent[]): void {
  const old = files;
  files = given;
  endVerbs();
  if (verbs === undefined) return;
  verbs.ready = verbs.ready.then(async (core) => {
    for (const { name } of old) await core.ask('removeFile', { name });
    for (const file of given) await core.ask('addFile', file);
    return core;
  });
}

/**
 * Ends the run that is under way; its promise never settles. An idle worker is kept, and so is a
 * worker that makes a new capture.
 */
export function endVerbs(): void {
  if (underWay === 0 || making > 0) return;
  verbs?.worker.terminate();
  verbs?.client.close();
  verbs = undefined;
  underWay = 0;
}

/** Runs steps that make a new capture, which nothing ends. */
export async function makeCapture<T>(steps: () => Promise<T>): Promise<T> {
  making += 1;
  try {
    return await steps();
  } finally {
    making -= 1;
  }
}

function ready(): Promise<Client> {
  if (verbs === undefined) {
    const { worker, client, loaded } = newWorker();
    const hasFiles = loaded.then(async () => {
      for (const file of files) await client.ask('addFile', file);
      return client;
    });
    verbs = { worker, client, ready: hasFiles };
  }
  return verbs.ready;
}

/** Runs a verb on the files of the capture. */
export async function runVerb(args: string[]): Promise<RunResult> {
  const core = await ready();
  const own = verbs;
  underWay += 1;
  try {
    return await core.ask('run', { args });
  } finally {
    if (own === verbs) underWay -= 1;
  }
}

/** Gives the verbs a file that is not part of the capture. */
export async function writeFile(name: string, content: Uint8Array): Promise<void> {
  await (await ready()).ask('addFile', { name, content });
}

/** Runs a verb that writes a file, and takes the file. @throws CoreError with its message */
export async function runToFile(args: string[], name: string): Promise<Uint8Array> {
  const { status, err } = await runVerb(args);
  if (status !== 0) throw new CoreError(err, status);
  const core = await ready();
  const bytes = await core.ask('readFile', { name });
  await core.ask('removeFile', { name });
  return bytes;
}

/** Runs a verb on a file that is not a capture, such as a dump of registers. */
export async function runOnFile(file: NamedContent, args: string[]): Promise<RunResult> {
  const core = await ready();
  await core.ask('addFile', file);
  try {
    return await runVerb(args);
  } finally {
    await core.ask('removeFile', { name: file.name });
  }
}
