// The names that -f accepts.
import { signal } from '@preact/signals';
import { core } from '../core/core';

export const encoders = signal<readonly string[]>([]);

/** Asks the core for them, once. */
export async function loadEncoders(): Promise<void> {
  const { out } = await core().ask('run', { args: ['encoders', '--to', 'jsonl'] });
  const lines = new TextDecoder().decode(out).split('\n').filter((line) => line !== '');
  encoders.value = lines.flatMap((line) => {
    const name = (JSON.parse(line) as Record<string, unknown>)['name'];
    return typeof name === 'string' ? [name] : [];
  });
}
