// The summary of `biss decode`, of the data read so far.
import { harmlessStatuses, statuses } from '../core/statuses';
import * as state from '../state';
import { useAnswer } from './use_answer';

export function SummaryPanel() {
  const about = state.about.value;
  const found = useAnswer('summary', about === undefined ? undefined : {}, [about]);
  if (about === undefined) return <p class="quiet">Nothing has been read yet.</p>;
  const lines = (found?.answer ?? found?.error ?? '').trimEnd().split('\n');
  return (
    <>
      <h3>{lines[0]}</h3>
      <table class="facts">
        <caption class="sr">Summary of the capture</caption>
        <tbody>{lines.slice(1).map((line, i) => <Line key={i} line={line} />)}</tbody>
      </table>
      <Statuses line={lines.find((line) => line.startsWith('status'))} />
    </>
  );
}

// A name, a value and a note, two spaces or more between them; a line without a name belongs to the
// one before.
function Line({ line }: { line: string }) {
  const found = /^(\S.*?)?\s{2,}(.*?)(?:\s{2,}(.*))?$/.exec(line);
  if (found === null) return <tr><td colSpan={3}>{line}</td></tr>;
  const [, name = '', value = '', note = ''] = found;
  return (
    <tr>
      <th scope="row">{name}</th>
      <td>{value}</td>
      <td class="quiet">{note}</td>
    </tr>
  );
}

function Statuses({ line }: { line: string | undefined }) {
  const counts = [...(line ?? '').matchAll(/(\d+) ([a-z_]+)/g)];
  return (
    <div class="chips" role="group" aria-label="Show rows with this status">
      {counts.map(([, count, name = '']) => (
        <button key={name} type="button" title={statuses[name]} aria-pressed={state.filter.value === name}
          class={harmlessStatuses.has(name) ? 'chip' : 'chip bad-text'}
          onClick={() => { state.filter.value = state.filter.value === name ? '' : name; }}>
          {count} {name}
        </button>
      ))}
    </div>
  );
}
