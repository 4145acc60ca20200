// Files that the user chooses or drops.
import { openFiles } from '../core/reading';
import * as state from '../state';
import { leaveSimulation } from './examples';
import { opened } from './link';

/** Opens files of the user; several are one capture, a line or more in each. */
export async function openUserFiles(list: readonly File[]): Promise<void> {
  if (list.length === 0) return;
  leaveSimulation();
  const same = list.length === 1 && list[0]!.name === state.file.value?.name;
  // Lines and format belong to a capture, so another file resets them. The settings of a link are kept.
  if (!same && state.file.value !== undefined) state.settings.value = state.defaultSettings;
  await openFiles(list.map((file) => ({ name: file.name, content: file })));
  opened();
}

/** Asks for files by the dialog of the browser. */
export function chooseFiles(): void {
  document.querySelector<HTMLInputElement>('#choose-files')?.click();
}
