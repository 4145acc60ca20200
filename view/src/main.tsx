// Starts the page.
import './theme.css';
import './shell/shell.css';
import { effect } from '@preact/signals';
import { render } from 'preact';
import { Superseded, watchWaiting } from './core/client';
import { start } from './core/reading';
import { App } from './shell/app';
import { loadEncoders } from './shell/encoders';
import { holdLoad } from './shell/hold_load';
import { listenToKeys } from './shell/keys';
import { followLink } from './shell/link';
import { followSearch } from './shell/search';
import { followRows } from './shell/table_rows';
import { file, shownTheme, systemIsDark } from './state';

void start().then(loadEncoders, () => {});
followRows();
followSearch();
listenToKeys();
// Dark or light: the system's choice, until the user chooses.
const systemTheme = matchMedia('(prefers-color-scheme: dark)');
systemIsDark.value = systemTheme.matches;
systemTheme.addEventListener('change', () => { systemIsDark.value = systemTheme.matches; });
effect(() => { document.documentElement.dataset['theme'] = shownTheme.value; });
effect(() => { document.title = file.value === undefined ? 'biss' : `${file.value.name} – biss`; });
// The page shows whether a request to the core is open.
watchWaiting((isWaiting) => document.documentElement.toggleAttribute('data-waiting', isWaiting));
// A request about a capture that is no longer open needs no answer.
addEventListener('unhandledrejection', (event) => {
  if (event.reason instanceof Superseded) event.preventDefault();
});
render(<App />, document.getElementById('page')!);
if (document.querySelector('#biss-capture:not([data-live])') !== null) holdLoad();
void followLink();
