/** The cursors of the waveform: lines with a flag. */
import type { Cursors } from '../state';
import { boldFont, verticalLine, type Pen } from './canvas';
import type { TimeScale } from './scale';

export const flag = { width: 16, height: 16 };

export function drawCursors({ context, left, scale, colours }: Pen, cursors: Cursors, height: number): void {
  const both = [
    { name: 'A', time: cursors.a, colour: colours.cursorA },
    { name: 'B', time: cursors.b, colour: colours.cursorB },
  ];
  context.font = boldFont;
  context.textBaseline = 'middle';
  for (const { name, time, colour } of both) {
    if (time === undefined) continue;
    const x = scale.x(time);
    if (x < 0 || x > scale.width) continue;
    context.strokeStyle = colour;
    context.lineWidth = 1;
    context.setLineDash(name === 'A' ? [] : [6, 3]);
    verticalLine(context, left + x, 0, height);
    context.setLineDash([]);
    context.fillStyle = colour;
    context.fillRect(left + x - flag.width / 2, 0, flag.width, flag.height);
    context.fillStyle = colours.ground;
    context.fillText(name, left + x - 4.5, flag.height / 2 + 1);
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
