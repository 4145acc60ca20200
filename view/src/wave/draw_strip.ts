/** Many cycles at once: how many there are, how many failed and how many have a flag. */
import type { Strip } from '../plots/row_classes';
import { numberFont } from './canvas';
import type { Lane } from './lanes';
import type { Palette } from './palette';
import type { TimeScale } from './scale';

type Context = CanvasRenderingContext2D;

type Sums = Pick<Strip, 'all' | 'failed' | 'flagged'>;

// The columns of the strip added up by pixel.
function byPixel(strip: Strip, scale: TimeScale): Sums {
  const width = Math.ceil(scale.width);
  const each = Number(strip.to - strip.from) / strip.all.length;
  const begin = Number(strip.from - scale.from);
  const sumsOf = (counts: Uint32Array) => {
    const sums = new Uint32Array(width);
    counts.forEach((count, i) => {
      const x = Math.floor((begin + (i + 0.5) * each) * scale.pixelsPerPs);
      if (x >= 0 && x < width) sums[x] = (sums[x] ?? 0) + count;
    });
    return sums;
  };
  return { all: sumsOf(strip.all), failed: sumsOf(strip.failed), flagged: sumsOf(strip.flagged) };
}

/** Bars of a share of the lane, a pixel each; what is not 0 can be seen. */
function bars(
  context: Context,
  lane: Lane,
  left: number,
  counts: Uint32Array,
  most: number,
  colour: string,
): void {
  context.fillStyle = colour;
  for (let x = 0; x < counts.length; x += 1) {
    const count = counts[x] ?? 0;
    if (count === 0) continue;
    const height = Math.max(3, Math.sqrt(count / most) * lane.height);
    context.fillRect(left + x, lane.top + lane.height - height, 1, height);
  }
}

function most(counts: Uint32Array): number {
  return counts.reduce((found, count) => Math.max(found, count), 1);
}

/** Three lanes: all cycles, the failed ones, those with a flag. Returns their numbers in words. */
export function drawStrips(
  context: Context,
  lanes: { all: Lane; failed: Lane; flagged: Lane; notes: Lane },
  left: number,
  strip: Strip,
  scale: TimeScale,
  colours: Palette,
): string {
  const sums = byPixel(strip, scale);
  const highest = most(sums.all);
  bars(context, lanes.all, left, sums.all, highest, colours.good);
  bars(context, lanes.failed, left, sums.failed, highest, colours.bad);
  bars(context, lanes.flagged, left, sums.flagged, highest, colours.warn);
  context.font = numberFont;
  context.fillStyle = colours.soft;
  context.textBaseline = 'middle';
  const text = stripText(sums);
  const advice = `${text} in this picture. Zoom in for the fields.`;
  context.fillText(advice, left + 4, lanes.notes.top + lanes.notes.height / 2, scale.width - 8);
  return text;
}

/** The numbers of a strip, in words. */
export function stripText(sums: Sums): string {
  const total = (counts: Uint32Array) => counts.reduce((sum, count) => sum + count, 0);
  return `${total(sums.all)} cycles, ${total(sums.failed)} failed, ${total(sums.flagged)} flagged`;
}

/** All in one lane, for the overview. */
export function drawOverview(
  context: Context,
  lane: Lane,
  strip: Strip,
  scale: TimeScale,
  colours: Palette,
): void {
  const sums = byPixel(strip, scale);
  const highest = most(sums.all);
  context.globalAlpha = 0.5;
  bars(context, lane, 0, sums.all, highest, colours.soft);
  context.globalAlpha = 1;
  bars(context, lane, 0, sums.flagged, highest, colours.warn);
  bars(context, lane, 0, sums.failed, highest, colours.bad);
}
