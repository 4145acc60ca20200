// Starts the page.
import './theme.css';
import './shell/shell.css';
import { render } from 'preact';
import { start } from './core/reading';
import { App } from './shell/app';
import { listenToKeys } from './shell/keys';
import { followLink } from './shell/link';
import { watchTheme } from './shell/theme';

start();
watchTheme();
listenToKeys();
render(<App />, document.getElementById('page')!);
void followLink();
