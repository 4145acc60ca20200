// The text that a screen reader speaks after a change outside the focus.
import { signal } from '@preact/signals';

export const announcement = signal('');

/** Has this said, once what is being said has ended. */
export function announce(text: string): void {
  announcement.value = text;
}
