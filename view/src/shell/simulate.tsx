// The playground: an encoder, a cable and a master to play with. Each change is simulated and read at
// once, so that the page shows what it does to the line.
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { splitArguments } from '../core/arguments';
import { Superseded } from '../core/client';
import { core } from '../core/core';
import { zoomToRow } from '../selection';
import * as state from '../state';
import { encoders } from './encoders';
import { examples, openSimulated } from './examples';
import type { Action } from './menu';
import { presets, usualSetup, type Fault, type Setup } from './presets';

const isOpen = signal(false);
const setup = signal<Setup>(usualSetup);
const preset = signal('good');

const motions = ['constant', 'ramp', 'sine', 'random', 'max'];

// Those that a setup with one encoder and without registers can have; docs/faults.md explains them.
const faultKinds = [
  'flip', 'burst', 'glitch_ma', 'glitch_ma_idle', 'glitch_slo', 'glitch_slo_idle', 'lost_clock',
  'double_clock', 'extra_clock', 'ma_low', 'ma_high', 'slo_low', 'slo_high', 'late_start', 'no_answer',
  'cut', 'swap_ma', 'swap_slo', 'delay_step', 'nE', 'nW', 'brown_out', 'frozen', 'repeat', 'reorder',
  'loss', 'delay', 'insert',
];

export function showSimulate(): void {
  isOpen.value = true;
  run();
}

/** Everything that the page can simulate. */
export const exampleActions: readonly Action[] = [
  ...examples.map(({ name, about, args, format }) => ({ name, about, run: () => void openSimulated(args, format) })),
  { name: 'Simulate …', about: 'an encoder, a cable and a master of your own, with faults', run: showSimulate },
];

/** Opens the playground with a preset, or as it was last. */
export function play(id: string): void {
  if (presets.some((each) => each.id === id)) choosePreset(id);
  showSimulate();
}

function choosePreset(id: string): void {
  preset.value = id;
  change({ ...usualSetup, ...presets.find((each) => each.id === id)?.setup });
}

