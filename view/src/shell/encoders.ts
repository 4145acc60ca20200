// The names that -f accepts.
import { signal } from '@preact/signals';
import { core } from '../core/core';
import { decoded, objectsOf } from '../core/texts';

export const encoders = signal<readonly string[]>([]);

/** Asks the core for them, once. */
export async function loadEncoders(): Promise<void> {
  const { out } = await core().ask('run', { args: ['encoders', '--to', 'jsonl'] });
  encoders.value = objectsOf<{ name: string }>(decoded(out)).map(({ name }) => name);
}
