/** The picture of the waveform: requests to the core, and drawing. */
import type { Access } from 'biss';
import { firstWhere } from '../core/first_where';
import { harmlessStatuses } from '../core/statuses';
import * as state from '../state';
import { rowClass, type Row, type Rows } from '../plots/row_classes';
import { Surface, type Pen } from './canvas';
import { drawCursors } from './cursors';
import { changeBeside, drawAxis, drawLine, drawNames } from './draw_lines';
import { drawStrips } from './draw_strip';
import { TrackPainter, type Hit } from './draw_tracks';
import type { CycleLayout } from './layout';
import { gutter, lanesOf, type Lane, type Lanes } from './lanes';
import type { Palette } from './palette';
import { TimeScale } from './scale';
import { Cycles, lineTile, Tile, type Shown } from './tiles';

// Single cycles are drawn from the first width on, their parts from the second one, in pixels.
const cyclePixels = 4;
const partPixels = 60;
const mostRows = 3 * Math.ceil(4096 / cyclePixels);

export class WaveView {
  readonly surface: Surface;
  /** The parts drawn, for the pointer. */
  hits: Hit[] = [];
  readonly #ma = this.#lineTile('ma');
  readonly #slo = this.#lineTile('slo');
  readonly #rows: Tile<'analyse.rows'>;
  readonly #strip: Tile<'analyse.strip'>;
  readonly #cycles = new Cycles(() => this.surface.change());

  constructor(canvas: HTMLCanvasElement, private readonly onSeen: (text: string) => void) {
    this.#rows = new Tile('analyse.rows', 'wave.rows',
      ({ from, to }) => ({ from, to, most: mostRows }), () => this.surface.change());
    this.#strip = new Tile('analyse.strip', 'wave.strip',
      ({ from, to, columns }) => ({ from, to, columns }), () => this.surface.change());
    this.surface = new Surface(canvas, (colours) => this.#draw(colours), () => [
      state.range.value, state.cursors.value, state.selectedRow.value, state.generation.value, state.about.value,
    ]);
  }

  /** The scale of the range shown; its x begins at the right of the names. */
  get scale(): TimeScale | undefined {
    const range = state.range.value;
    return range === undefined ? undefined : new TimeScale(range, this.surface.width - gutter);
  }

  /** The time at a place. If a change of a line is near, the time of that change. */
  timeAt(x: number): bigint | undefined {
    const { scale } = this;
    if (scale === undefined) return undefined;
    const time = scale.time(x - gutter);
    const distance = (at: bigint) => Math.abs(Number(at - time));
    const changes = [this.changeBeside(time, -1), this.changeBeside(time - 1n, 1)]
      .flatMap((at) => (at !== undefined && distance(at) * scale.pixelsPerPs <= 6 ? [at] : []));
    return changes.sort((a, b) => distance(a) - distance(b))[0] ?? time;
  }

  /** The next change of MA or SLO after a time, or before it. */
  changeBeside(time: bigint, step: 1 | -1): bigint | undefined {
    const lines = [this.#ma, this.#slo].flatMap((tile) => lineTile(tile) ?? []);
    const changes = lines.flatMap((line) => changeBeside(line, time, step) ?? []);
    return changes.sort((a, b) => step * Number(a - b))[0];
  }

  #lineTile(line: 'ma' | 'slo'): Tile<'view'> {
    return new Tile('view', `wave.${line}`,
      ({ from, to, columns }) => ({ line, from, to, columns }), () => this.surface.change());
  }

  #draw(colours: Palette): void {
    const { context, height } = this.surface;
    this.hits = [];
    const lanes = lanesOf(height, (state.about.value?.accesses ?? 0) > 0);
    const { scale } = this;
    const range = state.range.value;
    const pen = scale && { context, left: gutter, scale, colours };
    const far = pen !== undefined && range !== undefined && this.#drawAll(lanes, range, pen);
    const { about } = state;
    const names = new Map([
      ['MA', about.value?.maInverted === true ? 'MA inv.' : 'MA'],
      ['SLO', about.value?.sloInverted === true ? 'SLO inv.' : 'SLO'],
    ]);
    drawNames({ context, left: gutter, colours }, Object.values(lanes), far, names, height);
    if (pen !== undefined) drawCursors(pen, state.cursors.value, height);
  }

  // Returns whether cycles are counted and not drawn one by one.
  #drawAll(lanes: Lanes, range: state.Range, pen: Pen): boolean {
    const { scale, colours } = pen;
    const bottom = lanes.flags.top + lanes.flags.height;
    const shown: Shown = { ...range, width: scale.width, end: state.endTime.value };
    this.#ma.want(shown);
    this.#slo.want(shown);
    this.#rows.want({ ...shown, version: state.about.value?.accesses ?? 0 });
    const rows = this.#rows.answer;
    const far = rows !== undefined && this.#seen(rows, range) * cyclePixels > scale.width;
    if (rows !== undefined && !far) this.#drawSelection(rows, lanes, pen, bottom);
    drawAxis(pen, lanes.axis, bottom);
    const ma = lineTile(this.#ma);
    const slo = lineTile(this.#slo);
    if (ma !== undefined) drawLine(pen, lanes.ma, ma, colours.ma);
    if (slo !== undefined) drawLine(pen, lanes.slo, slo, colours.accent);
    if (far) this.#drawFar(lanes, shown, pen);
    else if (rows !== undefined) this.#drawRows(lanes, rows, range, pen);
    return far;
  }

  #seen({ rows, count }: Rows, range: state.Range): number {
    if (rows.length > 0) return shownOf(rows, range).length;
    const asked = this.#rows.asked;
    if (asked === undefined || count === 0) return 0;
    return count * (Number(range.to - range.from) / Number(asked.to - asked.from));
  }

  #drawSelection({ rows }: Rows, lanes: Lanes, { context, scale, colours }: Pen, bottom: number): void {
    const selected = rows.find(({ row }) => row === state.selectedRow.value);
    if (selected === undefined) return;
    const left = Math.max(gutter, gutter + scale.x(selected.from));
    const right = Math.max(left, gutter + scale.x(selected.to));
    context.fillStyle = colours['fill-data'];
    context.globalAlpha = 0.35;
    context.fillRect(left, lanes.axis.height, right - left, bottom);
    context.globalAlpha = 1;
  }

  #drawFar(lanes: Lanes, shown: Shown, pen: Pen): void {
    this.#strip.want(shown);
    if (this.#strip.answer === undefined) return;
    this.onSeen(drawStrips(pen, lanes, this.#strip.answer));
  }

  #drawRows(lanes: Lanes, rows: Rows, range: state.Range, pen: Pen): void {
    const painter = new TrackPainter(pen);
    const seen = shownOf(rows.rows, range);
    const wanted: number[] = [];
    for (const cycle of seen) {
      painter.cycle(lanes.cycle, cycle, state.selectedRow.value === cycle.row);
      const isWide = Number(cycle.to - cycle.from) * pen.scale.pixelsPerPs >= partPixels;
      if (isWide) wanted.push(cycle.row);
      const layout = isWide ? this.#cycles.get(cycle.row) : undefined;
      if (layout !== undefined) drawParts(lanes, layout, cycle.row, painter);
      else if (isFailed(cycle)) painter.failure(cycle.from, cycle.status, cycle.row);
      drawFlags(lanes, cycle, painter);
    }
    if (lanes.access !== undefined) drawAccesses(lanes.access, rows, painter);
    painter.failures(lanes.cause);
    this.onSeen(cyclesText(seen));
    this.#cycles.want(wanted);
    this.hits = painter.hits;
  }
}

