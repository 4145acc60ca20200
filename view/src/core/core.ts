// The one client of the page.
import { Client } from './client';

let client: Client | undefined;

/** Sets the client, once, before anything is drawn. */
export function startCore(worker: Worker): Client {
  client = new Client(worker);
  return client;
}

/** The client; the page starts it before it draws. */
export function core(): Client {
  if (client === undefined) throw new Error('the core has not been started');
  return client;
}
