// The head of the page: files, search, export, link, theme, help.
import * as state from '../state';
import { exportActions } from './export';
import { chooseFiles, openUserFiles } from './files';
import { FormatBar } from './format_bar';
import { showHelp } from './help';
import { defineKeys } from './keys';
import { linkText } from './link';
import { Menu } from './menu';
import { SearchField } from './search_field';
import { exampleActions, showSimulate } from './simulate';

function toggleTheme(): void {
  state.theme.value = state.shownTheme.value === 'dark' ? 'light' : 'dark';
}

async function copyLink(): Promise<void> {
  const address = `${location.href.split('#')[0]}#${linkText()}`;
  history.replaceState(null, '', address);
  try {
    await navigator.clipboard.writeText(address);
    state.announcement.value = 'The link is copied.';
  } catch {
    state.announcement.value = 'The link is in the address bar.';
  }
}

defineKeys('page', [
  { keys: ['o', 'Ctrl+o'], help: 'Open a capture', run: chooseFiles },
  { keys: ['s'], help: 'Simulate a capture', run: showSimulate },
  { keys: ['f'], help: 'Change the format', run: () => document.getElementById('format')?.focus() },
  { keys: ['l'], help: 'Copy a link to this view', run: () => void copyLink() },
  { keys: ['t'], help: 'Dark or light', run: toggleTheme },
  { keys: ['g'], help: 'Go to the table', run: () => document.getElementById('table')?.focus() },
  { keys: ['?', 'F1'], help: 'Show the keys', run: showHelp },
]);

export function Header() {
  const file = state.file.value;
  return (
    <header>
      <div class="top">
        <h1 class="brand">biss</h1>
        <button type="button" class="primary" onClick={chooseFiles}>Open …</button>
        <input id="choose-files" type="file" multiple hidden
          onChange={(event) => {
            void openUserFiles([...(event.currentTarget.files ?? [])]);
            event.currentTarget.value = '';
          }} />
        <Menu label="Examples" actions={exampleActions} />
        <span class="file" title={file?.name}>{file === undefined ? '' : file.example === undefined ? file.name : 'simulated capture'}</span>
        <span class="grow" />
        {file !== undefined && <SearchField />}
        {file !== undefined && <Menu label="Export" actions={exportActions} />}
        {file !== undefined && <button type="button" title="Copy a link to this view" onClick={() => void copyLink()}>Link</button>}
        <button type="button" class="icon" aria-label="Dark or light" title="Dark or light" onClick={toggleTheme}>◐</button>
        <button type="button" class="icon" aria-label="Keys and help" title="Keys and help" onClick={showHelp}>?</button>
      </div>
      {file !== undefined && <FormatBar />}
    </header>
  );
}
