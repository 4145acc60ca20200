/**
 * The core of biss in WebAssembly, for a page or a worker and for Node. Everything is synchronous but
 * loading, so a page calls it in a worker. Times are picoseconds.
 */

/** The source of the bytes of a file. It must not change while the file is in use. */
export interface ByteSource {
  readonly size: number;
  /**
   * At least one and at most `length` bytes from `offset` on; in a worker by FileReaderSync, in
   * Node by fs.readSync. If it throws, the file is reported as one that cannot be read further.
   */
  read(offset: number, length: number): Uint8Array;
}

/** As the exit status of the command: 0 done, 1 the data failed, 2 wrong usage, 3 not readable. */
export type Status = 0 | 1 | 2 | 3;

/** The message of the command, as on its stderr. */
export class BissError extends Error {
  readonly status: Status;
}

/** The result of a verb. */
export interface RunResult {
  status: Status;
  /** The bytes that the command writes to stdout. */
  out: Uint8Array;
  /** The text that it writes to stderr. */
  err: string;
}

/** Facts about a capture; times as decimal text, because they have up to 63 bits. */
export interface About {
  name: string;
  /** All lines of the capture. */
  lines: string[];
  ma: string;
  slo: string;
  maInverted: boolean;
  sloInverted: boolean;
  linesBy: 'given' | 'name' | 'behaviour';
  looksSwapped: boolean;
  /** In hertz; 0 if unknown. */
  sampleRate: number;
  /** The last time that was read. */
  endTime: string;
  /** Contents of the file: times of changes, samples of levels, or voltages with a threshold. */
  lineKind: 'changes' | 'samples' | 'voltages';
  /** Request cycles read so far. */
  cycles: number;
  /** Rows of accesses to registers, and commands, so far. */
  accesses: number;
  ended: boolean;
  /** After the end, the exit status of `biss decode`. */
  status: Status;
  /** Why reading ended before the end of the capture, or empty. */
  error: string;
  /** Absent if no format is given and none is certain. */
  format?: string;
  /** The name of an encoder or of a safety configuration, if one was given for the format. */
  formatName?: string;
  /** The confidence of the identified format, 0 to 1. */
  confidence?: number;
  /** With `confidence`: names of encoders in the catalogue that may send these frames. */
  encoders?: string[];
}

/** The words for users of statuses and verdicts, in the order of their values. */
export interface Words {
  /** For a cycle. `fault`: the transmission is wrong; `cut`: an end of the capture cuts it. */
  statuses: { name: string; seen: string; fault: boolean; cut: boolean }[];
  /** Verdicts of the safety monitor. `fault`: it is not a state. */
  verdicts: { name: string; fault: boolean }[];
}

/** The scope of an option; verbs/common/verb.hpp explains it. */
export interface DescribedOption {
  /** `-f,--format`, or `FILE` of an argument. */
  names: string;
  /** The long name. */
  name: string;
  /** The name of the value in the help; empty for a flag. */
  value: string;
  meaning: string;
  heading: string;
  scope: 'reading' | 'file' | 'judging' | 'rows' | 'command';
  repeats: boolean;
  required: boolean;
  /** The allowed values; empty if they are not a list. */
  choices: string[];
}

export interface DescribedVerb {
  name: string;
  options: DescribedOption[];
  /** Verbs below, as `safety analyse`. */
  verbs: DescribedVerb[];
}

export type ColumnKind = 'unsigned' | 'signed' | 'time' | 'real' | 'text' | 'bits' | 'flag';

/** The meaning of a value for its row; the names of report/table.hpp. */
export type Role =
  | 'value' | 'status' | 'verdict' | 'warnings' | 'error_at_0' | 'check_at_0' | 'warning_at_0' | 'warning_at_1';

/** A column of `biss decode --to csv`. */
export interface Column {
  name: string;
  kind: ColumnKind;
  valueUnit: string;
  role: Role;
  /** The title of its plot, or of the causes that its role counts. */
  title: string;
  /** Place of its plot among the plots, which columns may share; 0: it has none. */
  plot: number;
}

/** Values of a column, a row each. */
export interface ColumnValues {
  kind: ColumnKind;
  /** 0 if the cell is empty. */
  present: Uint8Array;
  /**
   * Without loss: `time` in picoseconds. `real` is a Float64Array; of `text` and `flag` the values are
   * indices of `texts`; of `bits` there are none, csv() has them.
   */
  values: BigUint64Array | BigInt64Array | Float64Array;
  texts: string[];
}

/** A stretch of a line as it is to be drawn: `levels[i]` from `times[i]` to `times[i + 1]`. */
export interface LineView {
  times: BigInt64Array;
  /** 0 low, 1 high, 2 unknown, 3 busy: several changes up to the next time. */
  levels: Uint8Array;
}

