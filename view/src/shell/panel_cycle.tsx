// The cycle that is selected, bit by bit: what `biss explain --cycle` prints, its fields and checks.
import type { CycleBit, CycleCheck } from 'biss';
import { harmlessStatuses, statuses } from '../core/statuses';
import * as state from '../state';
import { useAnswer } from './use_answer';

export function CyclePanel() {
  const row = state.selectedRow.value;
  const isKnown = row !== undefined && row < state.rowCount.value;
  const found = useAnswer('cycle', isKnown ? { row } : undefined, [row, state.generation.value]);
  if (row === undefined) return <p class="quiet">Select a row of the table, or a cycle of the waveform.</p>;
  if (found === undefined) return <p class="quiet">Row {row} has not been read yet.</p>;
  const cycle = found.answer;
  if (cycle === undefined) return <p class="quiet">The edges of row {row} do not show it alone.</p>;
  const harmless = harmlessStatuses.has(cycle.status);
  return (
    <>
      <h3 class="cycle-title">{cycle.title}</h3>
      <p class={harmless ? 'verdict' : 'verdict bad-text'}>
        <strong>{harmless ? '✓' : '✗'} {cycle.status}</strong>: {statuses[cycle.status] ?? ''}
      </p>
      {cycle.checks.map((check) => <Check key={check.channel} check={check} bits={cycle.bits} />)}
      <Fields bits={cycle.bits} />
      <pre class="words drawing" tabIndex={0} aria-label="Drawing of the cycle">{cycle.text}</pre>
    </>
  );
}

function hex(value: number | bigint): string {
  return `0x${value.toString(16).toUpperCase()}`;
}

function Check({ check, bits }: { check: CycleCheck; bits: CycleBit[] }) {
  const nameOf = (payloadBit: number) =>
    bits.find((bit) => bit.payloadBit === payloadBit)?.name ?? `bit ${payloadBit}`;
  const single = check.singles.map((list) => list.map(nameOf).join(' and '));
  return (
    <p class={check.right ? 'verdict good-text' : 'verdict bad-text'}>
      CRC{check.channel > 0 ? ` ${check.channel + 1}` : ''}: received {hex(check.received)}, expected {hex(check.expected)}
      {check.right ? ': right' : ': wrong'}
      {!check.right && single.length > 0 && `; right if one bit were different: ${single.join(', ')}`}
    </p>
  );
}

// pos25, pos24, … are one field; the number of a channel follows a point.
function fieldsOf(bits: readonly CycleBit[]) {
  const fields: { name: string; bits: string }[] = [];
  for (const bit of bits) {
    if (bit.payloadBit === undefined) continue;
    const name = bit.name.replace(/\d+(\.\d+)?$/, '$1');
    const level = bit.level === undefined ? '?' : String(bit.level);
    const last = fields.at(-1);
    if (last?.name === name) last.bits += level;
    else fields.push({ name, bits: level });
  }
  return fields;
}

// The number that bits make; undefined if one was not received.
function valueOf(bits: string): bigint | undefined {
  return /^[01]+$/.test(bits) ? BigInt(`0b${bits}`) : undefined;
}

function Fields({ bits }: { bits: readonly CycleBit[] }) {
  const fields = fieldsOf(bits);
  if (fields.length === 0) return null;
  return (
    <table class="facts">
      <caption class="sr">Fields as received</caption>
      <thead><tr><th>field</th><th class="number">received</th><th class="number">hex</th><th>bits</th></tr></thead>
      <tbody>
        {fields.map(({ name, bits: received }, i) => {
          const value = valueOf(received);
          return (
            <tr key={i}>
              <th scope="row">{name}</th>
              <td class="number">{value?.toString() ?? '–'}</td>
              <td class="number">{value === undefined || received.length === 1 ? '' : hex(value)}</td>
              <td class="mono bits">{received}</td>
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}
