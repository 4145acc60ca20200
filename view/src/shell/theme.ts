// Dark or light: the system's choice, until the user chooses.
import { effect } from '@preact/signals';
import { shownTheme, systemIsDark, theme } from '../state';

export function watchTheme(): void {
  const query = matchMedia('(prefers-color-scheme: dark)');
  systemIsDark.value = query.matches;
  query.addEventListener('change', () => { systemIsDark.value = query.matches; });
  effect(() => { document.documentElement.dataset['theme'] = shownTheme.value; });
}

export function toggleTheme(): void {
  theme.value = shownTheme.value === 'dark' ? 'light' : 'dark';
}
