// The result line of the playground: how many cycles fail, and a link to the first one.
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { Superseded } from '../core/client';
import { core } from '../core/core';
import { zoomToRow } from '../selection';
import * as state from '../state';

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

export function SimulationResult() {
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
