/** Which plots there are for the columns of a capture. */
import type { Column } from 'biss';
import type { PlotSpec } from './plot_view';
import type { Quantity } from './ticks';

export interface ColumnPlot extends PlotSpec {
  column: string;
}

interface Kind {
  pattern: RegExp;
  title: string;
  quantity: Quantity;
}

const kinds: readonly Kind[] = [
  { pattern: /^position(_deg|_mm)?$/, title: 'Position', quantity: 'number' },
  { pattern: /^velocity_/, title: 'Velocity', quantity: 'number' },
  { pattern: /^position[2-8]$/, title: 'Position of channel', quantity: 'number' },
  { pattern: /^line_delay_ns$/, title: 'Line delay', quantity: 'time' },
  { pattern: /^ack_ns$/, title: 'ACK', quantity: 'time' },
  { pattern: /^clock_hz$/, title: 'Clock', quantity: 'rate' },
];

/** Position and the like where the capture has them; degrees and millimetres instead of counts. */
export function columnPlots(columns: readonly Column[]): ColumnPlot[] {
  const scaled = columns.some(({ name }) => /^position_(deg|mm)$/.test(name));
  return kinds.flatMap(({ pattern, title, quantity }) =>
    columns
      .filter(({ name }) => pattern.test(name) && !(scaled && name === 'position'))
      .map(({ name, valueUnit }) => ({
        id: name,
        title: [title, /^position(\d)$/.exec(name)?.[1] ?? ''].join(' ').trim(),
        quantity,
        unit: quantity === 'number' ? valueUnit : '',
        dots: false,
        column: name,
      })));
}
