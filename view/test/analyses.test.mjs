import assert from 'node:assert/strict';
import { test } from 'node:test';
import { manyRows, sessionOf } from './capture_rows.mjs';
import { load } from './typescript.mjs';

const analyses = {
  ...await load('plots/envelope.ts'), ...await load('plots/row_classes.ts'), ...await load('plots/causes_of.ts'),
};
const times = await load('plots/row_times.ts');

const rows = manyRows(100_000);
const session = sessionOf(rows);
const first = rows[0].time_ns;
const last = rows.at(-1).time_ns;

test('Numbers_OfSignedAndUnsigned_AreExact', () => {
  const signed = BigInt64Array.of(-1n, 0n, 1n << 52n, -(1n << 52n));
  assert.deepEqual([...times.numbersOf(signed)], [-1, 0, 2 ** 52, -(2 ** 52)]);
  assert.deepEqual([...times.numbersOf(BigUint64Array.of(0xFFFF_FFFF_0000_0000n))], [0xFFFF_FFFF * 2 ** 32]);
  const far = (1n << 60n) + 5n;
  assert.deepEqual([...times.numbersOf(BigInt64Array.of(far - 7n, far + 9n), far)], [-7, 9]);
});

test('RowFrom_AnyTime_IsTheFirstRowAtOrAfterIt', () => {
  for (const row of [0, 1, 63, 64, 65, 998, 999, 1000, 12_345, 99_968, 99_999]) {
    const at = rows[row].time_ns;
    assert.equal(times.rowFrom(session, at), row);
    assert.equal(times.rowFrom(session, at + 1n), row + 1);
    assert.equal(times.rowFrom(session, at - 1n), row);
  }
  assert.equal(times.rowFrom(session, -5n), 0);
});

function extremes(from, to) {
  const values = rows
    .filter((row) => row.time_ns >= from && row.time_ns < to && row.position !== undefined)
    .map(({ position }) => Number(position));
  return [Math.min(...values), Math.max(...values)];
}

test('Envelope_OfAllRows_HasTheirExtremes', () => {
  const answer = analyses.envelope(session, { column: 'position', from: first, to: last + 1n, points: 1000 });
  assert.ok(answer.times.length <= 1100, `${answer.times.length} points`);
  assert.ok(answer.rows > 64);
  assert.deepEqual([Math.min(...answer.low), Math.max(...answer.high)], extremes(first, last + 1n));
});

test('Envelope_OfFewRows_HasEachValue', () => {
  const [from, to] = [rows[500].time_ns, rows[520].time_ns];
  const answer = analyses.envelope(session, { column: 'position', from, to, points: 1000 });
  assert.equal(answer.rows, 1);
  const at = [...answer.times].indexOf(Number(rows[510].time_ns - from));
  assert.equal(answer.low[at], Number(rows[510].position));
  assert.equal(answer.high[at], Number(rows[510].position));
});

test('Envelope_WithoutAPosition_HasAGap', () => {
  const at = rows.findIndex(({ status }, i) => status === 'crc' && i > 1000);
  const ask = { column: 'position', from: rows[at].time_ns, to: rows[at + 1].time_ns, points: 100 };
  const answer = analyses.envelope(session, ask);
  assert.ok(Number.isNaN(answer.low[0]));
});

function countsIn(from, to) {
  const within = rows.filter((row) => row.time_ns >= from && row.time_ns < to);
  return {
    all: within.length,
    failed: within.filter(({ status }) => status === 'crc').length,
    flagged: within.filter(({ nE }) => nE === 0n).length,
  };
}

function sum(counts) {
  return counts.reduce((total, count) => total + count, 0);
}

test('Strip_OfBlocksAndOfRows_CountsEveryRow', () => {
  for (const [from, to] of [[first, last + 1n], [rows[2000].time_ns, rows[2500].time_ns]]) {
    const strip = analyses.strip(session, { from, to, columns: 700 });
    const sums = { all: sum(strip.all), failed: sum(strip.failed), flagged: sum(strip.flagged) };
    assert.deepEqual(sums, countsIn(from, to));
  }
});

test('Strip_OfAllRows_CountsThemWhereTheyAre', () => {
  const columns = 700;
  const strip = analyses.strip(session, { from: first, to: last + 1n, columns });
  const expected = new Uint32Array(columns);
  for (const { time_ns: time } of rows) {
    expected[Math.floor((Number(time - first) * columns) / Number(last + 1n - first))] += 1;
  }
  assert.deepEqual([...strip.all], [...expected]);
});

test('Rows_InAStretch_IncludeTheOneThatHasBegun', () => {
  const answer = analyses.rows(session, { from: rows[10].time_ns + 5n, to: rows[13].time_ns, most: 100 });
  assert.equal(answer.count, 3);
  const expected = [10, 11, 12].map((row) => ({ row, from: rows[row].time_ns, to: rows[row + 1].time_ns }));
  assert.deepEqual(answer.rows.map(({ row, from, to }) => ({ row, from, to })), expected);
});

test('Rows_WithAFlag_SayWhichOne', () => {
  const flagged = rows.findIndex(({ nE }) => nE === 0n);
  const ask = { from: rows[flagged].time_ns, to: rows[flagged + 1].time_ns, most: 9 };
  const [row] = analyses.rows(session, ask).rows;
  assert.equal(row.notes, 'nE=0');
  assert.equal(row.class, 2);
});

test('Rows_TooMany_AreOnlyCounted', () => {
  const answer = analyses.rows(session, { from: first, to: last + 1n, most: 1000 });
  assert.equal(answer.count, rows.length);
  assert.equal(answer.rows.length, 0);
});

test('Causes_OfAllRows_AreCounted', () => {
  const { causes, rows: count } = analyses.causes(session, { bins: 10 });
  const found = Object.fromEntries(causes.map((cause) => [cause.name, cause.count]));
  const expected = countsIn(first, last + 1n);
  assert.equal(count, rows.length);
  assert.deepEqual(found, { ok: rows.length - expected.failed, crc: expected.failed, 'nE=0': expected.flagged });
  causes.forEach(({ count: all, over }) => assert.equal(sum(over), all));
});
