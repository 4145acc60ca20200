/** The decoded tracks below the lines: cycles, their parts, bits and failures. */
import { rowClass, type Row } from '../plots/row_classes';
import type { Range } from '../state';
import { fitting, font, hatch, numberFont, textWidth, type Pen } from './canvas';
import { partText, type CycleLayout, type Part } from './layout';
import type { Lane } from './lanes';

// The names of bits are drawn if a clock has this many pixels.
const nameClock = 56;

// The look of a cycle, by its class; without a fill it has a dashed frame.
const looks = {
  [rowClass.good]: { sign: '✓', fill: 'fill-crc', text: 'text' },
  [rowClass.cut]: { sign: '…', fill: undefined, text: 'muted' },
  [rowClass.flagged]: { sign: '!', fill: 'fill-warn', text: 'warn' },
  [rowClass.failed]: { sign: '✕', fill: 'fill-wrong', text: 'error' },
} as const;

/** An area of the picture, with the text to show if the pointer is in it. */
export interface Hit {
  left: number;
  right: number;
  top: number;
  bottom: number;
  text: string;
  row: number;
}

/** Draws tracks, and keeps the places of their parts. */
export class TrackPainter {
  readonly hits: Hit[] = [];
  readonly #failures: { x: number; text: string; row: number }[] = [];

  constructor(private readonly pen: Pen) {}

