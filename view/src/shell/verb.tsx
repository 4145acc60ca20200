// The result of a verb in a panel: run when the panel is shown, once for a capture and settings.
import type { ComponentChildren } from 'preact';
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { captureArguments, verbFurther } from '../core/arguments';
import { core } from '../core/core';
import { fileNames } from '../core/reading';
import { decoded, objectsOf } from '../core/texts';
import { runVerb } from '../core/verbs';
import { zoomToRow } from '../selection';
import * as state from '../state';

export interface VerbResult {
  state: 'running' | 'done' | 'failed';
  /** Rows of the verb, from --to jsonl. */
  rows: Record<string, unknown>[];
  /** Text that the command writes to stderr. */
  words: string;
}

const notYet: VerbResult = { state: 'running', rows: [], words: '' };
const results = signal<ReadonlyMap<string, VerbResult>>(new Map());

// Results of an earlier reading are dropped.
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

/** Arguments of `identify`, without the chosen format: the findings do not depend on it. */
export function identifyArguments(): string[] {
  const args = verbArguments(['identify'], ['--to', 'jsonl']);
  const at = args.indexOf('-f');
  return at < 0 ? args : [...args.slice(0, at), ...args.slice(at + 2)];
}

/** Has a verb run, unless its result is there. */
export function useVerb(args: string[]): VerbResult {
  const key = `${state.generation.value} ${JSON.stringify(args)}`;
  const ready = state.progress.value.state === 'ended';
  useEffect(() => {
    if (ready && !results.value.has(key)) void run(key, args);
  }, [key, ready]);
  return results.value.get(key) ?? notYet;
}

async function run(key: string, args: string[]): Promise<void> {
  put(key, notYet);
  try {
    const { status, out, err } = wholeAnswer(args) ?? await answerOf(args);
    put(key, { state: status >= 2 ? 'failed' : 'done', rows: objectsOf(out), words: err });
  } catch (error) {
    put(key, { state: 'failed', rows: [], words: String(error) });
  }
}

// In a report: the output of the verb for the whole capture, by its name: `explain`, `check renishaw`.
function wholeAnswer(args: string[]) {
  const [verb = ''] = args;
  const limits = args[args.indexOf('--against') + 1];
  return state.isWhole.value ? state.report.value?.verbs[verb === 'check' ? `${verb} ${limits}` : verb] : undefined;
}

async function answerOf(args: string[]) {
  const result = await runVerb(args);
  return { ...result, out: decoded(result.out) };
}

/** Shows a cycle by its number. A report does not have each, and options may leave some out. */
export async function zoomToCycle(number: number): Promise<void> {
  const row = await core().ask('rowOfCycle', { number });
  if (row !== undefined) await zoomToRow(row);
  else state.announcement.value = state.messages.value = `Cycle ${number} is not in this ${state.report.value === undefined ? 'table' : 'report'}.`;
}

/** The number of a cycle, as a button that goes to the cycle. */
export function CycleLink({ cycle }: { cycle: unknown }) {
  if (typeof cycle !== 'number') return <>–</>;
  return <button type="button" class="link" onClick={() => void zoomToCycle(cycle)}>{cycle}</button>;
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
