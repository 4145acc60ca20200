/** The plots against time, the eye diagram and the histogram of causes. */
import './plots.css';
import { computed, signal } from '@preact/signals';
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { defineKeys } from '../shell/keys';
import { useAnswer } from '../shell/use_answer';
import * as state from '../state';
import * as actions from '../wave/actions';
import { Surface } from '../wave/canvas';
import { listen } from '../wave/listen';
import { steadyEnd, steadyRows, Tile } from '../wave/tiles';
import { Causes, pause } from './causes';
import type { Envelope } from './envelope';
import type { Eye } from './eye_of';
import { drawEye, eyeText } from './eye_view';
import { columnPlots } from './plot_list';
import { gutter, PlotView, type PlotSpec, type Source } from './plot_view';

/** The plots show the same range as the waveform, and not the whole capture. */
const follows = signal(false);
const shown = computed(() => (follows.value ? state.range.value : wholeCapture()));

// The most cycles of the eye, evenly spread over the range shown.
const eyeCycles = 120;
const eyeBins = 200;

function wholeCapture(): state.Range | undefined {
  return state.range.value === undefined ? undefined : state.wholeRange.value;
}

const eye = signal<Eye | undefined>(undefined);

defineKeys('plots', [
  {
    keys: ['w'],
    help: 'Show the whole capture, or what the waveform shows',
    run: () => { follows.value = !follows.value; },
  },
  ...actions.moveKeys,
  { keys: ['+', '='], help: 'Zoom in', run: () => actions.zoom(1 / 1.5) },
  { keys: ['-'], help: 'Zoom out', run: () => actions.zoom(1.5) },
]);

export function Plots() {
  const range = shown.value;
  const rows = steadyRows();
  const generation = state.generation.value;
  const stretch = follows.value ? [range?.from, range?.to] : ['all', ''];
  const ask = range && rows > 0 ? { ...range, cycles: eyeCycles, bins: eyeBins } : undefined;
  const found = useAnswer('analyse.eye', ask, [generation, rows, ...stretch], pause)?.answer;
  useEffect(() => { if (found !== undefined) eye.value = found; }, [found]);
  const plots = columnPlots(state.columns.value);
  return (
    <section class="plots" aria-label="Plots" data-keys="plots">
      <div class="bar" role="group" aria-label="Time of the plots">
        <Choice text="Whole capture" value={false} />
        <Choice text="As the waveform" value />
        <p class="quiet">
          {follows.value ? 'Wheel and drag zoom and move.' : 'Drag over a plot to show a stretch in the waveform.'}
        </p>
      </div>
      <div class="plots-all" role="group" tabIndex={0} aria-label="Plots against time">
        {plots.map((plot) => <ColumnFigure key={`${generation} ${plot.id}`} plot={plot} />)}
        <MarginFigure />
        <EyeFigure />
      </div>
      <Causes />
    </section>
  );
}

function Choice({ text, value }: { text: string; value: boolean }) {
  const choose = () => { follows.value = value; };
  return (
    <label class="tick">
      <input type="radio" name="plots-time" checked={follows.value === value} onChange={choose} /> {text}
    </label>
  );
}

function ColumnFigure({ plot }: { plot: PlotSpec }) {
  const sourceOf = (change: () => void): Source => {
    const tile = new Tile('analyse.envelope', `plots.${plot.id}`,
      ({ from, to, columns }) => ({ column: plot.id, from, to, points: columns }), change);
    return (range, width) => {
      tile.want({ ...range, width, end: steadyEnd() });
      return tile.answer;
    };
  };
  return <Figure spec={plot} sourceOf={sourceOf} />;
}

const marginSpec: PlotSpec = { id: 'margin', title: 'Margin', quantity: 'time', unit: '', dots: true };

function MarginFigure() {
  const sourceOf = (): Source => () => margins.value;
  const found = eye.value;
  const isSample = found !== undefined && found.rows.length < found.of;
  const note = isSample ? `${found.rows.length} of ${found.of} cycles` : '';
  return <Figure spec={marginSpec} sourceOf={sourceOf} note={note} />;
}

// The same object for the same eye, so that it is drawn once.
const margins = computed<Envelope | undefined>(() => {
  const found = eye.value;
  return found && { from: found.from, times: found.times, low: found.margins, high: found.margins, rows: 1 };
});

interface FigureProps {
  spec: PlotSpec;
  sourceOf: (change: () => void) => Source;
  note?: string;
}

function Figure({ spec, sourceOf, note = '' }: FigureProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [summary, setSummary] = useState(spec.title);
  const point = useMemo(() => signal(''), []);
  useEffect(() => {
    const element = canvas.current;
    if (element === null) return undefined;
    const plot: PlotView = new PlotView(element, spec, sourceOf(() => plot.surface.change()), shown, eye, setSummary);
    const stop = listenToPlot(element, plot, (text) => { point.value = text; });
    return () => {
      stop();
      plot.surface.close();
    };
  }, []);
  return (
    <figure class="plot">
      <figcaption>
        <strong>{spec.unit === '' ? spec.title : `${spec.title}, ${spec.unit}`}</strong>
        <span class="quiet">{point.value === '' ? note : point.value}</span>
      </figcaption>
      <div class="plot-canvas"><canvas ref={canvas} role="img" aria-label={summary} /></div>
    </figure>
  );
}

// A press that moves by more is a drag.
const still = 4;

// Pointer and wheel on a plot. If the plot follows the waveform, they move the waveform; else they change
// the range of the plot.
function listenToPlot(
  element: HTMLElement,
  plot: PlotView,
  onPoint: (text: string) => void,
): () => void {
  let from: number | undefined;
  let last = 0;
  const at = (event: MouseEvent) => event.clientX - element.getBoundingClientRect().left;
  const share = (x: number) => (x - gutter) / (plot.scale?.width ?? 1);

  const wheel = (event: WheelEvent) => {
    if (!follows.value && !event.ctrlKey) return;
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
    if (follows.value) {
      actions.pan(share(last) - share(x));
      last = x;
    } else {
      const [begin, end] = x < from ? [x, from] : [from, x];
      state.showRange({ from: scale.time(begin - gutter), to: scale.time(end - gutter) });
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

function EyeFigure() {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    if (canvas.current === null) return undefined;
    const surface: Surface = new Surface(canvas.current, (colours) => drawEye(surface, eye.value, colours), () => eye.value);
    return () => surface.close();
  }, []);
  const text = eyeText(eye.value);
  return (
    <figure class="plot">
      <figcaption><strong>Eye of SLO</strong> <span class="quiet">{text}</span></figcaption>
      <div class="plot-canvas plot-eye">
        <canvas ref={canvas} role="img" aria-label={`Eye diagram of SLO. ${text}`} />
      </div>
    </figure>
  );
}
