// The worker: holds the core, reads the capture in slices, and answers between them.
import { BissError, loadBiss } from 'biss';
import type { Biss, Session } from 'biss';
import { causes } from '../plots/causes_of';
import { envelope } from '../plots/envelope';
import { eye } from '../plots/eye_of';
import { rows, strip } from '../plots/row_classes';
import { findRow, findRows } from './matching';
import { Reader } from './reader';
import { PartSession, wholeCauses, wholeEnvelope, type Report } from './report';
import { rowFrom } from '../plots/row_times';
import { measuredSource, type MeasuredSource } from './source';
import { messageOf } from './texts';
import { unpack } from './unpack';
import type { AnswerMessage, Commands, RequestMessage, Requests } from './protocol';

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

const handlers: { [K in keyof Requests]: (ask: Requests[K]['ask']) => Requests[K]['answer'] | Promise<Requests[K]['answer']> } = {
  async load({ core }) {
    biss = await loadBiss({ wasmBinary: await unpack(core) });
  },
  addFile({ name, content }) {
    const source = measuredSource(content);
    loaded().addFile(name, source);
    sources.set(name, source);
  },
  removeFile({ name }) {
    loaded().removeFile(name);
    sources.delete(name);
  },
  readFile: ({ name }) => loaded().readFile(name),
  run: ({ args }) => loaded().run(args),
  report({ report: given }) {
    report = given;
  },
  open(ask) {
    const { session, messages } = openSession(ask);
    closeAll();
    generation += 1;
    reader = new Reader(session, generation, sourcesOf(ask.args), (message) => self.postMessage(message));
    return { generation, columns: session.columns, messages };
  },
  async openBehind(ask) {
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
  view: ({ line, from, to, columns }) => session().view(line, from, to, columns),
  cells: ({ from, to }) => session().cells(from, to),
  cellsOf: ({ rows }) => rows.flatMap((row) => session().cells(row, row + 1)),
  csv: ({ from, to }) => session().csv(from, to),
  column: ({ name, from, to }) => session().column(name, from, to),
  cycle: ({ row }) => session().cycle(row),
  summary: () => session().summary(),
  find: ({ condition, from, step }) => findRow(session(), condition, from, step),
  findAll: ({ condition, most }) => findRows(session(), condition, most),
  rowAt: ({ time }) => lastAtOrBefore(time),
  rowOfCycle({ number }) {
    const row = rowFrom(session(), BigInt(number), 'cycle');
    return Number(session().column('cycle', row, row + 1).values[0]) === number ? row : undefined;
  },
  'analyse.envelope': (ask) => {
    const whole = wholeReport();
    return whole && wholeEnvelope(whole, ask) || analysed(envelope, ask);
  },
  'analyse.strip': (ask) => analysed(strip, ask),
  'analyse.rows': (ask) => analysed(rows, ask),
  'analyse.causes': (ask) => {
    const whole = wholeReport();
    return whole ? wholeCauses(whole) : analysed(causes, ask);
  },
  'analyse.eye': (ask) => analysed(eye, ask),
};

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
function openSession({ args, anyLines, isWhole }: Commands['open']['ask']) {
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

// The last row whose value in a column that never falls is at most this.
function lastAtOrBefore(value: bigint, column?: string): number | undefined {
  const after = rowFrom(session(), value + 1n, column);
  return after === 0 ? undefined : after - 1;
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
