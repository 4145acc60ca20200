// The playground: an encoder, a cable and a master to play with. Each change is simulated and read at
// once, so that the page shows what it does to the line.
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import * as state from '../state';
import { encoders } from './encoders';
import { openSimulated } from './examples';

interface Fault {
  kind: string;
  rate: string;
}

interface Setup {
  format: string;
  clock: string;
  cable: string;
  compensation: boolean;
  jitter: string;
  motion: string;
  cycles: string;
  seed: string;
  faults: Fault[];
}

const isOpen = signal(false);
const setup = signal<Setup>({
  format: 'resolute-26',
  clock: '5MHz',
  cable: '20m',
  compensation: true,
  jitter: '2ns',
  motion: 'sine',
  cycles: '300',
  seed: '1',
  faults: [],
});

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

/** The arguments of `biss simulate` for a setup. */
function argumentsOf(wanted: Setup): string {
  const words = ['-f', wanted.format, '--clock', wanted.clock, '--cable', wanted.cable,
    '--motion', wanted.motion, '--cycles', wanted.cycles, '--seed', wanted.seed];
  if (wanted.jitter !== '' && wanted.jitter !== '0') words.push('--jitter', wanted.jitter);
  if (!wanted.compensation) words.push('--no-compensation');
  for (const { kind, rate } of wanted.faults) words.push('--fault', `${kind}:${rate}`);
  return words.map((word) => (/[\s']/.test(word) ? `"${word}"` : word)).join(' ');
}

let timer: ReturnType<typeof setTimeout> | undefined;

function run(): void {
  clearTimeout(timer);
  timer = setTimeout(() => {
    const wanted = setup.value;
    void openSimulated(argumentsOf(wanted), wanted.format);
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
    <aside class="simulate" aria-label="Simulation">
      <div class="bar">
        <h2>Simulate</h2>
        <span class="grow" />
        <button type="button" class="small" onClick={() => { isOpen.value = false; }}>Close</button>
      </div>
      <form onSubmit={(event) => { event.preventDefault(); run(); }}>
        <Text id="simulate-format" name="Encoder or format" list="encoders-to-simulate" value={now.format} set={(format) => change({ format })} />
        <datalist id="encoders-to-simulate">{encoders.value.map((name) => <option key={name} value={name} />)}</datalist>
        <Text name="Clock" value={now.clock} set={(clock) => change({ clock })} />
        <Text name="Cable" value={now.cable} set={(cable) => change({ cable })} />
        <label class="tick">
          <input type="checkbox" checked={now.compensation} onChange={(event) => change({ compensation: event.currentTarget.checked })} />
          {' '}The master compensates the line delay
        </label>
        <Text name="Jitter (peak)" value={now.jitter} set={(jitter) => change({ jitter })} />
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
      {state.progress.value.state === 'failed' && <p class="bad-text">The simulation was refused; the message is above.</p>}
    </aside>
  );
}

interface TextProps {
  id?: string;
  name: string;
  value: string;
  list?: string;
  set: (value: string) => void;
}

function Text({ id, name, value, list, set }: TextProps) {
  return (
    <label>{name}
      <input id={id} type="text" value={value} list={list} spellcheck={false} autocomplete="off"
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
