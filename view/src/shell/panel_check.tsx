// What `biss check` says, rule by rule.
import { signal } from '@preact/signals';
import * as state from '../state';
import { encoders } from './encoders';
import { CycleLink, textOf, useVerb, VerbView, verbArguments, zoomToCycle } from './verb';

const against = signal('biss-c');
const judgedOnly = signal(true);
const order = ['fail', 'marginal', 'pass', 'not_judged'];
const signs: Record<string, string> = { fail: '✗', marginal: '!', pass: '✓', not_judged: '·' };
const kinds: Record<string, string> = { fail: 'bad-text', marginal: 'warn-text', pass: 'good-text' };

export function CheckPanel() {
  // A report says it of the whole capture for these limits.
  const limits = state.isWhole.value ? 'biss-c' : against.value;
  const result = useVerb(verbArguments(['check'], ['--against', limits, '--to', 'jsonl']));
  const rows = [...result.rows]
    .filter((row) => !judgedOnly.value || row['verdict'] !== 'not_judged')
    .sort((a, b) => order.indexOf(String(a['verdict'])) - order.indexOf(String(b['verdict'])));
  const count = (verdict: string) => result.rows.filter((row) => row['verdict'] === verdict).length;
  return (
    <>
      <div class="bar">
        <label>Against{' '}
          <select value={limits} disabled={state.isWhole.value} onChange={(event) => { against.value = event.currentTarget.value; }}>
            <option value="biss-c">BiSS C</option>
            <option value="renishaw">Renishaw data sheets</option>
            {encoders.value.map((name) => <option key={name}>{name}</option>)}
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
                <th>verdict</th><th>rule</th><th class="number">limit</th><th class="number">worst</th>
                <th class="number">margin</th><th>unit</th><th>cycle</th><th class="number">cases</th><th>source</th><th>note</th>
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
      <td class="number">{textOf(row['limit'])}</td>
      <td class="number">{textOf(row['worst'])}</td>
      <td class="number">{textOf(row['margin'])}</td>
      <td>{textOf(row['unit'])}</td>
      <td><CycleLink cycle={row['cycle']} go={(cycle) => void zoomToCycle(cycle)} /></td>
      <td class="number">{textOf(row['cases'])}</td>
      <td class="quiet">{textOf(row['source'])}</td>
      <td>{textOf(row['note'])}</td>
    </tr>
  );
}
