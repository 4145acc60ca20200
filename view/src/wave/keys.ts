/** The keys of the waveform. */
import * as state from '../state';
import { defineKeys } from '../shell/keys';
import * as actions from './actions';
import type { WaveInput } from './input';
import type { WaveView } from './view';

/** The time at the pointer, at which a cursor is set; without a pointer, the middle of the picture. */
export function cursorTime(view: WaveView, input: WaveInput | undefined): bigint | undefined {
  if (input?.x !== undefined) return view.timeAt(input.x);
  const range = state.range.value;
  return range === undefined ? undefined : (range.from + range.to) / 2n;
}

export function defineWaveKeys(view: WaveView, input: WaveInput): void {
  let moved: 'a' | 'b' = 'a';
  const put = (which: 'a' | 'b') => () => {
    moved = which;
    actions.setCursor(which, cursorTime(view, input));
  };
  const toChange = (step: 1 | -1) => () => {
    const from = state.cursors.value[moved] ?? cursorTime(view, input);
    const to = from === undefined ? undefined : view.changeBeside(from, step);
    if (to !== undefined) actions.moveCursor(moved, to);
  };
  defineKeys('waveform', [
    { keys: ['ArrowLeft'], help: 'Move left', run: () => actions.pan(-1 / 8) },
    { keys: ['ArrowRight'], help: 'Move right', run: () => actions.pan(1 / 8) },
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
