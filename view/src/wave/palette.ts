/** Colours of the canvases, from theme.css. Every text has a contrast of at least 4.5 on its ground. */

// The variable of each colour.
const variables = {
  ground: 'page',
  raised: 'surface',
  text: 'text',
  soft: 'muted',
  grid: 'grid',
  ma: 'ma',
  slo: 'accent',
  bad: 'error',
  warn: 'warn',
  good: 'good',
  select: 'accent',
  cursorA: 'cursor-a',
  cursorB: 'cursor-b',
};

// The colours of parts of a cycle, by their kind, and of rows that failed or have a flag.
const fills = {
  line: 'fill-line',
  frame: 'fill-line',
  data: 'fill-data',
  flag: 'fill-flag',
  crc: 'fill-crc',
  wrong: 'fill-wrong',
  warn: 'fill-warn',
};

export type Palette = Record<keyof typeof variables, string> & { fill: Record<keyof typeof fills, string> };

const palettes = new Map<string, Palette>();

/** The colours of the theme that is shown: the same object for the same theme. */
export function paletteOf(theme: 'light' | 'dark'): Palette {
  const style = getComputedStyle(document.documentElement);
  const coloursOf = <T extends Record<string, string>>(names: T) => Object.fromEntries(
    Object.entries(names).map(([name, variable]) => [name, style.getPropertyValue(`--${variable}`).trim()]),
  ) as Record<keyof T, string>;
  const palette = palettes.get(theme) ?? { ...coloursOf(variables), fill: coloursOf(fills) };
  palettes.set(theme, palette);
  return palette;
}
