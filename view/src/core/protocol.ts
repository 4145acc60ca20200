// The messages between the page and the worker. An answer has the number of its request.
import type { About, Column, ColumnValues, Cycle, LineView, RunResult } from 'biss';
import type { Causes, CausesAsk } from '../plots/causes_of';
import type { Envelope, EnvelopeAsk } from '../plots/envelope';
import type { Eye, EyeAsk } from '../plots/eye_of';
import type { Rows, RowsAsk, Strip, StripAsk } from '../plots/row_classes';
import type { Report } from './report';
import type { Content } from './source';

/** Requests about the open capture, and their answers. */
export interface Questions {
  view: { ask: { line: 'ma' | 'slo'; from: bigint; to: bigint; columns: number }; answer: LineView };
  cells: { ask: { from: number; to: number }; answer: string[][] };
  /** The cells of rows that need not follow one another. */
  cellsOf: { ask: { rows: readonly number[] }; answer: string[][] };
  csv: { ask: { from: number; to: number }; answer: string };
  column: { ask: { name: string; from: number; to: number }; answer: ColumnValues };
  cycle: { ask: { row: number }; answer: Cycle | undefined };
  /** The row of a cycle, by its number; undefined if the cycle has no row. */
  rowOfCycle: { ask: { number: number }; answer: number | undefined };
  /** The last row that begins at or before this time; undefined before the first one. */
  rowAt: { ask: { time: bigint }; answer: number | undefined };
  summary: { ask: Record<string, never>; answer: string };
  /** The next row from `from` on (exclusive) for which the condition is true; see condition.ts. */
  find: { ask: { condition: string; from: number; step: 1 | -1 }; answer: number | undefined };
  /** The rows for which the condition is true, at most `most`. */
  findAll: { ask: { condition: string; most: number }; answer: Int32Array };
  // The computations for the plots and the waveform: rows go in by column, envelopes and counts come out, so no
  // answer grows with the capture.
  'analyse.envelope': { ask: EnvelopeAsk; answer: Envelope };
  'analyse.strip': { ask: StripAsk; answer: Strip };
  'analyse.rows': { ask: RowsAsk; answer: Rows };
  'analyse.causes': { ask: CausesAsk; answer: Causes };
  'analyse.eye': { ask: EyeAsk; answer: Eye };
}

/** Requests that need no open capture. */
export interface Commands {
  /** biss_core.wasm in base64 of gzip. */
  load: { ask: { core: string }; answer: void };
  addFile: { ask: { name: string; content: Content }; answer: void };
  removeFile: { ask: { name: string }; answer: void };
  readFile: { ask: { name: string }; answer: Uint8Array };
  run: { ask: { args: string[] }; answer: RunResult };
  /** The capture is a part of the capture of the report. */
  report: { ask: { report: Report | undefined }; answer: void };
  /** isWhole: the settings are the same as in the report. */
  open: { ask: { args: string[]; anyLines: boolean; isWhole: boolean }; answer: Opened };
  /**
   * Opens a capture that continues the open one, and reads it to its end. Then it replaces the open one, and
   * the answer comes. The answer is undefined if another capture has been opened meanwhile.
   */
  openBehind: { ask: { args: string[]; anyLines: boolean; isWhole: boolean }; answer: Required<Opened> | undefined };
  endBehind: { ask: Record<string, never>; answer: void };
  close: { ask: Record<string, never>; answer: void };
}

export interface Opened {
  generation: number;
  columns: readonly Column[];
  messages: string;
  /** Only for a capture that has been read to its end. */
  reading?: ReadingMessage['reading'];
}

export type Requests = Questions & Commands;
export type RequestName = keyof Requests;

export interface RequestMessage {
  id: number;
  name: RequestName;
  ask: unknown;
}

export interface AnswerMessage {
  id: number;
  answer?: unknown;
  /** The text of the thrown value. */
  error?: string;
  status?: number;
  /** The capture was closed before the request came. */
  isClosed?: boolean;
}

/** Sent by the worker without a request while it reads. */
export interface ReadingMessage {
  reading: {
    generation: number;
    about: About;
    columns: readonly Column[];
    rowCount: number;
    more: boolean;
    messages: string;
    /** The part of the file that has been read, 0 to 1. */
    done: number;
    /** Empty, or why reading ended, such as memory. */
    error: string;
  };
}
