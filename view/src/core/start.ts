// Starts workers from what the page carries: no file beside it is needed, so it works from file://.
import { Client } from './client';

declare const WORKER_SOURCE: string;

export interface Started {
  client: Client;
  worker: Worker;
  /** When the core is ready. */
  loaded: Promise<void>;
}

let address: string | undefined;

function workerAddress(): string {
  address ??= URL.createObjectURL(new Blob([WORKER_SOURCE], { type: 'text/javascript' }));
  return address;
}

/** A worker with a core of its own. */
export function newWorker(): Started {
  const worker = new Worker(workerAddress());
  const client = new Client(worker);
  const core = document.getElementById('biss-core')?.textContent ?? '';
  return { client, worker, loaded: client.ask('load', { core }) };
}
