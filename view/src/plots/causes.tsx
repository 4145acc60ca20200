/** How many cycles have each status, flag, limit and verdict, and when in the capture. */
import { markOf, statuses } from '../core/statuses';
import { searchOn } from '../shell/search';
import { useAnswer } from '../shell/use_answer';
import * as state from '../state';
import type { Cause } from './causes_of';
import { steadyRows } from '../wave/tiles';

const bins = 60;
// Counting and measuring delay the waveform.
export const pause = 300;

function columnOf(cause: Cause) {
  return state.columns.value.find(({ name }) => name === cause.column);
}

/** As the search field has it. */
function conditionOf(cause: Cause): string {
  const column = columnOf(cause);
  const isCondition = column?.role === 'status' || column?.kind === 'flag';
  return isCondition ? cause.name : `${cause.column} = ${cause.name}`;
}

function isHarmless(cause: Cause): boolean {
  const column = columnOf(cause);
  return column !== undefined && column.kind !== 'flag' && markOf(column.role, cause.name) === '';
}

export function Causes() {
  const rows = steadyRows();
  const ask = rows > 0 ? { bins } : undefined;
  const counted = useAnswer('analyse.causes', ask, [state.generation.value, rows], pause)?.answer;
  if (counted === undefined || counted.causes.length === 0) return null;
  const groups = new Map<string, Cause[]>();
  for (const cause of counted.causes) {
    const title = columnOf(cause)?.title ?? cause.column;
    groups.set(title, [...(groups.get(title) ?? []), cause]);
  }
  return (
    <section aria-label="Histogram of causes">
      <h3>Causes, in {counted.rows} cycles</h3>
      <table class="facts plot-causes">
        <thead>
          <tr>
            {['cause', 'cycles', 'share', 'over the capture'].map((name) => <th key={name} scope="col">{name}</th>)}
          </tr>
        </thead>
        {[...groups].map(([title, causes]) => (
          <tbody key={title}>
            <tr><th colSpan={4} scope="colgroup" class="plot-group">{title}</th></tr>
            {causes.map((cause) => (
              <Row key={`${cause.column} ${cause.name}`} cause={cause} rows={counted.rows} />
            ))}
          </tbody>
        ))}
      </table>
    </section>
  );
}

function shareText(count: number, rows: number): string {
  const percent = (100 * count) / Math.max(1, rows);
  return percent >= 0.01 || count === 0 ? `${percent.toFixed(2)} %` : '< 0.01 %';
}

function Row({ cause, rows }: { cause: Cause; rows: number }) {
  const condition = conditionOf(cause);
  const next = () => {
    state.search.value = condition;
    void searchOn(1, condition);
  };
  const kind = isHarmless(cause) ? 'plot-harmless' : 'plot-harmful';
  return (
    <tr class={kind}>
      <td>
        <button type="button" class="link" onClick={next}
          title={statuses[cause.name] ?? `Search for ${condition}`} aria-label={`Next cycle with ${cause.name}`}>
          {cause.name}
        </button>
      </td>
      <td class="number">{cause.count}</td>
      <td>
        <span class="plot-share">
          <svg viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true">
            <rect class="plot-bar" width={Math.max(1, (100 * cause.count) / Math.max(1, rows))} height="10" />
          </svg>
          {shareText(cause.count, rows)}
        </span>
      </td>
      <td><Spark over={cause.over} /></td>
    </tr>
  );
}

function Spark({ over }: { over: Uint32Array }) {
  const most = over.reduce((found, count) => Math.max(found, count), 1);
  const bars = [...over].map((count, i) => {
    const height = count === 0 ? 0 : Math.max(2, (16 * count) / most);
    return count === 0 ? '' : `M${i} 16v${-height}h1v${height}z`;
  });
  return (
    <svg class="plot-spark" viewBox={`0 0 ${over.length} 16`} preserveAspectRatio="none" role="img"
      aria-label={`at most ${most} in a ${over.length}th of the capture`}>
      <path class="plot-bar" d={bars.join('')} />
    </svg>
  );
}
