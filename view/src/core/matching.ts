// Rows for which a condition is true, in the worker.
import type { Column, Session } from 'biss';
import { type Condition, ConditionError, type Decimal, type Operator, parseCondition } from './condition';
import { markOf } from './statuses';

// Rows are read in stretches, so that memory does not grow with the capture.
const stretch = 16_384;

/** Returns for rows of a stretch, by their place in it, whether they match. */
type Test = (place: number) => boolean;

/** Rows for which the condition is true, from `from` on (exclusive), or back from it with a step of -1. */
function* matching(session: Session, text: string, from: number, step: 1 | -1): Generator<number, undefined> {
  const condition = parseCondition(text, session.columns);
  const count = session.rowCount;
  let at = Math.max(-1, Math.min(from, count)) + step;
  while (at >= 0 && at < count) {
    const begin = step > 0 ? at : Math.max(0, at - stretch + 1);
    const end = step > 0 ? Math.min(count, at + stretch) : at + 1;
    const test = testOf({ session, begin, end }, condition);
    for (; at >= begin && at < end; at += step) {
      if (test(at - begin)) yield at;
    }
  }
}

/** The nearest row after `from` (before it with a step of -1) for which the condition is true. */
export function findRow(session: Session, text: string, from: number, step: 1 | -1): number | undefined {
  return matching(session, text, from, step).next().value;
}

/** The first rows, at most `most`, for which the condition is true. */
export function findRows(session: Session, text: string, most: number): Int32Array {
  const found: number[] = [];
  for (const row of matching(session, text, -1, 1)) {
    if (found.push(row) >= most) break;
  }
  return Int32Array.from(found);
}

/** Rows that are tested together: from `begin` to before `end`. */
interface Stretch {
  session: Session;
  begin: number;
  end: number;
}

// The text of a cell, by its place in the stretch.
function textsOf({ session, begin, end }: Stretch, { name, kind }: Column): (place: number) => string {
  if (kind === 'bits') {
    const index = session.columns.findIndex((column) => column.name === name);
    const cells = session.cells(begin, end);
    return (place) => cells[place]?.[index] ?? '';
  }
  const { present, values, texts } = session.column(name, begin, end);
  return (place) => (present[place] === 0 ? '' : texts[Number(values[place])] ?? '');
}

function testOf(rows: Stretch, condition: Condition): Test {
  switch (condition.kind) {
    case 'or':
    case 'and': {
      const tests = condition.of.map((each) => testOf(rows, each));
      if (condition.kind === 'or') return (place) => tests.some((test) => test(place));
      return (place) => tests.every((test) => test(place));
    }
    case 'not': {
      const test = testOf(rows, condition.of);
      return (place) => !test(place);
    }
    case 'error':
      return errorTest(rows);
    case 'compare':
      return comparison(rows, condition);
  }
}

// The rows of `biss decode --only-errors`.
function errorTest(rows: Stretch): Test {
  const tests = rows.session.columns
    .filter(({ role }) => ['status', 'verdict', 'warnings', 'error_at_0'].includes(role))
    .map((column) => ({ role: column.role, text: textsOf(rows, column) }));
  return (place) => tests.some(({ role, text }) => markOf(role, text(place)) !== '');
}

type Comparison = Extract<Condition, { kind: 'compare' }>;

function comparison(rows: Stretch, condition: Comparison): Test {
  const column = rows.session.columns.find(({ name }) => name === condition.column)!;
  const { kind } = column;
  if (kind === 'text' || kind === 'bits') return textTest(rows, column, condition);
  if (condition.value === undefined) {
    throw new ConditionError(`"${condition.text}" is not a number, and ${condition.column} is one`);
  }
  const { present, values } = rows.session.column(condition.column, rows.begin, rows.end);
  const holds = comparisons[condition.operator];
  if (kind === 'real') {
    const limit = Number(condition.value.digits) / 10 ** condition.value.places;
    return (place) => present[place] !== 0 && holds(Number(values[place]), limit);
  }
  const scale = 10n ** BigInt(condition.value.places);
  const limit = condition.value.digits * unitOf(column, condition.unit, condition.value);
  return (place) => present[place] !== 0
    && holds(BigInt(values[place]!) * scale, limit);
}

const timeUnits: Record<string, bigint> = {
  ps: 1n, ns: 1_000n, us: 1_000_000n, ms: 1_000_000_000n, s: 1_000_000_000_000n,
};
const rateUnits: Record<string, bigint> = {
  Hz: 1n, kHz: 1_000n, MHz: 1_000_000n, hz: 1n, khz: 1_000n, mhz: 1_000_000n,
};

// How many units of the values of a column this unit is. Times are in picoseconds, and without a
// unit in nanoseconds, as the command writes them.
function unitOf({ name, kind, valueUnit }: Column, unit: string, value: Decimal): bigint {
  if (unit === '' && kind !== 'time') return 1n;
  const units: Record<string, bigint> = kind === 'time' ? timeUnits : valueUnit === 'Hz' ? rateUnits : {};
  const factor = units[unit || 'ns'];
  if (factor === undefined) {
    throw new ConditionError(`${Number(value.digits) / 10 ** value.places}${unit}: ${name} does not have this unit`);
  }
  return factor;
}

const comparisons: Record<Operator, <T extends bigint | number>(value: T, limit: T) => boolean> = {
  '=': (value, limit) => value === limit,
  '!=': (value, limit) => value !== limit,
  '<': (value, limit) => value < limit,
  '<=': (value, limit) => value <= limit,
  '>': (value, limit) => value > limit,
  '>=': (value, limit) => value >= limit,
};

// A cell of text may have several words, as `limits` has. Bits are compared as the command writes them.
function textTest(rows: Stretch, column: Column, { operator, text }: Comparison): Test {
  const isText = column.kind === 'text';
  if (operator !== '=' && operator !== '!=') {
    throw new ConditionError(`${column.name} is ${isText ? 'text' : 'a row of bits'}: compare it with = or !=`);
  }
  const cell = textsOf(rows, column);
  const isEqual = isText
    ? (place: number) => cell(place) === text || cell(place).split(';').includes(text)
    : (place: number) => cell(place).toLowerCase() === text.toLowerCase();
  return (place) => isEqual(place) === (operator === '=');
}