/** The arguments of `biss simulate` for a setup. */
function argumentsOf(wanted: Setup): string {
  const words = ['-f', wanted.format, '--clock', wanted.clock, '--cable', wanted.cable,
    '--motion', wanted.motion, '--cycles', wanted.cycles, '--seed', wanted.seed];
  if (wanted.jitter !== '' && wanted.jitter !== '0') words.push('--jitter', wanted.jitter);
  if (wanted.timeout !== '') words.push('--timeout', wanted.timeout);
  if (!wanted.compensation) words.push('--no-compensation');
  for (const { kind, rate } of wanted.faults) words.push('--fault', `${kind}:${rate}`);
  return words.map((word) => (/[\s']/.test(word) ? `"${word}"` : word)).join(' ');
}

let timer: ReturnType<typeof setTimeout> | undefined;

function run(): void {
  clearTimeout(timer);
  timer = setTimeout(() => {
    const wanted = setup.value;
    // The master that reads is the one that is simulated.
    const others = splitArguments(state.settings.value.further).filter((word) => word !== '--no-compensation');
    const further = [...others, ...(wanted.compensation ? [] : ['--no-compensation'])];
    state.settings.value = { ...state.settings.value, further: further.join(' ') };
    void openSimulated(argumentsOf(wanted), wanted.readAs || wanted.format);
  }, 200);
}

function change(part: Partial<Setup>): void {
  setup.value = { ...setup.value, ...part };
  run();
}

export function SimulatePanel() {
  const open = isOpen.value;
  useEffect(() => {
    if (open) document.getElementById('simulate-format')?.focus();
  }, [open]);
  if (!open) return null;
  const now = setup.value;
  return (
    <aside class="simulate" aria-label="Playground">
      <div class="bar">
        <h2>Playground</h2>
        <span class="grow" />
        <button type="button" class="small" onClick={() => { isOpen.value = false; }}>Close</button>
      </div>
      <label class="preset">Begin with
        <select id="preset" value={preset.value} onChange={(event) => choosePreset(event.currentTarget.value)}>
          {presets.map(({ id, name }) => <option key={id} value={id}>{name}</option>)}
        </select>
      </label>
      <p class="quiet">{presets.find(({ id }) => id === preset.value)?.about}</p>
      <SimulationResult />
      <form onSubmit={(event) => { event.preventDefault(); run(); }}>
        <Text id="simulate-format" name="Encoder or format" list="encoders-to-simulate" value={now.format} set={(format) => change({ format })} />
        <Text name="Read as" list="encoders-to-simulate" value={now.readAs} placeholder="the same" set={(readAs) => change({ readAs })} />
        <datalist id="encoders-to-simulate">{encoders.value.map((name) => <option key={name} value={name} />)}</datalist>
        <Text name="Clock" value={now.clock} set={(clock) => change({ clock })} />
        <Text name="Cable" value={now.cable} set={(cable) => change({ cable })} />
        <label class="tick">
          <input type="checkbox" checked={now.compensation} onChange={(event) => change({ compensation: event.currentTarget.checked })} />
          {' '}The master compensates the line delay
        </label>
        <Text name="Jitter (peak)" value={now.jitter} set={(jitter) => change({ jitter })} />
        <Text name="Timeout" value={now.timeout} placeholder="of the encoder" set={(timeout) => change({ timeout })} />
        <label>Motion
          <select value={now.motion} onChange={(event) => change({ motion: event.currentTarget.value })}>
            {motions.map((motion) => <option key={motion}>{motion}</option>)}
          </select>
        </label>
        <Text name="Request cycles" value={now.cycles} set={(cycles) => change({ cycles })} />
        <Text name="Random seed" value={now.seed} set={(seed) => change({ seed })} />
        <Faults faults={now.faults} />
      </form>
      <p class="quiet command">biss simulate {argumentsOf(now)} -o line.vcd</p>
    </aside>
  );
}

interface TextProps {
  id?: string;
  name: string;
  value: string;
  list?: string;
  placeholder?: string;
  set: (value: string) => void;
}

function Text({ id, name, value, list, placeholder, set }: TextProps) {
  return (
    <label>{name}
      <input id={id} type="text" value={value} list={list} placeholder={placeholder} spellcheck={false} autocomplete="off"
        onChange={(event) => set(event.currentTarget.value.trim())} />
    </label>
  );
}

function Faults({ faults }: { faults: readonly Fault[] }) {
  const put = (at: number, fault: Fault | undefined) => {
    change({ faults: faults.flatMap((old, i) => (i !== at ? [old] : fault === undefined ? [] : [fault])) });
  };
  return (
    <fieldset>
      <legend>Faults</legend>
      {faults.map((fault, i) => (
        <div key={i} class="fault">
          <select aria-label={`Kind of fault ${i + 1}`} value={fault.kind} onChange={(event) => put(i, { ...fault, kind: event.currentTarget.value })}>
            {faultKinds.map((kind) => <option key={kind}>{kind}</option>)}
          </select>
          <input type="text" aria-label={`Share of cycles with fault ${i + 1}`} value={fault.rate} size={5}
            onChange={(event) => put(i, { ...fault, rate: event.currentTarget.value.trim() })} />
          <button type="button" class="small" aria-label={`Remove fault ${i + 1}`} onClick={() => put(i, undefined)}>✕</button>
        </div>
      ))}
      <button type="button" class="small" onClick={() => change({ faults: [...faults, { kind: 'flip', rate: '0.05' }] })}>Add a fault</button>
    </fieldset>
  );
}

// The result line: how many cycles fail, and a link to the first one.
interface Result {
  of: number;
  failed: number;
  marginal: number;
  first: number | undefined;
  status: string;
}

const result = signal<Result | undefined>(undefined);
const most = 1_000_000;
const lane = 'playground';

async function judge(): Promise<void> {
  const rowsWith = (condition: string) => core().ask('findAll', { condition, most });
  const own = state.generation.value;
  try {
    const failed = await rowsWith('error');
    const marginal = await rowsWith('marginal');
    const first = failed[0] ?? marginal[0];
    const cells = first === undefined ? [] : await core().ask('cells', { from: first, to: first + 1 }, { lane });
    if (own !== state.generation.value) return;
    const column = state.columns.value.findIndex(({ name }) => name === 'status');
    result.value = {
      of: state.rowCount.value, failed: failed.length, marginal: marginal.length, first,
      status: failed.length > 0 ? cells[0]?.[column] ?? '' : 'marginal',
    };
    if (first !== undefined) await zoomToRow(first);
  } catch (error) {
    if (!(error instanceof Superseded)) result.value = undefined;
  }
}

function SimulationResult() {
  const generation = state.generation.value;
  const { state: reading } = state.progress.value;
  const isSimulated = state.file.value?.example !== undefined;
  useEffect(() => {
    if (reading === 'ended' && isSimulated) void judge();
  }, [generation, reading, isSimulated]);
  if (reading === 'failed') return <p class="outcome bad-text">The simulation was refused; the message is above.</p>;
  const now = result.value;
  if (now === undefined || !isSimulated || reading !== 'ended') return <p class="outcome quiet">Simulating …</p>;
  const { of, failed, marginal, first, status } = now;
  if (first === undefined) return <p class="outcome good-text">All {of} cycles are right.</p>;
  return (
    <p class="outcome bad-text">
      {failed > 0 ? `${failed} of ${of} cycles fail.` : `${marginal} of ${of} cycles are sampled too close to a change of SLO.`}
      {' '}<button type="button" class="small" onClick={() => void zoomToRow(first)}>Show cycle {first}: {status}</button>
    </p>
  );
}
