/** The waveform of MA and SLO, the decoded tracks below it, the overview strip and the cursors. */
import './wave.css';
import { signal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { defineKeys } from '../shell/keys';
import { useAnswer } from '../shell/use_answer';
import * as state from '../state';
import * as actions from './actions';
import { listenToOverview, WaveInput, type Pointed } from './input';
import { Overview } from './overview';
import { exactTimeText, rateText, timeText } from './scale';
import { WaveView } from './view';

/** The cycles in the picture and in the overview, in words. */
const seen = signal('');
const all = signal('');
const pointed = signal<Pointed | undefined>(undefined);

function middle(): bigint | undefined {
  const range = state.range.value;
  return range && (range.from + range.to) / 2n;
}

function defineWaveKeys(view: WaveView, input: WaveInput): void {
  const pointerTime = () => (input.x === undefined ? middle() : view.timeAt(input.x));
  let moved: 'a' | 'b' = 'a';
  const put = (which: 'a' | 'b') => () => {
    moved = which;
    actions.setCursor(which, pointerTime());
  };
  const toChange = (step: 1 | -1) => () => {
    const from = state.cursors.value[moved] ?? pointerTime();
    const to = from === undefined ? undefined : view.changeBeside(from, step);
    if (to !== undefined) actions.moveCursor(moved, to);
  };
  defineKeys('waveform', [
    ...actions.moveKeys,
    { keys: ['PageUp', 'Shift+ArrowLeft'], help: 'One picture to the left', run: () => actions.pan(-0.9) },
    { keys: ['PageDown', 'Shift+ArrowRight'], help: 'One picture to the right', run: () => actions.pan(0.9) },
    { keys: ['ArrowUp', '+', '='], help: 'Zoom in', run: () => actions.zoom(1 / 1.5) },
    { keys: ['ArrowDown', '-'], help: 'Zoom out', run: () => actions.zoom(1.5) },
    { keys: ['Home'], help: 'Beginning of the capture', run: () => actions.showEnd('first') },
    { keys: ['End'], help: 'End of the capture', run: () => actions.showEnd('last') },
    { keys: ['0'], help: 'The whole capture', run: actions.showAll },
    { keys: ['.'], help: 'Select the next cycle', run: () => actions.selectNext(1) },
    { keys: [','], help: 'Select the cycle before', run: () => actions.selectNext(-1) },
    { keys: ['Enter'], help: 'Zoom to the selected cycle', run: actions.showSelected },
    { keys: ['a'], help: 'Cursor A at the pointer, or in the middle', run: put('a') },
    { keys: ['b'], help: 'Cursor B at the pointer, or in the middle', run: put('b') },
    { keys: [']'], help: 'This cursor to the next change of a line', run: toChange(1) },
    { keys: ['['], help: 'This cursor to the change before', run: toChange(-1) },
    { keys: ['x'], help: 'Remove the cursors', run: actions.clearCursors },
    { keys: ['z'], help: 'Zoom to the time between the cursors', run: actions.showCursors },
  ]);
}

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
    return () => {
      stopOverview();
      whole.surface.close();
      input.close();
      view.surface.close();
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
    <button type="button" class="small" aria-label={label} title={label} onClick={run}
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
  return <p class="wave-pointer quiet" title={text}>{text}</p>;
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
    <button type="button" class={`small wave-cursor-${which}`} aria-label={label} title={label}
      disabled={state.range.value === undefined} onClick={() => actions.setCursor(which, middle())}>
      {text}
    </button>
  );
}

// `Δ 1.2 µs (833 kHz)`; empty if a cursor is missing.
function differenceText({ a, b }: state.Cursors): string {
  if (a === undefined || b === undefined) return '';
  const difference = b - a;
  if (difference === 0n) return '0 s';
  return `${exactTimeText(difference)} (${rateText(1e12 / Math.abs(Number(difference)))})`;
}

// For who does not see the picture.
// \param selected the number of the cycle that is selected
// \param seen the cycles in the picture, in words
function waveText(selected: number | undefined, seen: string): string {
  const range = state.range.value;
  const cursors = state.cursors.value;
  if (range === undefined) return 'Waveform of MA and SLO: no capture is open.';
  const extent = `${exactTimeText(range.from)} to ${exactTimeText(range.to)}, ${timeText(range.to - range.from)} wide`;
  const parts = [`Waveform of MA and SLO from ${extent}; ${state.rowCount.value} cycles have been read.`];
  if (seen !== '') parts.push(`In the picture: ${seen}.`);
  if (selected !== undefined) parts.push(`Cycle ${selected} is selected.`);
  if (cursors.a !== undefined) parts.push(`Cursor A at ${exactTimeText(cursors.a)}.`);
  if (cursors.b !== undefined) parts.push(`Cursor B at ${exactTimeText(cursors.b)}.`);
  const difference = differenceText(cursors);
  if (difference !== '') parts.push(`B is ${difference} after A.`);
  return parts.join(' ');
}