  #x(time: bigint): number {
    return this.pen.left + this.pen.scale.x(time);
  }

  // Within the range shown.
  #bounds({ from, to }: Range): [number, number] {
    const right = this.pen.left + this.pen.scale.width;
    return [Math.max(this.pen.left, this.#x(from)), Math.min(right, this.#x(to))];
  }

  cycle(lane: Lane, cycle: Row, selected: boolean): void {
    const [from, to] = this.#bounds(cycle);
    if (to <= from) return;
    const { row, number, status, notes, position } = cycle;
    const { sign, fill, text: colour } = looks[cycle.class as keyof typeof looks];
    const failed = cycle.class === rowClass.failed;
    this.#box(lane, from, to, fill && this.pen.colours[fill], failed, selected);
    const head = `${sign} #${number} ${status}`;
    const full = [head, position, notes].filter((text) => text !== '').join('  ');
    this.pen.context.fillStyle = this.pen.colours[colour];
    this.#text(lane, from, to, [full, `${head}  ${position}`, head, `${sign} #${number}`, `#${number}`, sign]);
    this.#hit(lane, from, to, `cycle ${full.slice(sign.length).trim()}`, row);
  }

  part(lane: Lane, part: Part, row: number): void {
    const [from, to] = this.#bounds(part);
    if (to - from < 0.5) return;
    const { context, colours } = this.pen;
    const fill = part.wrong ? 'wrong' : part.kind === 'frame' ? 'line' : part.kind;
    this.#box(lane, from, to, colours[`fill-${fill}`], part.wrong, false);
    context.fillStyle = part.wrong ? colours.error : colours.text;
    const texts = part.wrong ? part.texts.flatMap((text) => [`✕ ${text}`, text]) : part.texts;
    this.#text(lane, from, to, texts);
    this.#hit(lane, from, to, partText(part), row);
  }

  /** A box on a lane of its own, such as CDM or the verdict of the monitor. */
  label(lane: Lane, extent: Range, texts: string[], row: number, bad: boolean): void {
    const [begin, end] = this.#bounds(extent);
    if (end - begin < 0.5) return;
    this.#box(lane, begin, end, bad ? this.pen.colours['fill-warn'] : this.pen.colours['fill-line'], false, false);
    this.pen.context.fillStyle = bad ? this.pen.colours.warn : this.pen.colours.text;
    this.#text(lane, begin, end, texts);
    this.#hit(lane, begin, end, texts[0] ?? '', row);
  }

  /** Sampling points on SLO, and below them the bits. */
  samples(slo: Lane, lane: Lane, layout: CycleLayout, row: number): void {
    const { context, colours } = this.pen;
    const clock = Number(layout.period) * this.pen.scale.pixelsPerPs;
    if (clock < 6) return;
    for (const sample of layout.samples) {
      const x = this.#x(sample.at);
      if (x < this.pen.left || x > this.pen.left + this.pen.scale.width) continue;
      const bad = sample.wrong || sample.mends;
      context.fillStyle = sample.wrong ? colours.error : sample.mends ? colours.warn : colours.accent;
      const level = sample.level ?? 0.5;
      const y = slo.top + 1 + (1 - level) * (slo.height - 2);
      context.beginPath();
      if (bad) context.rect(x - 4, y - 4, 8, 8);
      else context.arc(x, y, 3, 0, 2 * Math.PI);
      context.fill();
      if (clock >= 12) this.#bit(lane, x, clock, sample.name, sample.level, bad);
      const note = sample.wrong ? ', wrong for these data' : sample.mends ? ', its flip corrects the checksum' : '';
      this.#hit(lane, x - clock / 2, x + clock / 2, `${sample.name}=${sample.level ?? '?'}${note}`, row);
    }
  }

  #bit(lane: Lane, x: number, clock: number, name: string, level: number | undefined, bad: boolean): void {
    const { context, colours } = this.pen;
    context.font = bad ? `bold ${numberFont}` : numberFont;
    const value = level === undefined ? '?' : String(level);
    const marked = bad ? `✕${value}` : value;
    const names = clock >= nameClock ? [`${name}=${marked}`] : [];
    const text = fitting(context, [...names, marked, value], clock - 2) ?? '';
    context.fillStyle = bad ? colours.error : colours.text;
    context.fillText(text, x - textWidth(context, text) / 2, lane.top + lane.height / 2);
  }

  /** Marks the time at which a cycle fails, with the cause. */
  failure(at: bigint, text: string, row: number): void {
    const x = this.#x(at);
    if (x >= this.pen.left && x <= this.pen.left + this.pen.scale.width) this.#failures.push({ x, text, row });
  }

  /** Draws the failures; a text for which there is no room is left to the pointer. */
  failures(lane: Lane): void {
    const { context } = this.pen;
    const right = this.pen.left + this.pen.scale.width;
    context.fillStyle = this.pen.colours.error;
    context.font = font;
    let written = this.pen.left;
    this.#failures.forEach(({ x, text, row }, i) => {
      context.beginPath();
      context.moveTo(x, lane.top + 3);
      context.lineTo(x + 5, lane.top + 13);
      context.lineTo(x - 5, lane.top + 13);
      context.fill();
      const next = Math.min(right, (this.#failures[i + 1]?.x ?? Infinity) - 8);
      const begin = Math.max(written, x + 8);
      const texts = [text, text.replace(/;.*/, ''), text.replace(/:.*/, '')];
      const after = fitting(context, texts, next - begin) ?? '';
      const before = fitting(context, texts, x - 8 - written) ?? '';
      const isBefore = before.length > after.length;
      const shown = isBefore ? before : after;
      const width = textWidth(context, shown);
      const place = isBefore ? x - 8 - width : begin;
      context.fillText(shown, place, lane.top + lane.height / 2);
      this.#hit(lane, Math.min(x - 6, place), Math.max(x + 6, place + width), text, row);
      written = Math.max(x + 8, place + width + 6);
    });
  }

  #box(lane: Lane, from: number, to: number, fill: string | undefined, bad: boolean, selected: boolean): void {
    const { context, colours } = this.pen;
    const width = to - from > 3 ? to - from - 1 : to - from;
    if (fill !== undefined) {
      context.fillStyle = fill;
      context.fillRect(from, lane.top, width, lane.height);
    } else if (width > 3) {
      context.strokeStyle = colours.muted;
      context.lineWidth = 1;
      context.setLineDash([3, 3]);
      context.strokeRect(from + 0.5, lane.top + 0.5, width - 1, lane.height - 1);
      context.setLineDash([]);
    }
    if (bad) {
      context.fillStyle = colours.error;
      context.fillRect(from, lane.top + lane.height - 3, Math.max(1, width), 3);
      context.strokeStyle = colours.error;
      context.globalAlpha = 0.25;
      if (width > 14) hatch(context, from, lane.top, width, lane.height - 3);
      context.globalAlpha = 1;
    }
    if (selected) {
      context.strokeStyle = colours.accent;
      context.lineWidth = 2;
      context.strokeRect(from + 1, lane.top + 1, Math.max(1, width - 2), lane.height - 2);
    }
  }

  #text(lane: Lane, from: number, to: number, texts: readonly string[]): void {
    const { context } = this.pen;
    context.font = font;
    const text = fitting(context, texts, to - from - 7);
    if (text === undefined) return;
    const middle = (from + to) / 2 - textWidth(context, text) / 2;
    context.fillText(text, Math.max(from + 3, middle), lane.top + lane.height / 2 + 0.5);
  }

  #hit(lane: Lane, left: number, right: number, text: string, row: number): void {
    this.hits.push({ left, right, top: lane.top, bottom: lane.top + lane.height, text, row });
  }
}
