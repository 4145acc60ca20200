/** The whole capture in a strip, with a window for the range shown. */
import * as state from '../state';
import { Layer, Surface } from './canvas';
import { drawOverview, stripText } from './draw_strip';
import type { Palette } from './palette';
import { TimeScale } from './scale';
import { steadyEnd, Tile } from './tiles';

const inset = 3;

export class Overview {
  readonly surface: Surface;
  readonly #strip: Tile<'analyse.strip'>;
  readonly #bars = new Layer();

  constructor(canvas: HTMLCanvasElement, private readonly onSummary: (text: string) => void) {
    this.#strip = new Tile('analyse.strip', 'wave.overview',
      ({ columns }) => ({ ...state.wholeRange.value, columns }), () => this.surface.change());
    this.surface = new Surface(canvas, (colours) => this.#draw(colours), () => [
      state.range.value, state.endTime.value, state.generation.value, state.progress.value.state,
    ], 'surface');
  }

  get scale(): TimeScale {
    return new TimeScale(state.wholeRange.value, this.surface.width);
  }

  #draw(colours: Palette): void {
    const { context, width, height } = this.surface;
    const range = state.range.value;
    if (range === undefined) return;
    const { scale } = this;
    this.#strip.want({ ...state.wholeRange.value, width, end: steadyEnd() });
    const lane = { top: inset, height: height - 2 * inset, name: '', farName: '' };
    const { answer } = this.#strip;
    if (answer !== undefined) {
      this.onSummary(stripText(answer));
      this.#bars.put(this.surface, [answer, scale.from, scale.span, colours],
        (layer) => drawOverview({ context: layer, left: 0, scale, colours }, lane, answer));
    }
    const from = scale.x(range.from);
    const length = Math.max(3, scale.x(range.to) - from);
    context.fillStyle = colours.accent;
    context.globalAlpha = 0.16;
    context.fillRect(from, 0, length, height);
    context.globalAlpha = 1;
    context.strokeStyle = colours.accent;
    context.lineWidth = 2;
    context.strokeRect(from + 1, 1, Math.max(1, length - 2), height - 2);
  }
}
