/** Many cycles at once: how many there are, how many failed and how many have a flag. */
import type { Strip } from '../plots/row_classes';
import { numberFont, type Pen } from './canvas';
import type { Lane, Lanes } from './lanes';
import type { TimeScale } from './scale';

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

/** Bars of a share of the lane, a pixel each; every number but 0 can be seen. */
function bars({ context, left }: Pen, lane: Lane, counts: Uint32Array, most: number, colour: string): void {
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

/** Draws strips for all cycles, for the failed ones and for the ones with a flag. Returns their numbers in
 * words. */
export function drawStrips(pen: Pen, lanes: Lanes, strip: Strip): string {
  const { context, left, scale, colours } = pen;
  const sums = byPixel(strip, scale);
  const highest = most(sums.all);
  bars(pen, lanes.cycle, sums.all, highest, colours.good);
  bars(pen, lanes.frame, sums.failed, highest, colours.error);
  bars(pen, lanes.cdm, sums.flagged, highest, colours.warn);
  context.font = numberFont;
  context.fillStyle = colours.muted;
  const text = stripText(sums);
  const advice = `${text} in this picture. Zoom in for the fields.`;
  context.fillText(advice, left + 4, lanes.flags.top + lanes.flags.height / 2, scale.width - 8);
  return text;
}

/** The numbers of a strip, in words. */
export function stripText(sums: Sums): string {
  const total = (counts: Uint32Array) => counts.reduce((sum, count) => sum + count, 0);
  return `${total(sums.all)} cycles, ${total(sums.failed)} failed, ${total(sums.flagged)} flagged`;
}

/** All in one lane, for the overview. */
export function drawOverview(pen: Pen, lane: Lane, strip: Strip): void {
  const { context, scale, colours } = pen;
  const sums = byPixel(strip, scale);
  const highest = most(sums.all);
  context.globalAlpha = 0.5;
  bars(pen, lane, sums.all, highest, colours.muted);
  context.globalAlpha = 1;
  bars(pen, lane, sums.flagged, highest, colours.warn);
  bars(pen, lane, sums.failed, highest, colours.error);
}
