// Starts the page.
import './theme.css';
import './shell/shell.css';
import { render } from 'preact';
import { start } from './core/reading';
import { App } from './shell/app';
import { loadEncoders } from './shell/encoders';
import { listenToKeys } from './shell/keys';
import { followLink } from './shell/link';
import { followSearch } from './shell/search';
import { followRows } from './shell/table_rows';
import { watchTheme } from './shell/theme';

void start().then(loadEncoders, () => {});
followRows();
followSearch();
watchTheme();
listenToKeys();
render(<App />, document.getElementById('page')!);
void followLink();
