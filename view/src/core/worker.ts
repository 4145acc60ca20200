// The worker: holds the core, reads the capture in slices, and answers between them.
import { BissError, loadBiss } from 'biss';
import type { Biss, Session } from 'biss';
import { causes } from '../plots/causes_of';
import { envelope, type EnvelopeAsk } from '../plots/envelope';
import { eye } from '../plots/eye_of';
import { rows, strip } from '../plots/row_classes';
import { findRow, findRows } from './matching';
import { Reader } from './reader';
import { PartSession, wholeCauses, wholeEnvelope, type Report } from './report';
import { numbersOf, rowFrom } from '../plots/row_times';
import type { Range } from '../state';
import { measuredSource, type Content, type MeasuredSource } from './source';
import { messageOf } from './texts';
import { unpack } from './unpack';
import type { AnswerMessage, Opened, RequestMessage } from './protocol';

declare const self: DedicatedWorkerGlobalScope;

let biss: Biss | undefined;
let reader: Reader | undefined;
let report: Report | undefined;
// The reader that will replace `reader`.
let behind: Reader | undefined;
let generation = 0;
const sources = new Map<string, MeasuredSource>();

function loaded(): Biss {
  if (biss === undefined) throw new Error('the core is not loaded');
  return biss;
}

/** Rows from `from` to before `to`. */
interface Stretch {
  from: number;
  to: number;
}

interface Opening {
  args: string[];
  anyLines: boolean;
  /** The settings are the same as in the report. */
  isWhole: boolean;
}

// All requests of the page. Requests about the open capture fail if none is open.
const handlers = {
  /** biss_core.wasm in base64 of gzip. */
  async load({ core }: { core: string }) {
    biss = await loadBiss({ wasmBinary: await unpack(core) });
  },
  addFile({ name, content }: { name: string; content: Content }) {
    const source = measuredSource(content);
    loaded().addFile(name, source);
    sources.set(name, source);
  },
  removeFile({ name }: { name: string }) {
    loaded().removeFile(name);
    sources.delete(name);
  },
  readFile: ({ name }: { name: string }) => loaded().readFile(name),
  run: ({ args }: { args: string[] }) => loaded().run(args),
  /** The capture is a part of the capture of the report. */
  report({ report: given }: { report: Report | undefined }) {
    report = given;
  },
  open(ask: Opening): Opened {
    const { session, messages } = openSession(ask);
    closeAll();
    generation += 1;
    reader = new Reader(session, generation, sourcesOf(ask.args), (message) => self.postMessage(message));
    return { generation, columns: session.columns, messages };
  },
  /**
   * Opens a capture that continues the open one, and reads it to its end. Then it replaces the open one, and
   * the answer comes. The answer is undefined if another capture has been opened meanwhile.
   */
  async openBehind(ask: Opening): Promise<Opened | undefined> {
    const { session, messages } = openSession(ask);
    behind?.close();
    generation += 1;
    const opened = { generation, columns: session.columns, messages };
    const own = new Reader(session, generation, sourcesOf(ask.args));
    behind = own;
    const reading = await own.ended;
    if (reading === undefined) return undefined;
    reader?.close();
    reader = own;
    behind = undefined;
    return { ...opened, reading };
  },
  endBehind,
  close() {
    closeAll();
    reader = undefined;
  },
  /** A stretch of a line; its times count from `from`. */
  view({ line, from, to, columns }: Range & { line: 'ma' | 'slo'; columns: number }) {
    const { times, levels } = session().view(line, from, to, columns);
    return { from, times: numbersOf(times, from), levels };
  },
  /** The first change of a line, which can be before 0. */
  beginTime() {
    const end = BigInt(session().about().endTime) + 1n;
    const times = (['ma', 'slo'] as const).flatMap((line) => session().view(line, -(1n << 62n), end, 1).times[0] ?? []);
    return times.reduce((least, time) => (time < least ? time : least), times[0] ?? 0n);
  },
  cells: ({ from, to }: Stretch) => session().cells(from, to),
  /** The cells of rows that need not follow one another. */
  cellsOf: ({ rows }: { rows: readonly number[] }) => rows.flatMap((row) => session().cells(row, row + 1)),
  csv: ({ from, to }: Stretch) => session().csv(from, to),
  column: ({ name, from, to }: Stretch & { name: string }) => session().column(name, from, to),
  cycle: ({ row }: { row: number }) => session().cycle(row),
  summary: () => session().summary(),
  /** The next row from `from` on (exclusive) for which the condition is true; see condition.ts. */
  find: ({ condition, from, step }: { condition: string; from: number; step: 1 | -1 }) =>
    findRow(session(), condition, from, step),
  /** The rows for which the condition is true, at most `most`. */
  findAll: ({ condition, most }: { condition: string; most: number }) => findRows(session(), condition, most),
  /** The last row that begins at or before this time; undefined before the first one. */
  rowAt({ time }: { time: bigint }) {
    const after = rowFrom(session(), time + 1n);
    return after === 0 ? undefined : after - 1;
  },
  /** The row of a cycle, by its number; undefined if the cycle has no row. */
  rowOfCycle({ number }: { number: number }) {
    const row = rowFrom(session(), BigInt(number), 'cycle');
    return Number(session().column('cycle', row, row + 1).values[0]) === number ? row : undefined;
  },
  // The computations for the plots and the waveform: rows go in by column, envelopes and counts come out, so no
  // answer grows with the capture.
  'analyse.envelope': async (ask: EnvelopeAsk) => {
    const whole = wholeReport();
    return whole && wholeEnvelope(whole, ask) || analysed(envelope, ask);
  },
  'analyse.strip': (ask: Parameters<typeof strip>[1]) => analysed(strip, ask),
  'analyse.rows': (ask: Parameters<typeof rows>[1]) => analysed(rows, ask),
  'analyse.causes': async (ask: Parameters<typeof causes>[1]) => {
    const whole = wholeReport();
    return whole ? wholeCauses(whole) : analysed(causes, ask);
  },
  'analyse.eye': (ask: Parameters<typeof eye>[1]) => analysed(eye, ask),
};
export type Handlers = typeof handlers;

