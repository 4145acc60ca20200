// The text that a screen reader speaks after a change outside the focus.
import { signal } from '@preact/signals';

export const announcement = signal('');

/** Lets the screen reader say this after its present text. */
export function announce(text: string): void {
  announcement.value = text;
}
