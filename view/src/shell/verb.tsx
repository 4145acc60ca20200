// The result of a verb in a panel: run when the panel is shown, once for a capture and settings.
import type { ComponentChildren } from 'preact';
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { captureArguments, verbFurther } from '../core/arguments';
import { core } from '../core/core';
import { fileNames } from '../core/reading';
import { runVerb } from '../core/verbs';
import { announce } from './announce';
import { zoomToRow } from '../selection';
import * as state from '../state';

export interface VerbResult {
  state: 'running' | 'done' | 'failed';
  /** Rows of the verb, from --to jsonl. */
  rows: Record<string, unknown>[];
  /** What the command writes to stderr. */
  words: string;
}

const results = signal<ReadonlyMap<string, VerbResult>>(new Map());

// Those of an earlier reading are dropped.
function put(key: string, result: VerbResult): void {
  const reading = `${state.generation.value} `;
  const kept = [...results.value].filter(([old]) => old.startsWith(reading));
  results.value = new Map([...kept, [key, result]]);
}

/** Arguments for a verb on the capture that is open. */
export function verbArguments(verb: string[], further: string[] = []): string[] {
  const settings = state.settings.value;
  return [...verb, ...fileNames(), ...captureArguments(settings), ...verbFurther(verb[0]!, settings), ...further];
}

/** Of `identify`: what is found out does not depend on the format that is chosen. */
export function identifyArguments(): string[] {
  const args = verbArguments(['identify'], ['--to', 'jsonl']);
  const at = args.indexOf('-f');
  return at < 0 ? args : [...args.slice(0, at), ...args.slice(at + 2)];
}

/** Has a verb run, unless its result is there, or it is not `wanted` yet. */
export function useVerb(args: string[], wanted = true): VerbResult {
  const key = `${state.generation.value} ${JSON.stringify(args)}`;
  const ready = wanted && state.progress.value.state === 'ended';
  useEffect(() => {
    if (ready && !results.value.has(key)) void run(key, args);
  }, [key, ready]);
  return results.value.get(key) ?? { state: 'running', rows: [], words: '' };
}

async function run(key: string, args: string[]): Promise<void> {
  put(key, { state: 'running', rows: [], words: '' });
  try {
    const { status, text, err } = wholeAnswer(args) ?? await answerOf(args);
    const rows = text.split('\n').filter((line) => line !== '').map((line) => JSON.parse(line));
    put(key, { state: status >= 2 ? 'failed' : 'done', rows, words: err });
  } catch (error) {
    put(key, { state: 'failed', rows: [], words: String(error) });
  }
}

// Of a report: what the verb says of the whole capture.
function wholeAnswer(args: string[]) {
  const answer = state.isWhole.value ? state.report.value?.verbs[nameOf(args)] : undefined;
  return answer && { status: answer.status, text: answer.out, err: answer.err };
}

// As a report names it: `explain`, `check renishaw`.
function nameOf(args: string[]): string {
  const limits = args[args.indexOf('--against') + 1];
  return args[0] === 'check' && limits !== undefined ? `check ${limits}` : args[0] ?? '';
}

async function answerOf(args: string[]) {
  const { status, out, err } = await runVerb(args);
  return { status, text: new TextDecoder().decode(out), err };
}

/** Shows a cycle by its number. A report does not have each, and options may leave some out. */
export async function zoomToCycle(number: number): Promise<void> {
  const row = await core().ask('rowOfCycle', { number });
  if (row !== undefined) await zoomToRow(row);
  else announce(state.messages.value = `Cycle ${number} is not in this ${state.report.value === undefined ? 'table' : 'report'}.`);
}

/** Where a cycle is named: a button that goes to it. */
export function CycleLink({ cycle, go }: { cycle: unknown; go: (row: number) => void }) {
  if (typeof cycle !== 'number') return <>–</>;
  return <button type="button" class="link" onClick={() => go(cycle)}>{cycle}</button>;
}

/** The frame of a panel with a verb: running, failed, or its content and the command's words. */
export function VerbView({ result, children }: { result: VerbResult; children: ComponentChildren }) {
  if (result.state === 'running') {
    const reading = state.progress.value.state !== 'ended';
    return <p class="quiet">{reading ? 'The capture is being read …' : 'Running …'}</p>;
  }
  if (result.state === 'failed') return <pre class="words failed-words">{result.words}</pre>;
  return (
    <>
      {children}
      {result.words !== '' && (
        <details class="command-words">
          <summary>Summary of the command</summary>
          <pre class="words" tabIndex={0}>{result.words}</pre>
        </details>
      )}
    </>
  );
}

/** A value of a row as text. */
export function textOf(value: unknown): string {
  return value === null || value === undefined || value === '' ? '–' : String(value);
}
