// The worker that reads the capture, as the page uses it.
import type { Client } from './client';
import { newWorker } from './start';

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