function drawAccesses(lane: Lane, { rows, accesses }: Rows, painter: TrackPainter): void {
  const rowFrom = (number: number) => firstWhere(rows.length, (i) => rows[i]!.number >= number);
  for (const access of accesses) {
    const own = rows.slice(rowFrom(access.cycle), rowFrom(access.cycle + Math.max(1, access.cycles)));
    const [first] = own;
    const last = own.at(-1);
    if (first === undefined || last === undefined) continue;
    const text = accessText(access);
    const texts = [text, text.replace(/( of \d+)?:.*/, '')];
    painter.label(lane, { from: first.from, to: last.to }, texts, first.row, access.outcome !== 'ok');
  }
}

function drawFlags(lanes: Lanes, cycle: Row, painter: TrackPainter): void {
  const { notes, safety: verdict } = cycle;
  const safety = verdict === '' ? '' : `safety: ${verdict}`;
  const texts = [[safety, notes].filter((text) => text !== '').join('; '), notes, verdict];
  if (texts[0] === '') return;
  const isBad = notes !== '' || (verdict !== 'safe' && verdict !== 'starting');
  painter.label(lanes.flags, cycle, texts, cycle.row, isBad);
}

// A row that is cut is not a failure of the link, but it cannot be read.
function isFailed(cycle: Row): boolean {
  return cycle.class === rowClass.failed || cycle.class === rowClass.cut;
}

function drawParts(lanes: Lanes, layout: CycleLayout, row: number, painter: TrackPainter): void {
  for (const part of layout.parts) painter.part(lanes.frame, part, row);
  for (const part of layout.below) painter.part(lanes.cdm, part, row);
  painter.samples(lanes.slo, lanes.bits, layout, row);
  for (const { at, text } of layout.failures) painter.failure(at, text, row);
}

// Rows that are seen.
function shownOf(rows: Row[], { from, to }: state.Range): Row[] {
  const before = (time: bigint) => firstWhere(rows.length, (i) => rows[i]!.from >= time);
  return rows.slice(Math.max(0, before(from + 1n) - 1), before(to));
}

function words(...parts: unknown[]): string {
  return parts.filter((part) => part !== null && part !== undefined && part !== '').join(' ');
}

// `read 0x42 BP_ID = 17 of 0: ok`.
function accessText({ id, access, address, name, data, outcome }: Access): string {
  const value = words(data) === '' ? '' : `= ${words(data)}`;
  return words(access, address, name, value, id === null ? ':' : `of ${id}:`, outcome).replace(' :', ':');
}

const mostNamed = 5;

// `cycles 3 to 5; failed: 4 crc`.
function cyclesText(cycles: readonly Row[]): string {
  const [first] = cycles;
  const last = cycles.at(-1);
  if (first === undefined || last === undefined) return '';
  const failed = cycles.filter(({ status }) => !harmlessStatuses.has(status));
  const named = failed.slice(0, mostNamed).map(({ number, status }) => `${number} ${status}`);
  const more = failed.length > mostNamed ? ` and ${failed.length - mostNamed} more` : '';
  const extent = cycles.length === 1 ? `cycle ${first.number}` : `cycles ${first.number} to ${last.number}`;
  return `${extent}; ${failed.length === 0 ? 'none failed' : `failed: ${named.join(', ')}${more}`}`;
}
