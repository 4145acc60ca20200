/** Colours of the canvases. Every text has a contrast of at least 4.5 on its ground. */

export interface Palette {
  ground: string;
  raised: string;
  text: string;
  soft: string;
  grid: string;
  ma: string;
  slo: string;
  bad: string;
  warn: string;
  good: string;
  select: string;
  cursorA: string;
  cursorB: string;
  /** Fills of parts of a cycle, by their kind, and of rows that failed or have a flag. */
  fill: { line: string; frame: string; data: string; flag: string; crc: string; wrong: string; warn: string };
}

const light: Palette = {
  ground: '#ffffff',
  raised: '#f6f8fa',
  text: '#1f2328',
  soft: '#59636e',
  grid: '#e4e8ec',
  ma: '#3d444d',
  slo: '#0757c8',
  bad: '#c4141f',
  warn: '#8a5a00',
  good: '#1a7f37',
  select: '#0757c8',
  cursorA: '#7a3db8',
  cursorB: '#00696f',
  fill: {
    line: '#eceff2',
    frame: '#eceff2',
    data: '#d9e6f9',
    flag: '#f5ebcf',
    crc: '#dcefe1',
    wrong: '#fbdcdd',
    warn: '#f8e7bd',
  },
};

const dark: Palette = {
  ground: '#0d1117',
  raised: '#161b22',
  text: '#e6edf3',
  soft: '#9aa4af',
  grid: '#252c35',
  ma: '#c9d1d9',
  slo: '#79c0ff',
  bad: '#ff8f87',
  warn: '#e3b341',
  good: '#56d364',
  select: '#79c0ff',
  cursorA: '#d2a8ff',
  cursorB: '#5ce0d8',
  fill: {
    line: '#262d36',
    frame: '#262d36',
    data: '#12305a',
    flag: '#40330f',
    crc: '#113a20',
    wrong: '#5c1a1d',
    warn: '#4d3a08',
  },
};

export function paletteOf(theme: 'light' | 'dark'): Palette {
  return theme === 'dark' ? dark : light;
}