function analysed<Ask, Answer>(analysis: (of: Session, ask: Ask) => Answer, ask: Ask): Promise<Answer> {
  return opened().analysed((of) => analysis(of, ask));
}

// The report, if it has the data about the whole capture as it is read.
function wholeReport(): Report | undefined {
  const part = reader?.session;
  return part instanceof PartSession && part.isWhole ? part.report : undefined;
}

function sourcesOf(args: readonly string[]): MeasuredSource[] {
  return args.flatMap((name) => sources.get(name) ?? []);
}

// If the page has a report, the session also has its data about the whole capture.
function openSession({ args, anyLines, isWhole }: Opening) {
  const { session, messages } = loaded().open(args, { anyLines });
  return { session: report === undefined ? session : new PartSession(session, report, isWhole), messages };
}

function endBehind(): void {
  behind?.close();
  behind = undefined;
}

function closeAll(): void {
  endBehind();
  reader?.close();
}

// The capture of a request was closed before the request came.
class Closed extends Error {}

function opened(): Reader {
  if (reader !== undefined) return reader;
  const message = 'no capture is open';
  throw generation === 0 ? new Error(message) : new Closed(message);
}

function session() {
  return opened().session;
}

async function answer({ id, name, ask }: RequestMessage): Promise<void> {
  let message: AnswerMessage;
  try {
    message = { id, answer: await answerOf(name, ask) };
  } catch (error) {
    const status = error instanceof BissError ? error.status : 3;
    message = { id, error: messageOf(error), status, isClosed: error instanceof Closed };
  }
  self.postMessage(message, transferablesOf(message.answer));
}

function answerOf(name: string, ask: unknown): unknown {
  const handler = (handlers as Record<string, (ask: unknown) => unknown>)[name];
  if (handler === undefined) throw new Error(`no request ${name}`);
  return handler(ask);
}

// Arrays of an answer are moved, not copied.
function transferablesOf(value: unknown): Transferable[] {
  if (typeof value !== 'object' || value === null) return [];
  const parts = ArrayBuffer.isView(value) ? [value] : Object.values(value);
  const buffers = parts.flatMap((part) =>
    (ArrayBuffer.isView(part) && part.byteLength > 0 ? [part.buffer as ArrayBuffer] : []));
  return [...new Set(buffers)];
}

self.onmessage = (event: MessageEvent<RequestMessage>) => void answer(event.data);
