// The findings of `biss explain`: the likely causes, the likeliest first.
import { useVerb, VerbView, verbArguments, zoomToCycle } from './verb';

export function ExplainPanel() {
  const result = useVerb(verbArguments(['explain'], ['--to', 'jsonl']));
  return (
    <VerbView result={result}>
      <ol class="causes">{result.rows.map((row, i) => <Cause key={i} row={row} />)}</ol>
    </VerbView>
  );
}

function Cause({ row }: { row: Record<string, unknown> }) {
  const likelihood = Number(row['likelihood']);
  const remedy = String(row['remedy'] ?? '');
  return (
    <li>
      <h3>
        {String(row['cause'])} <span class="quiet">{likelihood.toFixed(2)}</span>
      </h3>
      <meter min={0} max={1} value={likelihood} aria-label={`Likelihood ${likelihood.toFixed(2)}`} />
      <dl>
        <dt>Seen</dt>
        <dd>{String(row['evidence'] ?? '').split('; ').map((part, i) => <Evidence key={i} text={part} />)}</dd>
        {remedy !== '' && <><dt>Do</dt><dd>{remedy}</dd></>}
      </dl>
    </li>
  );
}

// "(cycles 13 to 391, …)": the first one can be shown.
function Evidence({ text }: { text: string }) {
  const first = /\bcycles? (\d+)/.exec(text)?.[1];
  return (
    <p>
      {text}
      {first !== undefined && (
        <> <button type="button" class="small" onClick={() => void zoomToCycle(Number(first))}>Show {first}</button></>
      )}
    </p>
  );
}
