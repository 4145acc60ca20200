// The printed form of a page that contains its capture: all important parts, one below the other.
import './print.css';
import { useEffect, useState } from 'preact/hooks';
import { core } from '../core/core';
import type { Causes } from '../plots/causes_of';
import { extremes, type Envelope } from '../plots/envelope';
import { columnPlots } from '../plots/plot_list';
import type { PlotSpec } from '../plots/plot_view';
import * as state from '../state';
import { identifyArguments, textOf, useVerb, verbArguments } from './verb';

const mostFailed = 200;
const points = 600;

type Content = Awaited<ReturnType<typeof contentOf>>;

async function contentOf() {
  const range = state.wholeRange.value;
  const plots = columnPlots(state.columns.value);
  const [summary, causes, rows, ...values] = await Promise.all([
    core().ask('summary', {}),
    core().ask('analyse.causes', { bins: 60 }),
    core().ask('findAll', { condition: 'error', most: 1_000_000 }),
    ...plots.map(({ id }) => core().ask('analyse.envelope', { column: id, ...range, points })),
  ]);
  const cells = await core().ask('cellsOf', { rows: [...rows.slice(0, mostFailed)] });
  return {
    summary,
    causes,
    plots: plots.flatMap((plot, i) => (values[i] === undefined ? [] : [{ plot, values: values[i] }])),
    failed: state.isWhole.value ? state.report.value?.failed ?? rows.length : rows.length,
    rows: cells,
  };
}

/** Shown on paper alone. */
export function PrintPage() {
  const [content, setContent] = useState<Content>();
  const generation = state.generation.value;
  const ended = state.progress.value.state === 'ended';
  useEffect(() => {
    setContent(undefined);
    if (!ended) return undefined;
    // The picture on the screen comes first.
    const timer = setTimeout(() => { contentOf().then(setContent, () => {}); }, 200);
    return () => clearTimeout(timer);
  }, [generation, ended]);
  if (content === undefined) return null;
  return (
    <article class="print" aria-hidden="true">
      <h1>{state.file.value?.name}</h1>
      {state.report.value?.notes.map((note) => <p key={note}>{note}</p>)}
      <h2>Summary</h2>
      <pre>{content.summary.trim()}</pre>
      <Verdicts />
      <h2>Causes, in {content.causes.rows} cycles</h2>
      <CausesTable causes={content.causes} />
      <h2>Plots</h2>
      {content.plots.map(({ plot, values }) => <Plot key={plot.id} plot={plot} values={values} />)}
      <h2>Failed cycles</h2>
      <Failed content={content} />
    </article>
  );
}

function Verdicts() {
  const found = useVerb(identifyArguments());
  const checked = useVerb(verbArguments(['check'], ['--against', 'biss-c', '--to', 'jsonl']));
  const explained = useVerb(verbArguments(['explain'], ['--to', 'jsonl']));
  const bad = checked.rows.filter(({ verdict }) => verdict === 'fail' || verdict === 'marginal');
  return (
    <>
      <h2>Identify</h2>
      {found.rows.map((row, i) => (
        <p key={i}>
          {textOf(row['protocol'])}, format <code>{textOf(row['format'])}</code>, confidence {textOf(row['confidence'])};
          encoders: {textOf(row['encoders'])}
        </p>
      ))}
      <h2>Check</h2>
      <pre>{checked.words.trim()}</pre>
      {bad.map((row, i) => (
        <p key={i}>
          {textOf(row['verdict'])}: {textOf(row['rule'])}, worst {textOf(row['worst'])}, limit {textOf(row['limit'])}
          {' '}{textOf(row['unit'])}, cycle {textOf(row['cycle'])}
        </p>
      ))}
      <h2>Explain</h2>
      {explained.rows.map((row, i) => (
        <p key={i}>
          <strong>{textOf(row['cause'])}</strong> ({Number(row['likelihood']).toFixed(2)}): {textOf(row['evidence'])}
          {' '}{row['remedy'] ? `Do: ${textOf(row['remedy'])}` : ''}
        </p>
      ))}
    </>
  );
}

function CausesTable({ causes }: { causes: Causes }) {
  return (
    <table>
      <thead><tr><th>column</th><th>cause</th><th class="number">cycles</th></tr></thead>
      <tbody>
        {causes.causes.map(({ column, name, count }) => (
          <tr key={`${column} ${name}`}><td>{column}</td><td>{name}</td><td class="number">{count}</td></tr>
        ))}
      </tbody>
    </table>
  );
}

function Failed({ content }: { content: Content }) {
  // The number and the time of the cycle, and the quantity that is plotted or counted.
  const shown = [...state.columns.value.keys()]
    .filter((place) => place < 2 || state.columns.value[place]?.title !== '');
  const { failed, rows } = content;
  if (failed === 0) return <p>None.</p>;
  return (
    <>
      {rows.length < failed && <p>The first {rows.length} of {failed}.</p>}
      <table class="rows">
        <thead><tr>{shown.map((place) => <th key={place}>{state.columns.value[place]?.name}</th>)}</tr></thead>
        <tbody>
          {rows.map((cells) => (
            <tr key={cells[0]}>{shown.map((place) => <td key={place}>{cells[place]}</td>)}</tr>
          ))}
        </tbody>
      </table>
    </>
  );
}

const width = 680;
const height = 110;

// A band from the lowest to the highest values, with the extremes in words.
function Plot({ plot, values }: { plot: PlotSpec; values: Envelope }) {
  const { low, high, times } = values;
  const { low: least, high: most } = extremes(low, high);
  if (Number.isNaN(least)) return null;
  const { from, to } = state.wholeRange.value;
  const span = Math.max(1, Number(to - from));
  const x = (i: number) => ((width * (times[i] ?? 0)) / span).toFixed(1);
  const y = (value: number) => (most > least ? height - (height * (value - least)) / (most - least) : height / 2);
  const bars = [...low].map((value, i) => {
    if (Number.isNaN(value)) return '';
    const top = y(high[i] ?? value);
    const next = i + 1 < times.length && !Number.isNaN(low[i + 1] ?? NaN) ? `L${x(i + 1)} ${y(low[i + 1] ?? 0).toFixed(1)}` : '';
    return `M${x(i)} ${top.toFixed(1)}V${Math.max(top + 1, y(value)).toFixed(1)}${next}`;
  });
  const [unit, factor] = plot.quantity === 'time' ? ['ns', 1e-3] : plot.quantity === 'rate' ? ['MHz', 1e-6] : [plot.unit, 1];
  const text = (value: number) => `${Number((value * factor).toPrecision(7))} ${unit}`;
  return (
    <figure>
      <figcaption>{plot.title}: {text(least)} to {text(most)}</figcaption>
      <svg viewBox={`0 0 ${width} ${height}`} preserveAspectRatio="none"><path d={bars.join('')} /></svg>
    </figure>
  );
}
