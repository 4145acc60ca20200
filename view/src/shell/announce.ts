// What a screen reader says when something has changed that is not in focus.
import { signal } from '@preact/signals';

export const announcement = signal('');

/** Has this said, once what is being said has ended. */
export function announce(text: string): void {
  announcement.value = text;
}