/** A clock of MA and the bit that belongs to it. */
export interface CycleBit {
  clock: number;
  /** The rising edge of MA. */
  time: string;
  /** `LAT`, `ACK`, `START`, `CDS`, `STOP`, a field of the format with the number of the bit. */
  name: string;
  /** When SLO is sampled for it; absent without ACK. */
  sampledAt?: string;
  level?: 0 | 1;
  /** Number among the bits of data and CRC. */
  payloadBit?: number;
  /** For a bit of the CRC: the level that the received data need. */
  expected?: 0 | 1;
}

/** The checksum of a channel. */
export interface CycleCheck {
  channel: number;
  received: number;
  expected: number;
  right: boolean;
  /** Single bits whose flip would correct the channel, by payloadBit. */
  singles: number[][];
}

/** A stretch of a cycle with a name, as in `biss draw`. */
export interface CyclePart {
  kind: 'line' | 'frame' | 'data' | 'flag' | 'crc';
  /** `ACK 3.2 µs, 32 clocks`, `pos=1234`, `crc=0x16`. */
  text: string;
  /** A shorter text, if there is one. */
  brief?: string;
  from: string;
  to: string;
  /** It is not as it should be; an active error or warning of the encoder counts too. */
  wrong: boolean;
}

/** A cycle bit by bit and part by part. */
export interface Cycle {
  number: number;
  time: string;
  end: string;
  /** The period of MA. */
  period: string;
  status: string;
  /** The head of `biss explain --cycle`, and its drawing. */
  title: string;
  text: string;
  bits: CycleBit[];
  checks: CycleCheck[];
  /** Tracks that the cycle has, each with its parts in the order of time. */
  tracks: { frame?: CyclePart[]; delay?: CyclePart[]; CDM?: CyclePart[] };
  /** The places and causes of failures: `crc: received 0x36, expected 0x1`. */
  failures: { time: string; text: string }[];
  /** The bit of the master; absent if MA does not show it. */
  cdm?: 0 | 1;
  /**
   * From the last edge of MA until the encoder releases SLO; negative if MA still runs then. Absent
   * if SLO does not show it.
   */
  release?: string;
}

/** A row of `biss registers --to jsonl`. */
export interface Access {
  /** The number of the cycle in which it begins, and how many cycles it takes. */
  cycle: number;
  cycles: number;
  time_ns: number;
  id: number | null;
  access: string;
  address: string | null;
  name: string | null;
  data: string | null;
  outcome: string;
  busy_ns: number | null;
}

/** A capture that is read step by step. The part that has been read is available at any time. */
export interface Session {
  /**
   * Reads on for about this time. `more` is false at the end; then `messages` are the messages of
   * the command, its summary included.
   * @throws BissError when memory has run out
   */
  advance(milliseconds: number): { more: boolean; messages: string };
  about(): About;
  readonly columns: readonly Column[];
  readonly rowCount: number;
  /** Rows from `from` to before `to` as the command writes them, with the header. */
  csv(from: number, to: number): string;
  /** The same by cells, without the header. */
  cells(from: number, to: number): string[][];
  /** @throws RangeError without such a column */
  column(name: string, from: number, to: number): ColumnValues;
  /**
   * How a line looks from `from` to `to` on a screen of `columns` columns, as the capture shows it.
   * Begins at or after `from`; empty before the first change.
   */
  view(line: 'ma' | 'slo', from: bigint, to: bigint, columns: number): LineView;
  /**
   * Accesses to registers, and commands, within the cycles from number `from` to before `to`, only
   * completed ones.
   */
  accesses(from: number, to: number): Access[];
  /** The summary of `biss decode` for the part that has been read. */
  summary(): string;
  /**
   * A row's cycle; undefined if its edges alone do not show it again. `number` names it otherwise.
   */
  cycle(row: number, number?: number): Cycle | undefined;
  /** Frees the memory. Nothing may be called afterwards. */
  close(): void;
}

export interface Biss {
  /**
   * Makes a file known by its name, which verbs and messages use. From a source only the blocks
   * that a verb reads are requested; it cannot be written. Bytes are copied.
   */
  addFile(name: string, source: Uint8Array | ByteSource): void;
  removeFile(name: string): void;
  /** The names of all files, also of files that verbs have written. */
  fileNames(): string[];
  /** A file that a verb has written with `-o NAME`. */
  readFile(name: string): Uint8Array;
  words(): Words;
  /** `biss` itself, with the verbs that this core has. */
  verbs(): DescribedVerb;
  /**
   * Runs a verb to its end: identify, check, explain, eds, safety analyse, simulate, and all others
   * but archive, the campaigns of safety and HDF5.
   */
  run(args: string[]): RunResult;
  /**
   * Opens a capture as `biss decode ARGS` does. `messages` are the warnings so far.
   * @param options anyLines: take the two busiest lines if none look like MA and SLO
   * @throws BissError with the message of the command
   */
  open(args: string[], options?: { anyLines?: boolean }): { session: Session; messages: string };
}

/**
 * Loads the core. `wasmBinary` has the bytes of biss_core.wasm; without it they are fetched from
 * the folder of this file.
 */
export function loadBiss(options?: { wasmBinary?: Uint8Array }): Promise<Biss>;
