/** A value against time, drawn from its lowest and highest values. */
import type { ReadonlySignal } from '@preact/signals';
import { firstWhere } from '../core/first_where';
import * as state from '../state';
import { fitting, Layer, numberFont, Surface, textWidth, verticalLine, type Pen } from '../wave/canvas';
import { shownCursors } from '../wave/cursors';
import type { Palette } from '../wave/palette';
import { exactTimeText, TimeScale, timeMarks } from '../wave/scale';
import { extremes, type Envelope, type Extremes } from './envelope';
import { ticksOf, valueText, type Quantity } from './ticks';

export interface PlotSpec {
  id: string;
  title: string;
  quantity: Quantity;
  unit: string;
  /** Values are drawn as dots, without a line between them. */
  dots: boolean;
}

/** The source of the values; called with the range shown, each time the plot is drawn. */
export type Source = (shown: state.Range, width: number) => Envelope | undefined;

export const gutter = 84;
export const foot = 20;
export const rightEdge = 10;

export class PlotView {
  readonly surface: Surface;
  readonly #curve = new Layer();
  #values: Envelope | undefined;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly spec: PlotSpec,
    private readonly source: Source,
    private readonly range: ReadonlySignal<state.Range | undefined>,
    /** Further data that the picture depends on. */
    more: ReadonlySignal<unknown>,
    private readonly onSummary: (text: string) => void,
  ) {
    this.surface = new Surface(canvas, (colours) => this.#draw(colours), () => [
      range.value, more.value, state.range.value, state.generation.value, state.about.value,
      state.progress.value.state, state.cursors.value,
    ]);
  }

  get scale(): TimeScale | undefined {
    const range = this.range.value;
    if (range === undefined) return undefined;
    return new TimeScale(range, this.surface.width - gutter - rightEdge);
  }

  /** The value at a place, with its time. */
  valueAt(x: number): string {
    const { scale } = this;
    const values = this.#values;
    if (scale === undefined || values === undefined || values.times.length === 0) return '';
    const offset = Number(scale.time(x - gutter) - values.from);
    const at = nearest(values.times, offset);
    const text = (value: number | undefined) =>
      valueText(value ?? NaN, this.spec.quantity, this.spec.unit);
    const [low, high] = [text(values.low[at]), text(values.high[at])];
    const time = values.from + BigInt(Math.round(values.times[at] ?? 0));
    return `${low === high ? low : `${low} to ${high}`} at ${exactTimeText(time)}`;
  }

  #draw(colours: Palette): void {
    const { context, height } = this.surface;
    const { scale } = this;
    const range = this.range.value;
    if (scale === undefined || range === undefined) return;
    this.#values = this.source(range, scale.width);
    const values = this.#values;
    const seen = values === undefined ? undefined : seenIn(values, scale);
    this.#drawWindow(scale, range, height, colours);
    this.#curve.put(this.surface, [values, range.from, range.to, colours], (layer) => {
      const pen = { context: layer, left: gutter, scale, colours };
      drawTimes(pen, height);
      if (values === undefined || seen === undefined) drawEmpty(pen, height);
      else this.#drawCurve(pen, values, padded(seen));
    });
    this.#drawCursors({ context, left: gutter, scale, colours }, height);
    this.#say(seen, range);
  }

  #drawCurve(pen: Pen, values: Envelope, bounds: Extremes): void {
    const { height } = this.surface;
    drawValues(pen, bounds, this.spec.quantity, height);
    pen.context.beginPath();
    pen.context.rect(gutter, 0, pen.scale.width, height - foot);
    pen.context.clip();
    drawEnvelope(pen, values, (value) => yOf(value, bounds, height), this.spec.dots);
  }

  #say(seen: Extremes | undefined, range: state.Range): void {
    const { title, quantity, unit } = this.spec;
    const when = `from ${exactTimeText(range.from)} to ${exactTimeText(range.to)}`;
    const text = seen === undefined
      ? `${title} ${when}: no values`
      : `${title} ${when}: ${valueText(seen.low, quantity, unit)} to ${valueText(seen.high, quantity, unit)}`;
    this.onSummary(text);
  }

  // Marks the range that the waveform shows.
  #drawWindow(scale: TimeScale, range: state.Range, height: number, colours: Palette): void {
    const shown = state.range.value;
    if (shown === undefined || (shown.from === range.from && shown.to === range.to)) return;
    const from = Math.max(0, scale.x(shown.from));
    const to = Math.min(scale.width, scale.x(shown.to));
    if (to < from) return;
    const { context } = this.surface;
    context.fillStyle = colours.accent;
    context.globalAlpha = 0.14;
    context.fillRect(gutter + from, 0, Math.max(2, to - from), height - foot);
    context.globalAlpha = 1;
  }

  #drawCursors(pen: Pen, height: number): void {
    for (const { x, colour } of shownCursors(pen, state.cursors.value)) {
      pen.context.strokeStyle = colour;
      verticalLine(pen.context, x, 0, height - foot);
    }
  }
}

function drawEmpty({ context, scale, colours }: Pen, height: number): void {
  context.font = numberFont;
  context.fillStyle = colours.muted;
  context.fillText('no values here', gutter + scale.width / 2 - 45, (height - foot) / 2);
}

