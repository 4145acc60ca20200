// Registers and the electronic data sheet: as the accesses of the capture show them, or of a file.
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import type { RunResult } from 'biss';
import { cellsOfCsv, decoded } from '../core/texts';
import { runOnFile, runVerb } from '../core/verbs';
import * as state from '../state';
import { CycleLink, textOf, useVerb, VerbView, verbArguments } from './verb';

interface Sheet {
  of: string;
  /** The reading of the capture that it belongs to; empty for a file. */
  key: string;
  fields: string[][];
  words: string;
  check: string;
}

const sheet = signal<Sheet | undefined>(undefined);
let shownFor = '';

// The registers read in the accesses of a capture, as a file of the core.
const dumpName = 'registers_seen.hex';

// Reads the data sheet in a dump: the fields from CSV, the words from the summary of the table. If the dump
// is from a capture, the data sheet is shown only if there is one and no other capture has been opened.
async function readSheet(of: string, key: string, dump: string, run: (args: string[]) => Promise<RunResult>): Promise<void> {
  const show = await run(['eds', 'show', dump, '--to', 'csv']);
  const table = await run(['eds', 'show', dump]);
  const check = await run(['eds', 'check', dump]);
  if (key !== '' && (shownFor !== key || show.status >= 2)) return;
  sheet.value = {
    of, key, fields: cellsOfCsv(decoded(show.out)),
    words: show.status === 0 ? table.err : show.err,
    check: `${decoded(check.out)}${check.err}`,
  };
}

async function showFile(file: File): Promise<void> {
  const given = { name: `dump_${file.name.replace(/[/\0]/g, '_')}`, content: file };
  await readSheet(file.name, '', given.name, (args) => runOnFile(given, args));
}

async function showCapture(key: string): Promise<void> {
  shownFor = key;
  const dump = await runVerb(verbArguments(['registers'], ['--dump', dumpName]));
  if (dump.status === 0) await readSheet('the registers of the capture', key, dumpName, runVerb);
}

export function EdsPanel() {
  const accesses = useVerb(verbArguments(['registers'], ['--to', 'jsonl']));
  const key = `${state.generation.value}`;
  // A part of a capture does not show what the registers hold.
  const isPart = state.report.value !== undefined;
  const seen = accesses.state === 'done' && accesses.rows.length > 0 && !isPart;
  const shown = sheet.value?.key === '' || sheet.value?.key === key ? sheet.value : undefined;
  useEffect(() => { if (seen && shownFor !== key) void showCapture(key); }, [seen, key]);
  return (
    <>
      <div class="bar">
        <label class="button">
          Open a dump of registers …
          <input type="file" class="sr" onChange={(event) => {
            const [file] = event.currentTarget.files ?? [];
            if (file !== undefined) void showFile(file);
          }} />
        </label>
      </div>
      {shown && <SheetView sheet={shown} />}
      <h3>Accesses in the capture</h3>
      <VerbView result={accesses}>
        {accesses.rows.length === 0
          ? <p class="quiet">CDM and CDS carry no access to registers.</p>
          : <Accesses rows={accesses.rows} />}
      </VerbView>
    </>
  );
}

function SheetView({ sheet: { of, fields, words, check } }: { sheet: Sheet }) {
  const [head = [], ...rows] = fields;
  return (
    <section>
      <h3>Data sheet of {of}</h3>
      <pre class="words" tabIndex={0} aria-label="What the data sheet says">{words}</pre>
      <h3>Check of the data sheet</h3>
      <pre class="words" tabIndex={0} aria-label="Check of the data sheet">{check}</pre>
      {rows.length > 0 && (
        <div class="wide" tabIndex={0} role="region" aria-label="Fields of the data sheet">
          <table class="facts">
            <thead><tr>{head.map((name) => <th key={name}>{name}</th>)}</tr></thead>
            <tbody>{rows.map((row, i) => <tr key={i}>{row.map((cell, k) => <td key={k}>{cell}</td>)}</tr>)}</tbody>
          </table>
        </div>
      )}
    </section>
  );
}

const mostAccesses = 500;
const keys = ['id', 'access', 'address', 'name', 'data', 'outcome'];

function Accesses({ rows }: { rows: Record<string, unknown>[] }) {
  return (
    <div class="wide" tabIndex={0} role="region" aria-label="Accesses">
      <table class="facts">
        <thead><tr><th>cycle</th>{keys.map((key) => <th key={key}>{key}</th>)}</tr></thead>
        <tbody>
          {rows.slice(0, mostAccesses).map((row, i) => (
            <tr key={i}>
              <td><CycleLink cycle={row['cycle']} /></td>
              {keys.map((key) => <td key={key}>{textOf(row[key])}</td>)}
            </tr>
          ))}
        </tbody>
      </table>
      {rows.length > mostAccesses && <p class="quiet">The first {mostAccesses} of {rows.length} accesses.</p>}
    </div>
  );
}
