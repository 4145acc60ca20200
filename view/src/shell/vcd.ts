// MA and SLO of a stretch of time as VCD, every edge of them.
import type { LineView } from 'biss';
import { core } from '../core/core';
import * as state from '../state';

// No file has more changes; who wants more converts the capture with the command.
const mostChanges = 4_000_000;
// Columns of a view in which edges are looked for, and how finely a stretch may be divided.
const columns = 100_000;
const busy = 3;

interface Change {
  time: bigint;
  level: number;
}

const lines = [['ma', '!'], ['slo', '"']] as const;

export async function vcdOf({ from, to }: state.Range): Promise<string[]> {
  const about = state.about.value;
  const parts = [
    `$timescale 1 ps $end\n$scope module capture $end\n`,
    `$var wire 1 ! ${nameOf(about?.ma, 'MA')} $end\n$var wire 1 " ${nameOf(about?.slo, 'SLO')} $end\n`,
    `$upscope $end\n$enddefinitions $end\n`,
  ];
  const both = await Promise.all(lines.map(async ([line, sign]) =>
    (await changesOf(line, from, to)).map((change) => ({ ...change, sign }))));
  const all = both.flat().sort((a, b) => (a.time < b.time ? -1 : a.time > b.time ? 1 : 0));
  let last: bigint | undefined;
  for (const { time, level, sign } of all) {
    if (time !== last) parts.push(`#${time}\n`);
    parts.push(`${level > 1 ? 'x' : level}${sign}\n`);
    last = time;
  }
  parts.push(`#${to}\n`);
  return parts;
}

function nameOf(name: string | undefined, usual: string): string {
  return (name === undefined || name === '' ? usual : name).replace(/\s/g, '_');
}

// Divides a stretch until each of its edges has a column to itself.
async function changesOf(line: 'ma' | 'slo', from: bigint, to: bigint): Promise<Change[]> {
  const changes: Change[] = [];
  const waiting: state.Range[] = [{ from: from < 0n ? 0n : from, to }];
  for (let range = waiting.pop(); range !== undefined; range = waiting.pop()) {
    const length = range.to - range.from;
    const fine = Number(length < BigInt(columns) ? length : BigInt(columns));
    const view = await core().ask('view', { line, ...range, columns: Math.max(1, fine) });
    if (view.levels.includes(busy) && length > BigInt(columns)) {
      const middle = range.from + length / 2n;
      waiting.push({ from: middle, to: range.to }, { from: range.from, to: middle });
    } else {
      append(changes, view);
    }
    if (changes.length > mostChanges) {
      throw new Error('The waveform shows too many edges for a file: zoom in, or use biss convert.');
    }
  }
  return changes;
}

function append(changes: Change[], { times, levels }: LineView): void {
  times.forEach((time, i) => {
    const level = levels[i] ?? 2;
    if (changes.at(-1)?.level !== level) changes.push({ time, level });
  });
}
