/** A canvas that is as fine as the screen, and texts that fit. */
import { effect } from '@preact/signals';
import { shownTheme } from '../state';
import { paletteOf, type Palette } from './palette';
import type { TimeScale } from './scale';

export const font = "12px system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";
export const numberFont = "12px ui-monospace, SFMono-Regular, Menlo, Consolas, 'DejaVu Sans Mono', monospace";
export const boldFont = `bold ${font}`;

/** Draws when a signal that `dependsOn` reads or the theme has changed, once a frame at most. */
export class Surface {
  readonly context: CanvasRenderingContext2D;
  width = 0;
  height = 0;
  // The request for the next picture; 0: none.
  #frame = 0;
  readonly #observer: ResizeObserver;
  readonly #stop: () => void;

  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly draw: (colours: Palette) => void,
    dependsOn: () => unknown,
    private readonly ground: 'page' | 'surface' = 'page',
  ) {
    const context = canvas.getContext('2d');
    if (context === null) throw new Error('this browser has no canvas');
    this.context = context;
    this.#observer = new ResizeObserver(() => this.#resize());
    this.#observer.observe(canvas.parentElement ?? canvas);
    this.#resize();
    this.#stop = effect(() => {
      dependsOn();
      void shownTheme.value;
      this.change();
    });
  }

  /** Draws with the next frame. */
  change(): void {
    if (this.#frame !== 0) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      if (this.width === 0 || this.height === 0) return;
      const colours = paletteOf(shownTheme.value);
      this.context.fillStyle = colours[this.ground];
      this.context.fillRect(0, 0, this.width, this.height);
      this.draw(colours);
    });
  }

  /** Nothing is drawn afterwards. */
  close(): void {
    this.#stop();
    this.#observer.disconnect();
    cancelAnimationFrame(this.#frame);
    this.#frame = NaN;
  }

  #resize(): void {
    const { clientWidth, clientHeight } = this.canvas.parentElement ?? this.canvas;
    const ratio = window.devicePixelRatio || 1;
    const width = Math.round(clientWidth * ratio);
    const height = Math.round(clientHeight * ratio);
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    this.width = clientWidth;
    this.height = clientHeight;
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.context.textBaseline = 'middle';
    this.change();
  }
}

/** A picture that is kept until its contents change. */
export class Layer {
  readonly #canvas = document.createElement('canvas');
  #shown: readonly unknown[] = [];

  /** Draws the layer on the surface; `draw` makes it again if one of `parts` has changed. */
  put(surface: Surface, parts: readonly unknown[], draw: (context: CanvasRenderingContext2D) => void): void {
    const { canvas, context, width, height } = surface;
    const now = [...parts, canvas.width, canvas.height];
    if (now.length !== this.#shown.length || now.some((part, i) => part !== this.#shown[i])) {
      this.#shown = now;
      this.#canvas.width = canvas.width;
      this.#canvas.height = canvas.height;
      const own = this.#canvas.getContext('2d');
      if (own === null) return;
      own.scale(canvas.width / width, canvas.height / height);
      own.textBaseline = 'middle';
      draw(own);
    }
    context.drawImage(this.#canvas, 0, 0, width, height);
  }
}

/** Tools to draw a picture against time. */
export interface Pen {
  context: CanvasRenderingContext2D;
  /** The left end of the scale, in pixels. */
  left: number;
  scale: TimeScale;
  colours: Palette;
}

const widths = new Map<string, number>();

/** The width of a text in the font of the context. */
export function textWidth(context: CanvasRenderingContext2D, text: string): number {
  const key = context.font + text;
  let width = widths.get(key);
  if (width === undefined) {
    if (widths.size > 20_000) widths.clear();
    width = context.measureText(text).width;
    widths.set(key, width);
  }
  return width;
}

/** The first of the texts that fits, or nothing. */
export function fitting(
  context: CanvasRenderingContext2D,
  texts: readonly string[],
  room: number,
): string | undefined {
  return texts.find((text) => text !== '' && textWidth(context, text) <= room);
}

/** A vertical line that is one pixel wide and sharp. */
export function verticalLine(
  context: CanvasRenderingContext2D,
  x: number,
  top: number,
  bottom: number,
): void {
  const at = Math.round(x) + 0.5;
  context.beginPath();
  context.moveTo(at, top);
  context.lineTo(at, bottom);
  context.stroke();
}

/** Lines at 45 degrees in a rectangle, so that a failure is not seen by its colour alone. */
export function hatch(
  context: CanvasRenderingContext2D,
  x: number,
  y: number,
  width: number,
  height: number,
): void {
  context.save();
  context.beginPath();
  context.rect(x, y, width, height);
  context.clip();
  context.beginPath();
  const begin = Math.floor((x - height) / 6) * 6;
  for (let at = begin; at < x + width; at += 6) {
    context.moveTo(at, y + height);
    context.lineTo(at + height, y);
  }
  context.stroke();
  context.restore();
}
