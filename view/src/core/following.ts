// A capture of the page's own server, watched: it may grow, and it is named when it changes otherwise.
import { signal } from '@preact/signals';
import * as state from '../state';
import { isServed, readOn } from './reading';
import type { ServedFile } from './source';

const pauseMilliseconds = 500;

/** The page continues to read the file as it grows. */
export const isFollowing = signal(false);

/**
 * Asks the server for the size, until another capture is opened or the server ends. If reading the file takes
 * long, it asks less often.
 */
export async function watchServed(name: string, file: ServedFile, sizeAddress: string): Promise<void> {
  let { size } = file;
  let pause = pauseMilliseconds;
  for (;;) {
    await new Promise((resolve) => { setTimeout(resolve, pause); });
    const begun = performance.now();
    const answer = await ask(sizeAddress);
    if ('problem' in answer) {
      isFollowing.value = false;
      if (!isServed(file)) return;
      state.messages.value = answer.problem;
      if (answer.failed) state.progress.value = { state: 'failed', done: 0 };
      return;
    }
    const isBusy = ['loading', 'reading'].includes(state.progress.value.state);
    if (answer.size === size || isBusy) continue;
    size = answer.size;
    if (!await readOn(name, { address: file.address, size })) {
      isFollowing.value = false;
      return;
    }
    pause = Math.max(pauseMilliseconds, performance.now() - begun);
  }
}

type Answer = { size: number } | { problem: string; failed: boolean };

async function ask(address: string): Promise<Answer> {
  try {
    const response = await fetch(address, { cache: 'no-store' });
    const text = await response.text();
    if (response.ok) return { size: Number(text) };
    return { problem: `biss: ${text.trim()}`, failed: true };
  } catch {
    return { problem: 'biss view has ended. The data so far stay here.', failed: false };
  }
}
