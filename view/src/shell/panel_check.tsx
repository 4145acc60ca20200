// The results of `biss check`, rule by rule.
import { signal } from '@preact/signals';
import * as state from '../state';
import { encoders } from './encoders';
import { CycleLink, textOf, useVerb, VerbView, verbArguments } from './verb';

const against = signal('biss-c');
const judgedOnly = signal(true);
const profiles: Record<string, string> = { 'biss-c': 'BiSS C', renishaw: 'Renishaw data sheets' };
const order = ['fail', 'marginal', 'pass', 'not_judged'];
const signs: Record<string, string> = { fail: '✗', marginal: '!', pass: '✓', not_judged: '·' };
const kinds: Record<string, string> = { fail: 'bad-text', marginal: 'warn-text', pass: 'good-text' };

// Further columns of the table, with the class of their cells.
const columns: [string, string?][] = [
  ['limit', 'number'], ['worst', 'number'], ['margin', 'number'], ['unit'], ['cycle'], ['cases', 'number'],
  ['source', 'quiet'], ['note'],
];

function carriedLimits(): string[] {
  const verbs = state.isWhole.value ? Object.keys(state.report.value?.verbs ?? {}) : [];
  return verbs.flatMap((verb) => (verb.startsWith('check ') ? [verb.slice('check '.length)] : []));
}

export function CheckPanel() {
  // A report has the results of the whole capture for some limits only.
  const carried = carriedLimits();
  const limits = carried.length === 0 || carried.includes(against.value) ? against.value : carried[0]!;
  const result = useVerb(verbArguments(['check'], ['--against', limits, '--to', 'jsonl']));
  const rows = [...result.rows]
    .filter((row) => !judgedOnly.value || row['verdict'] !== 'not_judged')
    .sort((a, b) => order.indexOf(String(a['verdict'])) - order.indexOf(String(b['verdict'])));
  const count = (verdict: string) => result.rows.filter((row) => row['verdict'] === verdict).length;
  return (
    <>
      <div class="bar">
        <label>Against{' '}
          <select value={limits} onChange={(event) => { against.value = event.currentTarget.value; }}>
            {(carried.length > 0 ? carried : [...Object.keys(profiles), ...encoders.value])
              .map((name) => <option key={name} value={name}>{profiles[name] ?? name}</option>)}
          </select>
        </label>
        <label>
          <input type="checkbox" checked={judgedOnly.value} onChange={(event) => { judgedOnly.value = event.currentTarget.checked; }} />
          {' '}Judged rules only
        </label>
      </div>
      <VerbView result={result}>
        <p>{order.map((verdict) => `${count(verdict)} ${verdict}`).join(', ')}</p>
        <div class="wide" tabIndex={0} role="region" aria-label="Rules">
          <table class="facts rules">
            <thead>
              <tr>
                <th>verdict</th><th>rule</th>
                {columns.map(([name, kind]) => <th key={name} class={kind === 'number' ? kind : undefined}>{name}</th>)}
              </tr>
            </thead>
            <tbody>{rows.map((row) => <Rule key={String(row['rule'])} row={row} />)}</tbody>
          </table>
        </div>
      </VerbView>
    </>
  );
}

function Rule({ row }: { row: Record<string, unknown> }) {
  const verdict = String(row['verdict']);
  return (
    <tr>
      <td class={kinds[verdict]}>{signs[verdict]} {verdict}</td>
      <th scope="row">{String(row['rule'])}</th>
      {columns.map(([name, kind]) => (
        <td key={name} class={kind}>{name === 'cycle' ? <CycleLink cycle={row[name]} /> : textOf(row[name])}</td>
      ))}
    </tr>
  );
}
