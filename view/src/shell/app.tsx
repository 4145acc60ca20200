// The page as a whole.
import { signal } from '@preact/signals';
import * as state from '../state';
import { Wave } from '../wave/wave';
import { announcement } from './announce';
import { openUserFiles } from './files';
import { Header } from './header';
import { Help } from './help';
import { Panels } from './panels';
import { isPrinted, PrintPage } from './print';
import { ReportBar } from './report_bar';
import { SimulatePanel } from './simulate';
import { Splitter } from './splitter';
import { MessageBar, StatusBar } from './status_bar';
import { Table } from './table';
import { filterError, shownCount } from './table_rows';
import { Welcome } from './welcome';

const isOver = signal(false);
const waveShare = signal(54);
const tableShare = signal(50);

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
  const kind = ['app', isOver.value && 'over', isPrinted && 'printed'].filter(Boolean).join(' ');
  return (
    <>
    <div class={kind} onDragEnter={onDrag} onDragOver={onDrag} onDragLeave={onDrag} onDrop={onDrop}>
      <Header />
      <MessageBar />
      <ReportBar />
      <main>
        <SimulatePanel />
        {state.file.value === undefined ? <Welcome /> : <Work />}
      </main>
      <StatusBar />
      <Help />
      <div class="sr" role="status" aria-live="polite">{announcement.value}</div>
    </div>
    {isPrinted && <PrintPage />}
    </>
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
