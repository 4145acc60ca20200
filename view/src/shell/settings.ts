// Changes the settings of the capture, and reads it again at once.
import { reopen } from '../core/reading';
import * as state from '../state';

export function changeSettings(change: Partial<state.Settings>): void {
  const now = state.settings.value;
  const next = { ...now, ...change };
  if (JSON.stringify(next) === JSON.stringify(now)) return;
  state.settings.value = next;
  void reopen();
}
