/** Pointer and wheel on the waveform: zoom, pan, select, measure. */
import { selectRow } from '../selection';
import * as state from '../state';
import * as actions from './actions';
import { flagAt } from './cursors';
import type { Hit } from './draw_tracks';
import { gutter } from './lanes';
import { listen } from './listen';
import type { Overview } from './overview';
import { centred } from './scale';
import type { WaveView } from './view';

interface Point {
  x: number;
  y: number;
}

type Drag =
  | { kind: 'press'; from: Point }
  | { kind: 'pan'; last: number }
  | { kind: 'cursor'; which: 'a' | 'b' }
  | { kind: 'pinch'; distance: number; middle: number };

// A press that moves by more is a drag.
const still = 4;

/** The time and the text at the pointer. */
export interface Pointed {
  time: bigint;
  text: string;
}

export class WaveInput {
  readonly #pointers = new Map<number, Point>();
  #drag: Drag | undefined;
  /** The place of the pointer, from the left; undefined outside. */
  x: number | undefined;
  readonly close: () => void;

  constructor(
    private readonly element: HTMLElement,
    private readonly view: WaveView,
    private readonly onPoint: (pointed: Pointed | undefined) => void,
  ) {
    this.close = listen(element, {
      wheel: this.#wheel,
      pointerdown: this.#down,
      pointermove: this.#move,
      pointerup: this.#up,
      pointercancel: this.#cancel,
      pointerleave: this.#leave,
      dblclick: () => actions.showSelected(),
    });
  }

  #at(event: MouseEvent): Point {
    const box = this.element.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  #share(x: number): number {
    return (x - gutter) / Math.max(1, this.view.surface.width - gutter);
  }

  #wheel = (event: WheelEvent) => {
    event.preventDefault();
    const { x } = this.#at(event);
    const step = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    const isSideways = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    if (isSideways) {
      const by = (event.deltaX === 0 ? event.deltaY : event.deltaX) * step;
      actions.pan(by / Math.max(1, this.view.surface.width));
      return;
    }
    const power = Math.max(-240, Math.min(240, event.deltaY * step)) / (event.ctrlKey ? 100 : 300);
    actions.zoom(2 ** power, Math.max(0, Math.min(1, this.#share(x))));
  };

  #down = (event: PointerEvent) => {
    if (event.button !== 0) return;
    const at = this.#at(event);
    this.element.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, at);
    if (this.#pointers.size === 2) {
      this.#drag = { kind: 'pinch', ...this.#pinch() };
      return;
    }
    const { scale } = this.view;
    if (scale === undefined) return;
    const which = flagAt(state.cursors.value, scale, at.x - gutter, at.y);
    if (which !== undefined) {
      this.#drag = { kind: 'cursor', which };
    } else if (event.shiftKey) {
      const time = this.view.timeAt(at.x);
      state.cursors.value = { a: time, b: time };
      this.#drag = { kind: 'cursor', which: 'b' };
    } else {
      this.#drag = { kind: 'press', from: at };
    }
  };

  #move = (event: PointerEvent) => {
    const at = this.#at(event);
    this.x = at.x;
    if (this.#pointers.has(event.pointerId)) this.#pointers.set(event.pointerId, at);
    this.#point(at);
    const drag = this.#drag;
    if (drag === undefined) return;
    if (drag.kind === 'press' && Math.abs(at.x - drag.from.x) > still) {
      this.#drag = { kind: 'pan', last: drag.from.x };
    }
    if (drag.kind === 'cursor') actions.setCursor(drag.which, this.view.timeAt(at.x));
    if (drag.kind === 'pinch' && this.#pointers.size === 2) this.#follow(drag);
    const now = this.#drag;
    if (now?.kind === 'pan') {
      actions.pan(this.#share(now.last) - this.#share(at.x));
      now.last = at.x;
    }
  };

  #pinch(): { distance: number; middle: number } {
    const [a, b] = [...this.#pointers.values()];
    if (a === undefined || b === undefined) return { distance: 1, middle: 0 };
    return { distance: Math.max(20, Math.abs(a.x - b.x)), middle: (a.x + b.x) / 2 };
  }

  #follow(drag: { distance: number; middle: number }): void {
    const { distance, middle } = this.#pinch();
    actions.pan(this.#share(drag.middle) - this.#share(middle));
    actions.zoom(drag.distance / distance, this.#share(middle));
    drag.distance = distance;
    drag.middle = middle;
  }

  #up = (event: PointerEvent) => {
    const drag = this.#drag;
    this.#cancel(event);
    if (drag?.kind !== 'press') return;
    const { x, y } = this.#at(event);
    const hit = this.hitAt(x, y);
    const time = this.view.scale?.time(x - gutter);
    if (hit !== undefined) void selectRow(hit.row);
    else if (time !== undefined && x >= gutter) void actions.selectAt(time);
  };

  #cancel = (event: PointerEvent) => {
    this.#pointers.delete(event.pointerId);
    this.#drag = undefined;
  };

  #leave = () => {
    this.x = undefined;
    this.onPoint(undefined);
  };

  /** The part at a place; the part drawn last is on top. */
  hitAt(x: number, y: number): Hit | undefined {
    return this.view.hits.findLast(({ left, right, top, bottom }) => x >= left && x < right && y >= top && y < bottom);
  }

  #point({ x, y }: Point): void {
    const { scale } = this.view;
    if (scale === undefined || x < gutter) {
      this.onPoint(undefined);
      return;
    }
    const hit = this.hitAt(x, y);
    const text = hit === undefined ? '' : `#${hit.row} ${hit.text}`;
    this.onPoint({ time: scale.time(x - gutter), text });
  }
}

/** A press or a drag on the overview moves the range shown there. */
export function listenToOverview(element: HTMLElement, overview: Overview): () => void {
  const go = (event: PointerEvent) => {
    const range = state.range.value;
    if (event.buttons !== 1 || range === undefined) return;
    element.setPointerCapture(event.pointerId);
    const time = overview.scale.time(event.clientX - element.getBoundingClientRect().left);
    state.showRange(centred(range, time));
  };
  return listen(element, { pointerdown: go, pointermove: go });
}
