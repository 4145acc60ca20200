/** The waveform of MA and SLO, the decoded tracks below it, the overview strip and the cursors. */
import './wave.css';
import { signal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { useAnswer } from '../shell/use_answer';
import * as state from '../state';
import * as actions from './actions';
import { differenceText, waveText } from './describe';
import { listenToOverview, WaveInput, type Pointed } from './input';
import { cursorTime, defineWaveKeys } from './keys';
import { Overview } from './overview';
import { exactTimeText, timeText } from './scale';
import { WaveView } from './view';

/** The cycles in the picture and in the overview, in words. */
const seen = signal('');
const all = signal('');
const pointed = signal<Pointed | undefined>(undefined);
let shownView: WaveView | undefined;

function useWave() {
  const wave = useRef<HTMLCanvasElement>(null);
  const overview = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const canvas = wave.current;
    const strip = overview.current;
    if (canvas === null || strip === null) return undefined;
    const view = new WaveView(canvas, (text) => { seen.value = text; });
    const input = new WaveInput(canvas, view, (at) => { pointed.value = at; });
    const whole = new Overview(strip, (text) => { all.value = text; });
    const stopOverview = listenToOverview(strip, whole);
    defineWaveKeys(view, input);
    shownView = view;
    return () => {
      stopOverview();
      whole.surface.close();
      input.close();
      view.close();
      shownView = undefined;
    };
  }, []);
  return { wave, overview };
}

// The number of the cycle that is selected.
function useSelectedCycle(): number | undefined {
  const row = state.selectedRow.value;
  const isKnown = row !== undefined && row < state.rowCount.value;
  const ask = isKnown ? { name: 'cycle', from: row, to: row + 1 } : undefined;
  const value = useAnswer('column', ask, [row, state.generation.value])?.answer?.values[0];
  return value === undefined ? undefined : Number(value);
}

export function Wave() {
  const { wave, overview } = useWave();
  const selected = useSelectedCycle();
  return (
    <section class="wave" aria-label="Waveform">
      <Toolbar />
      <div class="wave-overview">
        <canvas ref={overview} role="img" aria-label={`Overview of the capture: ${all.value}`} />
      </div>
      <div class="wave-picture" data-keys="waveform" tabIndex={0} role="group"
        aria-label="Waveform. Arrow keys move and zoom, ? lists the keys.">
        <canvas ref={wave} role="img" aria-label={waveText(selected, seen.value)} />
      </div>
    </section>
  );
}

function Toolbar() {
  return (
    <div class="wave-bar">
      <div class="wave-buttons" role="group" aria-label="Zoom">
        <Button label="Zoom in" text="+" run={() => actions.zoom(1 / 2)} />
        <Button label="Zoom out" text="−" run={() => actions.zoom(2)} />
        <Button label="All: show the whole capture" text="All" run={actions.showAll} />
        <Button label="Zoom to the selected cycle" text="Cycle" run={actions.showSelected} />
      </div>
      <Pointer />
      <CursorBar />
    </div>
  );
}

function Button({ label, text, run }: { label: string; text: string; run: () => void }) {
  return (
    <button type="button" aria-label={label} title={label} onClick={run}
      disabled={state.range.value === undefined}>
      {text}
    </button>
  );
}

function Pointer() {
  const at = pointed.value;
  const range = state.range.value;
  const width = range === undefined ? '' : `${timeText(range.to - range.from)} wide`;
  const text = at === undefined ? width : `${exactTimeText(at.time)}  ${at.text}`;
  return <p class="wave-pointer" title={text}>{text}</p>;
}

function putCursor(which: 'a' | 'b'): void {
  if (shownView === undefined) return;
  actions.setCursor(which, cursorTime(shownView, undefined));
}

function CursorBar() {
  const { a, b } = state.cursors.value;
  const difference = differenceText({ a, b });
  return (
    <div class="wave-cursors" role="group" aria-label="Cursors">
      <CursorButton which="a" time={a} />
      <CursorButton which="b" time={b} />
      {difference !== '' && (
        <>
          <output class="wave-difference" aria-label="B minus A">Δ {difference}</output>
          <Button label="A–B: zoom to the time between the cursors" text="A–B" run={actions.showCursors} />
        </>
      )}
      {(a ?? b) !== undefined && (
        <Button label="Remove the cursors" text="✕" run={actions.clearCursors} />
      )}
    </div>
  );
}

function CursorButton({ which, time }: { which: 'a' | 'b'; time: bigint | undefined }) {
  const name = which.toUpperCase();
  const text = time === undefined ? name : `${name} ${exactTimeText(time)}`;
  const label = `${text}: set this cursor in the middle`;
  return (
    <button type="button" class={`wave-cursor-${which}`} aria-label={label} title={label}
      disabled={state.range.value === undefined} onClick={() => putCursor(which)}>
      {text}
    </button>
  );
}
