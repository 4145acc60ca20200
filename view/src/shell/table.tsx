// The table of cycles: the rows of `biss decode --to csv`, as many as fit.
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import type { Column } from 'biss';
import { harmlessStatuses, markOf, statuses } from '../core/statuses';
import { selectRow, zoomToRow } from '../selection';
import * as state from '../state';
import { defineKeys } from './keys';
import { arrived, cellsOf, placeOfRow, rowAtPlace, shownCount, want } from './table_rows';

const rowHeight = 24;
const headHeight = 28;
// Browsers limit the height of an element; beyond it the scroll bar moves by more than a row.
const mostHeight = 8_000_000;

interface Shown {
  /** The place at the top, with its fraction. */
  top: number;
  height: number;
}

/** Pixels of the scroll bar for a place at the top, and back. */
function scaleOf(count: number, height: number): number {
  const room = Math.max(1, count * rowHeight - height);
  return Math.min(1, (mostHeight - height) / room);
}

function moveBy(step: number): void {
  const count = shownCount();
  if (count === 0) return;
  const now = state.selectedRow.value;
  const place = now === undefined ? (step > 0 ? 0 : count - 1) : placeOfRow(now) + step;
  void selectRow(rowAtPlace(Math.max(0, Math.min(count - 1, place))));
}

function moveTo(place: number): void {
  void selectRow(rowAtPlace(place));
}

defineKeys('table', [
  { keys: ['ArrowDown', 'j'], help: 'Next row', run: () => moveBy(1) },
  { keys: ['ArrowUp', 'k'], help: 'Previous row', run: () => moveBy(-1) },
  { keys: ['PageDown'], help: 'A page down', run: () => moveBy(15) },
  { keys: ['PageUp'], help: 'A page up', run: () => moveBy(-15) },
  { keys: ['Home', 'Ctrl+Home'], help: 'First row', run: () => moveTo(0) },
  { keys: ['End', 'Ctrl+End'], help: 'Last row', run: () => moveTo(shownCount() - 1) },
  {
    keys: ['Enter'],
    help: 'Show the cycle alone in the waveform',
    run: () => { if (state.selectedRow.value !== undefined) void zoomToRow(state.selectedRow.value); },
  },
]);

export function Table() {
  const box = useRef<HTMLDivElement>(null);
  const [shown, setShown] = useState<Shown>({ top: 0, height: 300 });
  const count = shownCount();
  arrived.value;

  const measure = () => {
    const element = box.current;
    if (element === null) return;
    const height = element.clientHeight - headHeight;
    setShown({ top: element.scrollTop / scaleOf(count, height) / rowHeight, height });
  };
  useLayoutEffect(measure, [count]);
  useEffect(() => {
    const observer = new ResizeObserver(measure);
    observer.observe(box.current!);
    return () => observer.disconnect();
  }, [count]);
  useScrollToSelection(box, count, shown);

  const first = Math.max(0, Math.floor(shown.top));
  const last = Math.min(count, first + Math.ceil(shown.height / rowHeight) + 1);
  useEffect(() => { void want(first, last); });

  const columns = state.columns.value;
  const widths = useWidths(columns, first, last);
  const scale = scaleOf(count, shown.height);
  const selected = state.selectedRow.value;
  const rows = [];
  for (let place = first; place < last; place += 1) {
    const top = headHeight + (place - shown.top * (1 - scale)) * rowHeight;
    const row = rowAtPlace(place);
    rows.push(<Row key={place} row={row} place={place} top={top} columns={columns} widths={widths} cells={cellsOf(row)} />);
  }
  return (
    <div id="table" ref={box} class="table" role="grid" tabIndex={0} data-keys="table" aria-label="Request cycles"
      aria-rowcount={count + 1} aria-colcount={columns.length} onScroll={measure}
      aria-activedescendant={isShown(selected, first, last) ? `row-${selected}` : undefined}>
      <div class="table-space" role="presentation" style={{ height: `${headHeight + count * rowHeight * scale + (1 - scale) * shown.height}px` }}>
        <Head columns={columns} widths={widths} />
        {rows}
      </div>
    </div>
  );
}

