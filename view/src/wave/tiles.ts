/** The data that the screen shows of a line, of rows and of cycles, requested from the core and kept. */
import { Superseded, CoreError } from '../core/client';
import { core } from '../core/core';
import type { Answer, Ask } from '../core/protocol';
import * as state from '../state';
import type { Range } from '../state';
import { layOut, type CycleLayout } from './layout';

/** A request for a stretch of time. */
interface Asked extends Range {
  columns: number;
  generation: number;
  /** The end of the data read by then. */
  end: bigint;
  version: number | undefined;
}

/** The stretch that is shown now. */
export interface Shown extends Range {
  /** Width of the picture in pixels. */
  width: number;
  end: bigint;
  /** Changes if there are newer data for the stretch, such as an access that has ended since. */
  version?: number;
}

/**
 * The end of the data read so far, in steps of a few percent while it grows, so that a view of the
 * whole capture is not counted again with every row.
 */
export function steadyEnd(): bigint {
  const end = state.endTime.value;
  if (state.progress.value.state !== 'reading') return end;
  const bits = BigInt(Math.max(0, end.toString(2).length - 6));
  return (end >> bits) << bits;
}

/** The same of the number of rows. */
export function steadyRows(): number {
  const rows = state.rowCount.value;
  return state.progress.value.state === 'reading' && rows > 0 ? 2 ** Math.floor(Math.log2(rows)) : rows;
}

/** An answer for a stretch that is wider than the picture, so that moving it shows something. */
export class Tile<K extends 'view' | 'analyse.strip' | 'analyse.rows' | 'analyse.envelope'> {
  answer: Answer<K> | undefined;
  asked: Asked | undefined;
  #pending: Asked | undefined;

  constructor(
    private readonly name: K,
    private readonly lane: string,
    private readonly askOf: (asked: Asked) => Ask<K>,
    private readonly onAnswer: () => void,
  ) {}

  /** Requests the shown data, unless they are present. */
  want(shown: Shown): void {
    if (this.asked?.generation !== state.generation.value) this.drop();
    if (serves(this.asked, shown) || serves(this.#pending, shown)) return;
    const span = shown.to - shown.from;
    const asked: Asked = {
      from: shown.from - span,
      to: shown.to + span,
      columns: Math.max(3, Math.round(3 * shown.width)),
      generation: state.generation.value,
      end: shown.end,
      version: shown.version,
    };
    this.#pending = asked;
    core().ask(this.name, this.askOf(asked), { lane: this.lane }).then(
      (answer) => this.#take(asked, answer),
      (error: unknown) => this.#failed(asked, error),
    );
  }

  drop(): void {
    this.answer = undefined;
    this.asked = undefined;
    this.#pending = undefined;
  }

  #take(asked: Asked, answer: Answer<K>): void {
    if (this.#pending?.generation !== asked.generation) return;
    if (this.#pending === asked) this.#pending = undefined;
    this.answer = answer;
    this.asked = asked;
    this.onAnswer();
  }

  #failed(asked: Asked, error: unknown): void {
    if (this.#pending === asked) this.#pending = undefined;
    if (!(error instanceof Superseded) && !(error instanceof CoreError)) throw error;
  }
}

// Whether the answer is as fine as the picture, or nearly, and up to date if the capture has grown.
function serves(asked: Asked | undefined, shown: Shown): boolean {
  if (asked?.generation !== state.generation.value || asked.version !== shown.version) return false;
  const stale = asked.end < shown.end && asked.end < asked.to && asked.end < shown.to;
  if (stale) return false;
  if (asked.from > shown.from || asked.to < shown.to) return false;
  const column = Number(asked.to - asked.from) / asked.columns;
  const wanted = Number(shown.to - shown.from) / shown.width;
  return column <= wanted * 1.05 && column >= wanted / 6;
}

/** The view of a line; its times count from `from`. */
export interface LineTile extends Answer<'view'> {
  /** How far the line is known, from `from`. */
  end: number;
}

export function lineTile({ answer, asked }: Tile<'view'>): LineTile | undefined {
  if (answer === undefined || asked === undefined) return undefined;
  const known = asked.end < asked.to ? asked.end : asked.to;
  return { ...answer, end: Number(known - asked.from) };
}

const mostKept = 600;
const mostAtOnce = 4;

/** Cycles as they are drawn, the newest kept. */
export class Cycles {
  readonly #kept = new Map<number, CycleLayout | undefined>();
  readonly #asked = new Set<number>();
  #generation = -1;

  constructor(private readonly onAnswer: () => void) {}

  /** Undefined if it has not come yet, or cannot be read. */
  get(row: number): CycleLayout | undefined {
    return this.#kept.get(row);
  }

  /** Requests the missing cycles of these rows. */
  want(rows: readonly number[]): void {
    const generation = state.generation.value;
    if (generation !== this.#generation) {
      this.#kept.clear();
      this.#asked.clear();
      this.#generation = generation;
    }
    for (const row of rows) {
      if (this.#asked.size >= mostAtOnce) return;
      if (!this.#kept.has(row) && !this.#asked.has(row)) this.#ask(row, generation);
    }
  }

  #ask(row: number, generation: number): void {
    // While the capture is read, a missing cycle may still come.
    const more = state.progress.value.state === 'reading';
    this.#asked.add(row);
    core().ask('cycle', { row }).then(
      (cycle) => {
        if (generation !== this.#generation) return;
        this.#asked.delete(row);
        if (cycle !== undefined || !more) this.#kept.set(row, cycle && layOut(cycle));
        const oldest = this.#kept.keys().next().value;
        if (this.#kept.size > mostKept && oldest !== undefined) this.#kept.delete(oldest);
        this.onAnswer();
      },
      () => {
        if (generation === this.#generation) this.#asked.delete(row);
      },
    );
  }
}
