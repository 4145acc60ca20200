// The conditions of the search field and of the filter:
//
//     condition  = all { "or" all }
//     all        = term { "and" term }
//     term       = "not" term | "(" condition ")" | word | column compare value
//     compare    = "=" | "!=" | "<" | "<=" | ">" | ">="
//
// A column has its name in the CSV of `biss decode`, or a short name (ack, delay, clock, time). A
// word is a status, a safety verdict, a flag that is bad, or `error`. A value may have a unit: 12us, 5MHz.
import type { Column } from 'biss';
import { badAt, statuses, verdicts } from './statuses';

export type Operator = '=' | '!=' | '<' | '<=' | '>' | '>=';

/** A number without loss: `digits` by `10 ** places`. */
export interface Decimal {
  digits: bigint;
  places: number;
}

export type Condition =
  | { kind: 'or' | 'and'; of: Condition[] }
  | { kind: 'not'; of: Condition }
  | { kind: 'compare'; column: string; operator: Operator; text: string; value?: Decimal; unit: string }
  /** The same rows as with `biss decode --only-errors`. */
  | { kind: 'error' };

export class ConditionError extends Error {}

const shortNames: Record<string, string> = {
  row: 'cycle',
  time: 'time_ns',
  delay: 'line_delay_ns',
  line_delay: 'line_delay_ns',
  ack: 'ack_ns',
  clock: 'clock_hz',
};

/** Suggestions of the search field. */
export const suggestions = [
  'error', 'not ok', ...Object.keys(statuses), 'nE=0', 'nW=0', 'marginal',
  'position > 1000', 'ack > 10us', 'delay > 500ns', 'clock < 1MHz', 'time > 1ms', 'cycle = 100',
];

function equal(column: string, text: string): Condition {
  return { kind: 'compare', column, operator: '=', text, ...valueOf(text) };
}

/** @throws ConditionError with the problem and its place in the text */
export function parseCondition(text: string, columns: readonly Column[]): Condition {
  const parser = new Parser(tokensOf(text), columns);
  const condition = parser.condition();
  parser.expectEnd();
  return condition;
}

function tokensOf(text: string): string[] {
  return text.match(/[<>!=]=|[<>=()]|[^\s<>!=()]+|\S/g) ?? [];
}

class Parser {
  #at = 0;
  readonly #names: readonly string[];

  constructor(private readonly tokens: string[], private readonly columns: readonly Column[]) {
    this.#names = columns.map(({ name }) => name);
  }

  #peek(): string | undefined {
    return this.tokens[this.#at];
  }

  #take(word: string): boolean {
    if (this.#peek()?.toLowerCase() !== word) return false;
    this.#at += 1;
    return true;
  }

  condition(): Condition {
    return this.#joined('or', () => this.#joined('and', () => this.#term()));
  }

  #joined(kind: 'or' | 'and', part: () => Condition): Condition {
    const of = [part()];
    while (this.#take(kind)) of.push(part());
    return of.length === 1 ? of[0]! : { kind, of };
  }

  #term(): Condition {
    if (this.#take('not')) return { kind: 'not', of: this.#term() };
    if (this.#take('(')) {
      const inner = this.condition();
      if (!this.#take(')')) throw new ConditionError('a ")" is missing');
      return inner;
    }
    const word = this.#peek();
    if (word === undefined) throw new ConditionError('a condition is missing at the end');
    if (!/^[\p{L}\p{N}_.+-]+$/u.test(word)) throw new ConditionError(`"${word}" is not expected here`);
    this.#at += 1;
    const operator = this.#peek();
    if (operator !== undefined && /^([<>]=?|!?=|==)$/.test(operator)) {
      this.#at += 1;
      return this.#comparison(word, operator === '==' ? '=' : (operator as Operator));
    }
    return this.#word(word);
  }

  #comparison(name: string, operator: Operator): Condition {
    const column = this.#columnOf(name);
    if (column === undefined) {
      throw new ConditionError(`"${name}" is not a column; they are ${this.#names.join(', ')}`);
    }
    const text = this.#peek();
    if (text === undefined) throw new ConditionError(`a value is missing after "${operator}"`);
    this.#at += 1;
    return { kind: 'compare', column, operator, text, ...valueOf(text) };
  }

  #columnOf(name: string): string | undefined {
    const known = [name, shortNames[name.toLowerCase()] ?? name];
    return known.find((each) => this.#names.includes(each))
      ?? this.#names.find((each) => each.toLowerCase() === name.toLowerCase())
      ?? this.#names.find((each) => each.startsWith(`${name}_`));
  }

  #word(word: string): Condition {
    const lower = word.toLowerCase();
    if (lower === 'error' || lower === 'errors') return { kind: 'error' };
    const column = this.columns.find(({ name }) => name.toLowerCase() === lower);
    const bad = column && badAt(column.role);
    if (bad !== undefined) return equal(column!.name, bad);
    if (lower in statuses) return equal('status', lower);
    if (verdicts.has(lower)) return equal('safety', lower);
    if (/^\d+$/.test(word)) return equal('cycle', word);
    throw new ConditionError(`"${word}" is not a status; write for example "crc" or "position > 1000"`);
  }

  expectEnd(): void {
    const rest = this.#peek();
    if (rest !== undefined) throw new ConditionError(`"${rest}" is not expected here; join with and, or`);
  }
}

function valueOf(text: string): { value?: Decimal; unit: string } {
  const hexadecimal = /^0[xX]([0-9a-fA-F]+)$/.exec(text);
  if (hexadecimal !== null) return { value: { digits: BigInt(text), places: 0 }, unit: '' };
  const found = /^([+-]?)(\d*)\.?(\d*)([a-zA-Zµ]*)$/.exec(text);
  if (found === null) return { unit: '' };
  const [, sign, whole, fraction = '', unit = ''] = found;
  if (`${whole}${fraction}` === '') return { unit: '' };
  const digits = BigInt(`${sign}${whole}${fraction}`.replace(/^\+/, ''));
  return { value: { digits, places: fraction.length }, unit: unit.replace('µ', 'u') };
}
