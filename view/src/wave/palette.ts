/** Colours of the canvases, from theme.css. Every text has a contrast of at least 4.5 on its ground. */

// The variables of theme.css that canvases use.
const names = [
  'page', 'surface', 'text', 'muted', 'grid', 'ma', 'accent', 'error', 'warn', 'good', 'cursor-a', 'cursor-b',
  'fill-line', 'fill-data', 'fill-flag', 'fill-crc', 'fill-wrong', 'fill-warn',
] as const;

export type Palette = Record<(typeof names)[number], string>;

const palettes = new Map<string, Palette>();

/** The colours of the theme that is shown: the same object for the same theme. */
export function paletteOf(theme: 'light' | 'dark'): Palette {
  const style = getComputedStyle(document.documentElement);
  const colourOf = (name: string) => style.getPropertyValue(`--${name}`).trim();
  const palette = palettes.get(theme)
    ?? (Object.fromEntries(names.map((name) => [name, colourOf(name)])) as Palette);
  palettes.set(theme, palette);
  return palette;
}
