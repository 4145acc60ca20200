// The page as a whole.
import { signal, type Signal } from '@preact/signals';
import * as state from '../state';
import { Wave } from '../wave/wave';
import { isCarried } from './carried';
import { chooseFiles, openUserFiles } from './files';
import { Header } from './header';
import { Help } from './help';
import { LivePanel, liveName } from './live';
import { Panels } from './panels';
import { PrintPage } from './print';
import { exampleActions, SimulatePanel } from './simulate';
import { MessageBar, StatusBar } from './status_bar';
import { Table } from './table';
import { filterError, shownCount } from './table_rows';

const isOver = signal(false);
const waveShare = signal(54);
const tableShare = signal(50);
const shareLeast = 15;
const shareMost = 85;

function onDrag(event: DragEvent): void {
  if (!event.dataTransfer?.types.includes('Files')) return;
  event.preventDefault();
  isOver.value = event.type !== 'dragleave' || event.relatedTarget !== null;
}

function onDrop(event: DragEvent): void {
  event.preventDefault();
  isOver.value = false;
  void openUserFiles([...(event.dataTransfer?.files ?? [])]);
}

export function App() {
  const kind = ['app', isOver.value && 'over', isCarried && 'printed'].filter(Boolean).join(' ');
  return (
    <>
    <div class={kind} onDragEnter={onDrag} onDragOver={onDrag} onDragLeave={onDrag} onDrop={onDrop}>
      <Header />
      <MessageBar />
      <ReportBar />
      <main>
        <SimulatePanel />
        {state.file.value !== undefined ? <Work /> : liveName.value === '' ? <Welcome /> : <LivePanel />}
      </main>
      <StatusBar />
      <Help />
      <div class="sr" role="status" aria-live="polite">{state.announcement.value}</div>
    </div>
    {/* Pages that show a file of the user do not read all of it for paper. */}
    {isCarried && <PrintPage />}
    </>
  );
}

// The page before a capture is open.
function Welcome() {
  const busy = state.progress.value.state === 'loading';
  return (
    <div class="welcome">
      <button type="button" class="drop" onClick={chooseFiles}>
        <strong>Drop a capture of MA and SLO here</strong>
        <span>or choose a file: VCD, FST, CSV, .sr, .dsl, Saleae CSV and binary, raw samples; also .gz</span>
        <span>Several files with one line each are one capture.</span>
      </button>
      <section aria-label="Examples">
        <h2>Or look at an example</h2>
        <ul class="examples">
          {exampleActions.map(({ name, about, run }) => (
            <li key={name}>
              <button type="button" disabled={busy} onClick={run}>
                <strong>{name}</strong>
                <span>{about}</span>
              </button>
            </li>
          ))}
        </ul>
      </section>
      <p class="quiet">Nothing leaves this machine: the page reads the file here, and asks no server for anything.</p>
    </div>
  );
}

function Work() {
  const upper = waveShare.value;
  const left = tableShare.value;
  return (
    <div class="work" style={{ gridTemplateRows: `minmax(0, ${upper}fr) 7px minmax(0, ${100 - upper}fr)` }}>
      <Wave />
      <Splitter share={waveShare} direction="row" label="Height of the waveform" />
      <div class="lower" style={{ gridTemplateColumns: `minmax(0, ${left}fr) 7px minmax(0, ${100 - left}fr)` }}>
        <section class="cycles" aria-label="Cycles">
          <FilterBar />
          <Table />
        </section>
        <Splitter share={tableShare} direction="column" label="Width of the table" />
        <Panels />
      </div>
    </div>
  );
}

// A bar between two parts of the page, moved by pointer or arrows. It sets a share in percent.
interface SplitterProps {
  share: Signal<number>;
  direction: 'row' | 'column';
  label: string;
}

function Splitter({ share, direction, label }: SplitterProps) {
  const set = (value: number) => { share.value = Math.max(shareLeast, Math.min(shareMost, value)); };
  const onMove = (event: PointerEvent) => {
    const bar = event.currentTarget as HTMLElement;
    if (!bar.hasPointerCapture(event.pointerId)) return;
    const around = bar.parentElement!.getBoundingClientRect();
    set(direction === 'row'
      ? ((event.clientY - around.top) / around.height) * 100
      : ((event.clientX - around.left) / around.width) * 100);
  };
  const onKey = (event: KeyboardEvent) => {
    const step = { ArrowUp: -2, ArrowLeft: -2, ArrowDown: 2, ArrowRight: 2 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    set(share.value + step);
  };
  return (
    <div class={`splitter splitter-${direction}`} role="separator" tabIndex={0} aria-label={label}
      aria-orientation={direction === 'row' ? 'horizontal' : 'vertical'}
      aria-valuenow={Math.round(share.value)} aria-valuemin={shareLeast} aria-valuemax={shareMost}
      onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
      onPointerMove={onMove} onKeyDown={onKey} />
  );
}

function FilterBar() {
  const filter = state.filter.value;
  return (
    <div class="bar filter-bar">
      <h2>Cycles</h2>
      <button type="button" class="small" aria-pressed={filter === ''} onClick={() => { state.filter.value = ''; }}>All</button>
      <button type="button" class="small" aria-pressed={filter === 'error'} onClick={() => { state.filter.value = 'error'; }}>Errors</button>
      {filter !== '' && filter !== 'error' && (
        <button type="button" class="small" aria-pressed="true" title="Show all rows" onClick={() => { state.filter.value = ''; }}>{filter} ✕</button>
      )}
      <span class={filterError.value === '' ? 'quiet' : 'bad-text'}>
        {filterError.value !== '' ? filterError.value
          : filter === '' ? `${state.rowCount.value} rows` : `${shownCount()} of ${state.rowCount.value} rows`}
      </span>
    </div>
  );
}

// The contents of a report, and the data left out.
function ReportBar() {
  const report = state.report.value;
  if (report === undefined) return null;
  const other = 'Read with other settings than the report: everything shown comes from the cycles in it.';
  const notes = state.isWhole.value ? report.notes : [other, ...report.notes];
  return (
    <details class="report-bar">
      <summary>{notes[0]}</summary>
      {notes.slice(1).map((note) => <p key={note}>{note}</p>)}
    </details>
  );
}
