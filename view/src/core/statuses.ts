// The meaning of the values of columns: their roles, and the words of the core for `status` and `safety`.
import type { Column, Role, Words } from 'biss';

// From the core, when the page is built: view/core.mjs.
declare const WORDS: Words;

/** The observation for each status of a request cycle. */
export const statuses: Readonly<Record<string, string>> =
  Object.fromEntries(WORDS.statuses.map(({ name, seen }) => [name, seen]));

/** Statuses that are not an error of the link: those that `decode --only-errors` leaves out. */
export const harmlessStatuses = namesOf(WORDS.statuses.filter(({ fault }) => !fault));

export const cutStatuses = namesOf(WORDS.statuses.filter(({ cut }) => cut));

/** Verdicts of the safety monitor. */
export const verdicts = namesOf(WORDS.verdicts);

const harmlessVerdicts = namesOf(WORDS.verdicts.filter(({ fault }) => !fault));

function namesOf(words: readonly { name: string }[]): ReadonlySet<string> {
  return new Set(words.map(({ name }) => name));
}

/** The bad value of a flag; undefined: the column is not a flag, or both values are good. */
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

/** The causes that a cell counts for: `crc`, `nE=0`, `clock_max`. */
export function causesIn({ name, kind, role }: Column, text: string): string[] {
  if (kind !== 'flag') return text.split(';').filter((one) => one !== '');
  if (markOf(role, text) === '') return [];
  return [text === '0' ? `${name}=0` : name];
}
