/** Accesses to registers, which go by a bit of CDM and of CDS in each cycle. */
import { signal } from '@preact/signals';
import type { Rows } from '../plots/row_classes';

/** A row of `biss registers`. */
export interface Access {
  /** The cycle in which it begins, and how many it takes. */
  cycle: number;
  cycles: number;
  text: string;
  isBad: boolean;
}

/** Those of the capture, where they have been read. */
export const accesses = signal<readonly Access[]>([]);

function words(...parts: unknown[]): string {
  return parts.filter((part) => part !== null && part !== undefined && part !== '').join(' ');
}

export function accessesOf(rows: readonly Record<string, unknown>[]): Access[] {
  return rows.flatMap((row) => {
    const { cycle, cycles, id, access, address, name, data, outcome } = row;
    if (typeof cycle !== 'number' || typeof cycles !== 'number') return [];
    const value = words(data) === '' ? '' : `= ${words(data)}`;
    const text = words(access, address, name, value, `of ${words(id)}:`, outcome);
    return [{ cycle, cycles, text, isBad: outcome !== 'ok' }];
  });
}

/** When an access is seen among these rows; undefined where it is not. */
export function extentIn(rows: Rows, { cycle, cycles }: Access): { from: bigint; to: bigint } | undefined {
  const first = cycle - rows.first;
  const end = first + Math.max(1, cycles);
  const from = rows.times[Math.max(0, first)];
  if (end <= 0 || from === undefined) return undefined;
  return { from, to: rows.times[end] ?? rows.end };
}
