/** The axis of time and the lines MA and SLO. */
import { font, hatch, numberFont, textWidth, verticalLine } from './canvas';
import type { Lane } from './lanes';
import type { Palette } from './palette';
import { timeMarks, type TimeScale } from './scale';
import type { LineTile } from './tiles';

type Context = CanvasRenderingContext2D;

/** Marks of the time, with lines through all lanes. */
export function drawAxis(
  context: Context,
  lane: Lane,
  left: number,
  bottom: number,
  scale: TimeScale,
  colours: Palette,
): void {
  const { marks, base } = timeMarks(scale, 110);
  const middle = lane.top + lane.height / 2;
  context.font = numberFont;
  context.textBaseline = 'middle';
  context.strokeStyle = colours.grid;
  context.lineWidth = 1;
  for (const mark of marks) verticalLine(context, left + mark.x, lane.top + lane.height, bottom);
  context.fillStyle = colours.soft;
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

interface Paths {
  line: Path2D;
  busy: Path2D;
  unknown: [number, number][];
}

/** A line; several changes within a pixel are a filled stretch. */
export function drawLine(
  context: Context,
  lane: Lane,
  left: number,
  tile: LineTile,
  scale: TimeScale,
  colour: string,
): void {
  const { line, busy, unknown } = pathsOf(lane, left, tile, scale);
  context.save();
  context.beginPath();
  context.rect(left, lane.top - 2, scale.width, lane.height + 4);
  context.clip();
  context.strokeStyle = colour;
  context.fillStyle = colour;
  context.globalAlpha = 0.55;
  context.fill(busy);
  context.globalAlpha = 1;
  context.lineWidth = 1.5;
  context.lineJoin = 'miter';
  context.stroke(line);
  context.lineWidth = 1;
  for (const [from, to] of unknown) hatch(context, from, lane.top, to - from, lane.height);
  context.restore();
}

function pathsOf(lane: Lane, left: number, tile: LineTile, scale: TimeScale): Paths {
  const { times, levels } = tile;
  const high = lane.top + 1;
  const low = lane.top + lane.height - 1;
  const per = scale.pixelsPerPs;
  const shift = Number(scale.from - tile.from);
  const x = (time: number) => left + (time - shift) * per;
  const paths: Paths = { line: new Path2D(), busy: new Path2D(), unknown: [] };
  let before: number | undefined;
  for (let i = firstShown(times, shift); i < times.length; i += 1) {
    const from = Math.max(left - 4, x(times[i] ?? 0));
    if (from > left + scale.width) break;
    const to = Math.min(left + scale.width + 4, x(times[i + 1] ?? tile.end));
    const level = levels[i];
    if (level === 2) paths.unknown.push([from, to]);
    if (level === 3) paths.busy.rect(from, high, Math.max(1, to - from), low - high);
    if (level === 0 || level === 1) {
      const y = level === 1 ? high : low;
      if (before === undefined) paths.line.moveTo(from, y);
      else if (before !== y) paths.line.lineTo(from, before);
      paths.line.lineTo(from, y);
      paths.line.lineTo(to, y);
      before = y;
    } else {
      before = undefined;
    }
  }
  return paths;
}

// The last entry that begins at or before a time; 0 where there is none.
function firstShown(times: Float64Array, time: number): number {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) <= time) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

/** The level of a line at a time; undefined where it is not known as finely. */
export function levelAt(tile: LineTile, time: bigint): 0 | 1 | undefined {
  const offset = Number(time - tile.from);
  const at = firstShown(tile.times, offset);
  if ((tile.times[at] ?? Infinity) > offset || offset > tile.end) return undefined;
  const level = tile.levels[at];
  return level === 0 || level === 1 ? level : undefined;
}

/** The change of a line next to a time, within this distance. */
export function nearestChange(tile: LineTile, time: bigint, within: number): bigint | undefined {
  const offset = Number(time - tile.from);
  const at = firstShown(tile.times, offset);
  let found: number | undefined;
  for (const candidate of [tile.times[at], tile.times[at + 1]]) {
    if (candidate === undefined || Math.abs(candidate - offset) > within) continue;
    if (found === undefined || Math.abs(candidate - offset) < Math.abs(found - offset)) {
      found = candidate;
    }
  }
  return found === undefined ? undefined : tile.from + BigInt(found);
}

/** The names at the left. */
export function drawNames(
  context: Context,
  lanes: readonly Lane[],
  far: boolean,
  names: ReadonlyMap<string, string>,
  width: number,
  height: number,
  colours: Palette,
): void {
  context.fillStyle = colours.raised;
  context.fillRect(0, 0, width - 4, height);
  context.fillStyle = colours.text;
  context.font = `600 ${font}`;
  context.textBaseline = 'middle';
  for (const lane of lanes) {
    const name = far ? lane.farName : lane.name;
    context.fillText(names.get(name) ?? name, 10, lane.top + lane.height / 2, width - 18);
  }
}