function drawTimes({ context, scale, colours }: Pen, height: number): void {
  const { marks, base } = timeMarks(scale, 80);
  context.font = numberFont;
  context.strokeStyle = colours.grid;
  context.lineWidth = 1;
  context.fillStyle = colours.muted;
  if (base !== undefined) {
    const text = fitting(context, [`${base} +`], gutter - 6);
    if (text !== undefined) context.fillText(text, 4, height - foot / 2);
  }
  for (const { x, text } of marks) {
    verticalLine(context, gutter + x, 0, height - foot + 4);
    const width = textWidth(context, text);
    const place = Math.max(gutter - 10, Math.min(gutter + x - width / 2, gutter + scale.width + rightEdge - width));
    context.fillText(text, place, height - foot / 2 + 1);
  }
}

function drawValues({ context, scale, colours }: Pen, bounds: Extremes, quantity: Quantity, height: number): void {
  const { values, text } = ticksOf(bounds.low, bounds.high, (height - foot) / 28, quantity);
  context.font = numberFont;
  for (const value of values) {
    const y = Math.round(yOf(value, bounds, height)) + 0.5;
    context.strokeStyle = colours.grid;
    context.beginPath();
    context.moveTo(gutter - 4, y);
    context.lineTo(gutter + scale.width, y);
    context.stroke();
    context.fillStyle = colours.muted;
    if (y < 6 || y > height - foot - 4) continue;
    const label = text(value);
    context.fillText(label, Math.max(0, gutter - 8 - textWidth(context, label)), y, gutter - 8);
  }
}

function nearest(times: Float64Array, sought: number): number {
  const low = firstWhere(times.length - 1, (i) => (times[i] ?? 0) >= sought);
  const before = Math.max(0, low - 1);
  const isBefore = sought - (times[before] ?? 0) < (times[low] ?? 0) - sought;
  return isBefore ? before : low;
}

function yOf(value: number, { low, high }: Extremes, height: number): number {
  return (1 - (value - low) / (high - low)) * (height - foot - 8) + 4;
}

function padded({ low, high }: Extremes): Extremes {
  const room = low === high ? Math.max(Math.abs(low) * 1e-3, 1) : (high - low) * 0.06;
  return { low: low - room, high: high + room };
}

// The extremes of the values in the picture.
function seenIn({ from, times, low, high }: Envelope, scale: TimeScale): Extremes | undefined {
  const begin = Number(scale.from - from);
  const first = firstWhere(times.length, (i) => (times[i + 1] ?? Infinity) >= begin);
  const end = firstWhere(times.length, (i) => (times[i] ?? 0) > begin + scale.span);
  const seen = extremes(low.subarray(first, end), high.subarray(first, end));
  return Number.isNaN(seen.low) ? undefined : seen;
}

type Context = CanvasRenderingContext2D;

// Points to pixels.
interface Place {
  x: (i: number) => number;
  y: (value: number) => number;
}

// Few values as a line, many as a band from the lowest to the highest.
function drawEnvelope(pen: Pen, values: Envelope, y: (value: number) => number, dots: boolean): void {
  const { context, left, scale, colours } = pen;
  const shift = Number(scale.from - values.from);
  const x = (i: number) => left + ((values.times[i] ?? 0) - shift) * scale.pixelsPerPs;
  const count = values.times.length;
  const length = (values.times[count - 1] ?? 1) - (values.times[0] ?? 0);
  const shown = count * (scale.span / Math.max(1, length));
  context.strokeStyle = colours.accent;
  context.fillStyle = colours.accent;
  if (dots || shown < scale.width / 5) drawDots(context, values, { x, y });
  if (dots) return;
  if (shown > scale.width / 2) drawBand(context, values, { x, y }, left, scale.width);
  else drawCurve(context, values, { x, y });
}

function drawDots(context: Context, values: Envelope, { x, y }: Place): void {
  values.high.forEach((high, i) => {
    if (!Number.isNaN(high)) context.fillRect(x(i) - 2, y(high) - 2, 4, 4);
  });
}

function drawCurve(context: Context, values: Envelope, { x, y }: Place): void {
  context.lineWidth = 1.5;
  context.lineJoin = 'round';
  context.beginPath();
  let isDrawing = false;
  values.low.forEach((low, i) => {
    const high = values.high[i] ?? NaN;
    if (Number.isNaN(low)) {
      isDrawing = false;
      return;
    }
    if (isDrawing) context.lineTo(x(i), y(low));
    else context.moveTo(x(i), y(low));
    if (high !== low) context.lineTo(x(i), y(high));
    isDrawing = true;
  });
  context.stroke();
}

// A column a pixel, which touches the one before.
function drawBand(context: Context, values: Envelope, { x, y }: Place, left: number, width: number): void {
  const top = new Float64Array(Math.ceil(width) + 1).fill(Infinity);
  const bottom = new Float64Array(top.length).fill(-Infinity);
  values.low.forEach((low, i) => {
    const at = Math.floor(x(i) - left);
    if (at < 0 || at >= top.length || Number.isNaN(low)) return;
    top[at] = Math.min(top[at] ?? Infinity, y(values.high[i] ?? low));
    bottom[at] = Math.max(bottom[at] ?? -Infinity, y(low));
  });
  let before = -1;
  for (let at = 0; at < top.length; at += 1) {
    let high = top[at] ?? Infinity;
    let low = bottom[at] ?? -Infinity;
    if (high > low) continue;
    if (before >= 0 && at - before <= 3) {
      high = Math.min(high, bottom[before] ?? high);
      low = Math.max(low, top[before] ?? low);
      for (let between = before + 1; between < at; between += 1) {
        context.fillRect(left + between, high, 1, Math.max(1.5, low - high));
      }
    }
    context.fillRect(left + at, high, 1, Math.max(1.5, low - high));
    before = at;
  }
}
