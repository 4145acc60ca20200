/** The axis of time and the lines MA and SLO. */
import { firstWhere } from '../core/first_where';
import { font, hatch, numberFont, textWidth, verticalLine, type Pen } from './canvas';
import type { Lane } from './lanes';
import { timeMarks, type TimeScale } from './scale';
import type { LineTile } from './tiles';

type Context = CanvasRenderingContext2D;

/** Marks of the time, with lines through all lanes. */
export function drawAxis({ context, left, scale, colours }: Pen, lane: Lane, bottom: number): void {
  const { marks, base } = timeMarks(scale, 110);
  const middle = lane.top + lane.height / 2;
  context.font = numberFont;
  context.strokeStyle = colours.grid;
  context.lineWidth = 1;
  for (const mark of marks) verticalLine(context, left + mark.x, lane.top + lane.height, bottom);
  context.fillStyle = colours.muted;
  const baseText = base === undefined ? '' : `${base} +`;
  const free = left + (base === undefined ? 0 : textWidth(context, baseText) + 8);
  for (const mark of marks) {
    const width = textWidth(context, mark.text);
    const x = Math.max(left, Math.min(left + mark.x - width / 2, left + scale.width - width));
    if (x >= free) context.fillText(mark.text, x, middle);
  }
  if (base !== undefined) {
    context.fillStyle = colours.text;
    context.fillText(baseText, left, middle);
  }
}

// A level that lasts for fewer pixels is part of a filled stretch.
const leastPixels = 2;

/** A line; several changes within a few pixels are a filled stretch. */
export function drawLine({ context, left, scale }: Pen, lane: Lane, tile: LineTile, colour: string): void {
  const pieces = piecesOf(left, tile, scale);
  context.save();
  context.beginPath();
  context.rect(left, lane.top - 2, scale.width, lane.height + 4);
  context.clip();
  context.strokeStyle = colour;
  context.fillStyle = colour;
  context.globalAlpha = 0.55;
  for (const { from, to, shown } of pieces) {
    if (shown === busy) context.fillRect(from, lane.top, Math.max(1, to - from), lane.height);
  }
  context.globalAlpha = 1;
  strokeLevels(context, lane, pieces);
  context.lineWidth = 1;
  for (const { from, to, shown } of pieces) {
    if (shown === unknown) hatch(context, from, lane.top, to - from, lane.height);
  }
  context.restore();
}

const unknown = 2;
const busy = 3;

/** A stretch of a line in pixels. */
interface Piece {
  from: number;
  to: number;
  /** As LineView::levels. */
  shown: number;
}

function piecesOf(left: number, tile: LineTile, scale: TimeScale): Piece[] {
  const { times, levels } = tile;
  const shift = Number(scale.from - tile.from);
  const right = left + scale.width + 4;
  const x = (time: number) => left + (time - shift) * scale.pixelsPerPs;
  const pieces: Piece[] = [];
  let last: Piece | undefined;
  // The last entry that begins at or before the left end.
  const first = Math.max(0, firstWhere(times.length, (i) => (times[i] ?? 0) > shift) - 1);
  for (let i = first; i < times.length; i += 1) {
    const begin = x(times[i] ?? 0);
    if (begin > right) break;
    const from = Math.max(left - 4, begin);
    const end = x(times[i + 1] ?? tile.end);
    const to = Math.min(right, end);
    const shown = end - begin < leastPixels ? busy : levels[i] ?? unknown;
    if (last?.shown === busy && shown === busy) {
      last.to = to;
    } else {
      last = { from, to, shown };
      pieces.push(last);
    }
  }
  return pieces;
}

function strokeLevels(context: Context, lane: Lane, pieces: readonly Piece[]): void {
  const high = lane.top + 1;
  const low = lane.top + lane.height - 1;
  context.lineWidth = 1.5;
  context.lineJoin = 'miter';
  context.beginPath();
  let before: number | undefined;
  for (const { from, to, shown } of pieces) {
    const y = shown === 1 ? high : shown === 0 ? low : undefined;
    if (y !== undefined) {
      if (before === undefined) context.moveTo(from, y);
      else context.lineTo(from, y);
      context.lineTo(to, y);
    }
    before = y;
  }
  context.stroke();
}

/** The change of a line after a time, or before it; undefined if no such change is known. */
export function changeBeside({ from, times }: LineTile, time: bigint, step: 1 | -1): bigint | undefined {
  const offset = Number(time - from);
  const found = times[step > 0
    ? firstWhere(times.length, (i) => (times[i] ?? 0) > offset)
    : firstWhere(times.length, (i) => (times[i] ?? 0) >= offset) - 1];
  return found === undefined ? undefined : from + BigInt(found);
}

/** The names at the left. */
export function drawNames(
  { context, left, colours }: Omit<Pen, 'scale'>,
  lanes: readonly Lane[],
  far: boolean,
  names: ReadonlyMap<string, string>,
  height: number,
): void {
  context.fillStyle = colours.surface;
  context.fillRect(0, 0, left - 4, height);
  context.fillStyle = colours.text;
  context.font = `600 ${font}`;
  for (const lane of lanes) {
    const name = far ? lane.farName : lane.name;
    context.fillText(names.get(name) ?? name, 10, lane.top + lane.height / 2, left - 18);
  }
}
