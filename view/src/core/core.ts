// Workers, started from a source inside the page: the page needs no other file, so it works from file://. One
// of them reads the capture.
import { Client } from './client';

declare const WORKER_SOURCE: string;

let address: string | undefined;

/** A worker with a core of its own, which is ready when it is `loaded`. */
export function newWorker() {
  address ??= URL.createObjectURL(new Blob([WORKER_SOURCE], { type: 'text/javascript' }));
  const worker = new Worker(address);
  const client = new Client(worker);
  const core = document.getElementById('biss-core')?.textContent ?? '';
  return { client, worker, loaded: client.ask('load', { core }) };
}

let client: Client | undefined;

/** Starts the worker; resolves when the core is ready. */
export function startCore(): Promise<void> {
  const started = newWorker();
  client = started.client;
  return started.loaded;
}

/** The client; the page starts it before it draws. */
export function core(): Client {
  if (client === undefined) throw new Error('the core has not been started');
  return client;
}
