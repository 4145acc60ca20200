/** Accesses to registers, which go by a bit of CDM and of CDS in each cycle. */
import type { Access } from 'biss';
import { firstWhere } from '../core/first_where';
import type { Rows } from '../plots/row_classes';

function words(...parts: unknown[]): string {
  return parts.filter((part) => part !== null && part !== undefined && part !== '').join(' ');
}

/** `read 0x42 BP_ID = 17 of 0: ok`. */
export function accessText({ id, access, address, name, data, outcome }: Access): string {
  const value = words(data) === '' ? '' : `= ${words(data)}`;
  return words(access, address, name, value, id === null ? ':' : `of ${id}:`, outcome).replace(' :', ':');
}

/** The place of an access among these rows. */
export interface Extent {
  from: bigint;
  to: bigint;
  /** Its first row here. */
  row: number;
}

/** Undefined if none of its cycles is in these rows. */
export function extentIn(rows: Rows, { cycle, cycles }: Access): Extent | undefined {
  const rowFrom = (number: number) => firstWhere(rows.numbers.length, (i) => (rows.numbers[i] ?? 0) >= number);
  const first = rowFrom(cycle);
  const end = rowFrom(cycle + Math.max(1, cycles));
  const from = rows.times[first];
  if (end <= first || from === undefined) return undefined;
  return { from, to: rows.ends[end - 1] ?? rows.end, row: rows.first + first };
}