function isShown(row: number | undefined, first: number, last: number): boolean {
  if (row === undefined) return false;
  const place = placeOfRow(row);
  return place >= first && place < last && rowAtPlace(place) === row;
}

// A selection from elsewhere comes into view; scrolling by the user does not change it.
function useScrollToSelection(box: { current: HTMLDivElement | null }, count: number, shown: Shown): void {
  const selected = state.selectedRow.value;
  useLayoutEffect(() => {
    const element = box.current;
    if (element === null || selected === undefined || count === 0) return;
    const place = placeOfRow(selected);
    const whole = Math.floor(shown.height / rowHeight);
    if (place >= shown.top && place < shown.top + whole) return;
    const near = Math.abs(place - shown.top) <= whole + 1;
    const top = near ? (place < shown.top ? place : place - whole + 1) : place - Math.floor(whole / 2);
    element.scrollTop = Math.max(0, top) * rowHeight * scaleOf(count, shown.height);
  }, [selected, count > (selected ?? 0)]);
}

// Columns become wider as wider cells come, and never narrower.
function useWidths(columns: readonly Column[], first: number, last: number): number[] {
  const widths = useRef<{ columns: readonly Column[]; widths: number[] }>({ columns: [], widths: [] });
  const names = columns.map((column) => column.name).join();
  if (widths.current.columns.map((column) => column.name).join() !== names) {
    widths.current = { columns, widths: columns.map(({ name }) => Math.max(3, name.length)) };
  }
  const own = [...widths.current.widths];
  for (let place = first; place < last; place += 1) {
    cellsOf(rowAtPlace(place))?.forEach((cell, i) => { own[i] = Math.max(own[i] ?? 3, cell.length); });
  }
  // The same array while nothing has changed, so that rows are not drawn again.
  if (own.some((width, i) => width !== widths.current.widths[i])) widths.current.widths = own;
  return widths.current.widths;
}

function alignment(column: Column): string {
  return column.kind === 'text' || column.kind === 'bits' ? 'cell text' : 'cell';
}

function widthOf(characters: number | undefined) {
  return { width: `calc(${characters ?? 3}ch + 18px)` };
}

function Head({ columns, widths }: { columns: readonly Column[]; widths: number[] }) {
  return (
    <div role="row" aria-rowindex={1} class="head">
      {columns.map((column, i) => (
        <span key={column.name} role="columnheader" class={alignment(column)} style={widthOf(widths[i])}>
          {column.name}
        </span>
      ))}
    </div>
  );
}

interface RowProps {
  row: number;
  place: number;
  top: number;
  columns: readonly Column[];
  widths: number[];
  cells: string[] | undefined;
}

function Row({ row, place, top, columns, widths, cells }: RowProps) {
  const selected = state.selectedRow.value === row;
  const status = cells?.[columns.findIndex(({ role }) => role === 'status')] ?? 'ok';
  const kind = harmlessStatuses.has(status) ? '' : ' failed';
  return (
    <div role="row" id={`row-${row}`} aria-rowindex={place + 2} aria-selected={selected} style={{ top: `${top}px` }}
      class={`row${kind}${selected ? ' selected' : ''}`}
      onClick={() => void selectRow(row)} onDblClick={() => void zoomToRow(row)}>
      {columns.map((column, i) => (
        <span key={column.name} role="gridcell" class={`${alignment(column)}${markClass(column, cells?.[i])}`}
          style={widthOf(widths[i])} title={column.role === 'status' ? statuses[status] : undefined}>
          {cells?.[i] ?? (i === 0 ? String(row) : '')}
        </span>
      ))}
    </div>
  );
}

function markClass({ role }: Column, cell = ''): string {
  return role === 'status' && cell === 'ok' ? ' good' : ` ${markOf(role, cell)}`.trimEnd();
}
