/** The cursors of the waveform: lines with a flag. */
import type { Cursors } from '../state';
import { boldFont, verticalLine, type Pen } from './canvas';
import type { TimeScale } from './scale';

export const flag = { width: 16, height: 16 };

/** The cursors in the picture, with their places. */
export function shownCursors({ left, scale, colours }: Pen, { a, b }: Cursors) {
  const both = [{ name: 'A', time: a, colour: colours['cursor-a'] }, { name: 'B', time: b, colour: colours['cursor-b'] }];
  return both.flatMap(({ name, time, colour }) => {
    const x = time === undefined ? -1 : scale.x(time);
    return x < 0 || x > scale.width ? [] : [{ name, x: left + x, colour }];
  });
}

export function drawCursors(pen: Pen, cursors: Cursors, height: number): void {
  const { context, colours } = pen;
  context.font = boldFont;
  for (const { name, x, colour } of shownCursors(pen, cursors)) {
    context.strokeStyle = colour;
    context.lineWidth = 1;
    context.setLineDash(name === 'A' ? [] : [6, 3]);
    verticalLine(context, x, 0, height);
    context.setLineDash([]);
    context.fillStyle = colour;
    context.fillRect(x - flag.width / 2, 0, flag.width, flag.height);
    context.fillStyle = colours.page;
    context.fillText(name, x - 4.5, flag.height / 2 + 1);
  }
}

/** The cursor whose flag is at a place. */
export function flagAt(cursors: Cursors, scale: TimeScale, x: number, y: number): 'a' | 'b' | undefined {
  if (y > flag.height) return undefined;
  return (['b', 'a'] as const).find((which) => {
    const time = cursors[which];
    return time !== undefined && Math.abs(scale.x(time) - x) <= flag.width / 2 + 2;
  });
}
