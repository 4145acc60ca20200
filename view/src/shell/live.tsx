// A line that `biss view` reads now. The server gives the record of `biss read`, which grows; the core
// decodes its new lines as words.
import { batch, signal } from '@preact/signals';
import { decodeArguments } from '../core/arguments';
import type { ServedFile } from '../core/source';
import { decoded, messageOf, objectsOf } from '../core/texts';
import { runOnFile } from '../core/verbs';
import * as state from '../state';
import { save } from './export';

type Row = Record<string, unknown>;

const keptSeconds = 10;
const pauseMilliseconds = 200;
const pointsShown = 500;

/** The port; empty if no line is read. */
export const liveName = signal('');
const last = signal<Row>({});
const counts = signal<ReadonlyMap<string, number>>(new Map());
// Times in seconds, and positions; undefined for a row without one.
const trace = signal<readonly (readonly [number, number | undefined])[]>([]);
const notice = signal('');
// The last seconds of the record.
let kept: { time: number; line: string }[] = [];

function positionOf(row: Row): unknown {
  return row['position_deg'] ?? row['position_mm'] ?? row['unwrapped'] ?? row['position'];
}

function textOf(value: unknown): string {
  return typeof value === 'number' && !Number.isInteger(value) ? value.toFixed(6) : String(value ?? '–');
}

/** Reads the record from this size on, until the page is closed. */
export async function followLine(name: string, { address, size }: ServedFile): Promise<void> {
  liveName.value = name;
  let end = size;
  let heard = performance.now();
  let hasEnded = false;
  while (!hasEnded) {
    await new Promise((resolve) => { setTimeout(resolve, pauseMilliseconds); });
    try {
      const headers = { Range: `bytes=${end}-` };
      const response = await fetch(address, { cache: 'no-store', headers });
      if (response.status !== 206 && response.status !== 416) throw new Error(await response.text());
      const bytes = new Uint8Array(await response.arrayBuffer()).subarray(0, response.status === 206 ? undefined : 0);
      end += bytes.length;
      const lines = decoded(bytes).split('\n').filter((line) => line !== '');
      const comments = lines.filter((line) => line.startsWith('# ') && !line.startsWith('# biss read'));
      hasEnded = comments.at(-1)?.startsWith('# ended') ?? false;
      const words = lines.filter((line) => !line.startsWith('#'));
      if (words.length > 0) {
        heard = performance.now();
        notice.value = '';
        await take(words);
      } else if (performance.now() - heard > 1_000) {
        notice.value ||= 'The port gives no bytes.';
      }
      if (comments.length > 0) notice.value = `The port: ${comments.at(-1)!.slice(2)}`;
    } catch (error) {
      const isGone = error instanceof TypeError;
      notice.value = isGone ? 'biss view has ended, or does not answer. The page tries again.' : messageOf(error);
    }
  }
}

async function take(lines: string[]): Promise<void> {
  const file = { name: 'live_line.log', content: new TextEncoder().encode(`${lines.join('\n')}\n`) };
  let answer;
  // The scale and the velocity if the format allows them.
  for (const args of decodeArguments([], state.settings.value)) {
    answer = await runOnFile(file, ['decode', '--words', file.name, ...args, '--to', 'jsonl']);
    if (answer.status < 2) break;
  }
  if (answer!.status >= 2) throw new Error(answer!.err);
  const rows = objectsOf<Row>(decoded(answer!.out));
  const now = Number(rows.at(-1)?.['time_ns'] ?? 0) / 1e9;
  let next = (trace.value.at(-1)?.[0] ?? 0) + keptSeconds / pointsShown;
  const points = rows.flatMap((row): [number, number | undefined][] => {
    const position = positionOf(row);
    const time = Number(row['time_ns']) / 1e9;
    if (position === null) return [[time, undefined]];
    if (time < next) return [];
    next = time + keptSeconds / pointsShown;
    return [[time, Number(position)]];
  });
  const sums = new Map(counts.value);
  rows.forEach(({ status }) => sums.set(String(status), (sums.get(String(status)) ?? 0) + 1));
  kept = [...kept, ...lines.map((line) => ({ time: now, line }))].filter(({ time }) => time > now - keptSeconds);
  batch(() => {
    last.value = rows.at(-1) ?? {};
    counts.value = sums;
    trace.value = [...trace.value, ...points].filter(([time]) => time > now - keptSeconds);
  });
}

function keep(): void {
  save('_live.log', [`# ${liveName.value}\n`, ...kept.map(({ line }) => `${line}\n`)], 'text/plain');
}

// A line that is interrupted by rows without a position.
function pathOf(points: typeof trace.value): string {
  const known = points.flatMap(([, position]) => position ?? []);
  const [least, most] = [Math.min(...known), Math.max(...known)];
  const end = points.at(-1)?.[0] ?? 0;
  return points.map(([time, position], i) => {
    if (position === undefined) return '';
    const begins = points[i - 1]?.[1] === undefined;
    const y = 95 - 90 * (most > least ? (position - least) / (most - least) : 0.5);
    return `${begins ? 'M' : 'L'}${(1000 * (1 - (end - time) / keptSeconds)).toFixed(1)} ${y.toFixed(2)}h0`;
  }).join('');
}

export function LivePanel() {
  const row = last.value;
  const facts = Object.entries(row).filter(([name, value]) => value !== null && name !== 'cycle');
  return (
    <section class="live" aria-label="Live line">
      <h2>{liveName.value}</h2>
      <p class="live-notice bad-text" role="status">{notice.value}</p>
      <p class="live-position">{textOf(positionOf(row))}</p>
      <p class={row['status'] === 'ok' ? 'good-text' : 'bad-text'}>{String(row['status'] ?? '')}</p>
      <svg viewBox="0 0 1000 100" preserveAspectRatio="none" role="img"
        aria-label={`Position in the last ${keptSeconds} seconds`}>
        <path d={pathOf(trace.value)} />
      </svg>
      <p><button type="button" onClick={keep}>Keep the last {keptSeconds} seconds</button></p>
      <table class="facts" aria-label="Rows by status">
        <tbody>{[...counts.value].map(([status, count]) => <tr key={status}><th>{status}</th><td>{count}</td></tr>)}</tbody>
      </table>
      <table class="facts" aria-label="Last row">
        <tbody>{facts.map(([name, value]) => <tr key={name}><th>{name}</th><td>{textOf(value)}</td></tr>)}</tbody>
      </table>
    </section>
  );
}
