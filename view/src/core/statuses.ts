// What the values of columns mean: their roles, and the words of `status` and `safety` as docs/status.md
// and docs/safety.md have them.
import type { Column, Role } from 'biss';

/** What was seen, for each status of a request cycle. */
export const statuses: Readonly<Record<string, string>> = {
  ok: 'ACK, START, every checksum correct, STOP 0 if it was clocked',
  no_response: 'SLO stayed high through the whole request',
  not_ready: 'SLO was low when the request began',
  response_range: 'SLO fell before the edge of MA that makes ACK, or more than 40 µs after it',
  no_start: 'ACK came, and SLO stayed low until MA stopped',
  ack_range: 'START came earlier or later than the bounds of the encoder allow',
  truncated: 'MA stopped before the last CRC bit of the format',
  cds: 'CDS was 1, and the format says that it must be 0',
  crc: 'the checksum of a channel is wrong',
  stop_bit: 'every checksum is correct, and the bit after the last one is not 0',
  cut_start: 'the capture begins inside this cycle',
  cut_end: 'the capture ends inside this cycle',
  ma_glitch: 'fewer than two rising edges of MA: a pulse and not a request',
  ma_clock: 'an edge of MA is missing, or there is one too many, inside the frame',
  unknown_level: 'MA or SLO was neither 0 nor 1 where it mattered',
  unchecked: 'START was found; the format is not known, so that nothing else can be checked',
};

/** Statuses that are no error of the link: those that `decode --only-errors` leaves out. */
export const harmlessStatuses: ReadonlySet<string> = new Set([
  'ok', 'unchecked', 'cut_start', 'cut_end',
]);

// Verdicts of the safety monitor that are no fault, but a state.
const harmlessVerdicts: ReadonlySet<string> = new Set(['safe', 'starting', 'latched', 'failed']);

/** Where a flag is bad; undefined: the column is no flag, or both are good. */
export function badAt(role: Role): '0' | '1' | undefined {
  return role.endsWith('_at_0') ? '0' : role.endsWith('_at_1') ? '1' : undefined;
}

/** How a cell is marked; empty: it is not bad. */
export function markOf(role: Role, text: string): '' | 'warn' | 'bad' {
  if (text === '' || role === 'value') return '';
  if (role === 'status') return harmlessStatuses.has(text) ? '' : 'bad';
  if (role === 'verdict') return harmlessVerdicts.has(text) ? '' : 'bad';
  if (role !== 'warnings' && text !== badAt(role)) return '';
  return role.startsWith('warning') ? 'warn' : 'bad';
}

/** What a cell counts for: `crc`, `nE=0`, `clock_max`. */
export function causesIn({ name, kind, role }: Column, text: string): string[] {
  if (kind !== 'flag') return text.split(';').filter((one) => one !== '');
  if (markOf(role, text) === '') return [];
  return [text === '0' ? `${name}=0` : name];
}
