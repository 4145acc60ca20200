/** The eye diagram: SLO around the sampling points, and a histogram of its changes. */
import { numberFont, type Surface, textWidth, verticalLine } from '../wave/canvas';
import type { Palette } from '../wave/palette';
import { timeText } from '../wave/scale';
import type { Eye } from './eye_of';
import { foot, gutter, rightEdge } from './plot_view';

// Changes within this share of a period of a sampling point are marginal, see docs/status.md.
const marginalShare = 0.05;

/** The figures of an eye, in words. */
export function eyeText(eye: Eye | undefined): string {
  if (eye === undefined) return 'Eye diagram: not measured yet.';
  if (eye.samples === 0) return 'Eye diagram: nothing was sampled here.';
  const cycles = eye.rows.length === eye.of ? `${eye.of} cycles` : `${eye.rows.length} of ${eye.of} cycles`;
  return `${eye.samples} samples of ${cycles}; ${sideText(eye, eye.before, 'before')}, ` +
    `${sideText(eye, eye.after, 'after')} the sampling point.`;
}

function sideText({ period }: Eye, distance: number, side: string): string {
  if (Number.isNaN(distance)) return `no change of SLO ${side}`;
  return `nearest change ${timeText(distance)} (${((distance / period) * 100).toFixed(1)} %) ${side}`;
}

type Context = CanvasRenderingContext2D;

export function drawEye({ context, width, height }: Surface, eye: Eye | undefined, colours: Palette): void {
  if (eye === undefined || eye.samples === 0) return;
  const plotWidth = width - gutter - rightEdge;
  const eyeHeight = Math.round((height - foot) * 0.66);
  drawMargin(context, plotWidth, height, colours);
  drawLevels(context, eye, plotWidth, eyeHeight, colours);
  drawCounts(context, eye, plotWidth, eyeHeight + 8, height - foot, colours);
  drawAxis(context, eye, plotWidth, height, colours);
  drawNames(context, eyeHeight, height, colours);
}

function drawMargin(context: Context, width: number, height: number, colours: Palette): void {
  const middle = gutter + width / 2;
  const half = (marginalShare * width) / 2;
  context.fillStyle = colours['fill-warn'];
  context.fillRect(middle - half, 0, 2 * half, height - foot);
  context.strokeStyle = colours.text;
  context.lineWidth = 1;
  context.setLineDash([4, 3]);
  verticalLine(context, middle, 0, height - foot);
  context.setLineDash([]);
}

// The rails by how often SLO is there, and its changes between them.
function drawLevels(context: Context, eye: Eye, width: number, height: number, colours: Palette): void {
  const bins = eye.high.length;
  const each = width / bins;
  const rail = 3;
  const top = 8;
  const bottom = height - 8;
  const most = Math.max(1, ...eye.rising, ...eye.falling);
  context.fillStyle = colours.accent;
  for (let bin = 0; bin < bins; bin += 1) {
    const x = gutter + Math.round(bin * each);
    const wide = gutter + Math.round((bin + 1) * each) - x;
    const high = eye.high[bin] ?? 0;
    const low = eye.low[bin] ?? 0;
    const all = Math.max(1, high + low);
    const part = (share: number, y: number) => {
      if (share === 0) return;
      context.globalAlpha = 0.25 + 0.75 * share;
      context.fillRect(x, y, wide, rail);
    };
    part(high / all, top);
    part(low / all, bottom - rail);
    const changes = (eye.rising[bin] ?? 0) + (eye.falling[bin] ?? 0);
    if (changes === 0) continue;
    context.globalAlpha = 0.2 + 0.8 * Math.sqrt(Math.min(1, changes / most));
    context.fillRect(x, top, Math.max(1, wide), bottom - top);
  }
  context.globalAlpha = 1;
}

function drawCounts(context: Context, eye: Eye, width: number, top: number, bottom: number, colours: Palette): void {
  const bins = eye.high.length;
  const counts = eye.rising.map((rising, bin) => rising + (eye.falling[bin] ?? 0));
  const most = Math.max(1, ...counts);
  context.fillStyle = colours.muted;
  counts.forEach((count, bin) => {
    if (count === 0) return;
    const height = Math.max(2, (count / most) * (bottom - top));
    context.fillRect(gutter + (bin * width) / bins, bottom - height, Math.max(1, width / bins), height);
  });
  if (counts.every((count) => count === 0)) context.fillText('no change of SLO', gutter + 8, (top + bottom) / 2);
}

function drawAxis(context: Context, eye: Eye, width: number, height: number, colours: Palette): void {
  context.font = numberFont;
  context.strokeStyle = colours.grid;
  context.fillStyle = colours.muted;
  for (let quarter = -4; quarter <= 4; quarter += 2) {
    const x = gutter + ((quarter + 4) / 8) * width;
    const time = (quarter / 4) * eye.period;
    const text = quarter === 0 ? 'sample' : timeText(time, 3);
    if (quarter !== 0) verticalLine(context, x, 0, height - foot + 3);
    const wide = textWidth(context, text);
    context.fillText(text, Math.min(x - wide / 2, gutter + width + rightEdge - wide), height - foot / 2 + 1);
  }
}

function drawNames(context: Context, eyeHeight: number, height: number, colours: Palette): void {
  context.fillStyle = colours.muted;
  context.fillText('SLO high', 10, 10);
  context.fillText('SLO low', 10, eyeHeight - 10);
  context.fillText('changes', 10, (eyeHeight + 8 + height - foot) / 2);
}
