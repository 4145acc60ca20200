/** Values of an axis: round marks, and texts with a unit that fits. */
import { roundStep, timeUnits, unitOf, type Units } from '../wave/scale';

/** The kind of a value, which gives its notation. */
export type Quantity = 'time' | 'rate' | 'number';

const units: Record<Quantity, Units> = {
  time: timeUnits,
  rate: [['MHz', 1e6], ['kHz', 1e3], ['Hz', 1]],
  number: [['', 1]],
};

// A single count is exact; at an axis it is short.
function shortOf(size: number): [string, number] {
  if (size >= 1e10) return ['G', 1e9];
  return size >= 1e7 ? ['M', 1e6] : ['', 1];
}

function grouped(text: string): string {
  return text.replace(/\B(?=(\d{3})+(?!\d|.*\.))/g, '\u202f');
}

/** At most about `count` marks from `low` to `high`; `text` writes a value as finely as the marks are. */
export function ticksOf(low: number, high: number, count: number, quantity: Quantity) {
  const step = roundStep(Math.max((high - low) / Math.max(1, count), Number.MIN_VALUE));
  const size = Math.max(Math.abs(low), Math.abs(high));
  const [unit, factor] = quantity === 'number' ? shortOf(size) : unitOf(size, units[quantity]);
  const places = Math.min(12, Math.max(0, Math.ceil(-Math.log10(step / factor) - 1e-9)));
  const values: number[] = [];
  for (let i = Math.ceil(low / step); i * step <= high && values.length < 50; i += 1) values.push(i * step);
  const text = (value: number) => {
    const scaled = value / factor;
    if (Math.abs(scaled) >= 1e12) return scaled.toPrecision(6);
    const number = scaled.toFixed(places).replace(/^-(?=[0.]*$)/, '').replace('-', '−');
    return unit === '' ? grouped(number) : `${number} ${unit}`;
  };
  return { values, text };
}

/** One value, with enough digits to distinguish it from its neighbours. */
export function valueText(value: number, quantity: Quantity, unit: string): string {
  if (Number.isNaN(value)) return '–';
  const [name, factor] = unitOf(value, units[quantity]);
  const scaled = value / factor;
  const digits = Number.isInteger(scaled) ? 0 : Math.max(0, 4 - Math.floor(Math.log10(Math.abs(scaled) || 1)));
  const number = grouped(scaled.toFixed(Math.min(12, digits))).replace('-', '−');
  return [number, name === '' ? unit : name].filter((text) => text !== '').join(' ');
}
