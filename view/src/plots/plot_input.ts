/** Pointer and wheel on a plot. If the plot follows the waveform, they move the waveform; else they change
 * the range of the plot. */
import * as state from '../state';
import * as actions from '../wave/actions';
import { listen } from '../wave/listen';
import { gutter, type PlotView } from './plot_view';

// A press that moves by more is a drag.
const still = 4;

export function listenToPlot(
  element: HTMLElement,
  plot: PlotView,
  follows: () => boolean,
  onPoint: (text: string) => void,
): () => void {
  let from: number | undefined;
  let last = 0;
  const at = (event: MouseEvent) => event.clientX - element.getBoundingClientRect().left;
  const share = (x: number) => (x - gutter) / (plot.scale?.width ?? 1);

  const wheel = (event: WheelEvent) => {
    if (!follows() && !event.ctrlKey) return;
    event.preventDefault();
    actions.zoom(2 ** (Math.max(-240, Math.min(240, event.deltaY)) / 300), share(at(event)));
  };
  const down = (event: PointerEvent) => {
    if (event.button !== 0) return;
    element.setPointerCapture(event.pointerId);
    from = last = at(event);
  };
  const move = (event: PointerEvent) => {
    const x = at(event);
    onPoint(plot.valueAt(x));
    const { scale } = plot;
    if (from === undefined || scale === undefined || Math.abs(x - from) <= still) return;
    if (follows()) {
      actions.pan(share(last) - share(x));
      last = x;
    } else {
      const [begin, end] = x < from ? [x, from] : [from, x];
      state.showRange(scale.time(begin - gutter), scale.time(end - gutter));
    }
  };
  const up = (event: PointerEvent) => {
    const { scale } = plot;
    const x = at(event);
    if (from !== undefined && scale !== undefined && Math.abs(x - from) <= still) {
      void actions.selectAt(scale.time(x - gutter));
    }
    from = undefined;
  };
  return listen(element, {
    wheel,
    pointerdown: down,
    pointermove: move,
    pointerup: up,
    pointercancel: () => { from = undefined; },
    pointerleave: () => onPoint(''),
  });
}
