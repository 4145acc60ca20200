/** Draws the values of a plot: few values as a line, many as a band from the lowest to the highest. */
import type { Pen } from '../wave/canvas';
import type { Envelope } from './envelope';

type Context = CanvasRenderingContext2D;

/** Points to pixels. */
interface Place {
  x: (i: number) => number;
  y: (value: number) => number;
}

export function drawEnvelope(pen: Pen, values: Envelope, y: (value: number) => number, dots: boolean): void {
  const { context, left, scale, colours } = pen;
  const shift = Number(scale.from - values.from);
  const x = (i: number) => left + ((values.times[i] ?? 0) - shift) * scale.pixelsPerPs;
  const count = values.times.length;
  const length = (values.times[count - 1] ?? 1) - (values.times[0] ?? 0);
  const shown = count * (scale.span / Math.max(1, length));
  context.strokeStyle = colours.slo;
  context.fillStyle = colours.slo;
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
