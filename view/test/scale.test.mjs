import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './typescript.mjs';

const scale = await load('wave/scale.ts');
const ticks = await load('plots/ticks.ts');

test('Times_HaveAUnitThatFits', () => {
  assert.equal(scale.timeText(0), '0 s');
  assert.equal(scale.timeText(345_500), '345.5 ns');
  assert.equal(scale.timeText(12_500_000n), '12.5 µs');
  assert.equal(scale.timeText(-1_000_000_000_000), '−1 s');
  assert.equal(scale.timeText(7_200_000_000_000_000), '7200 s');
});

test('ExactTimes_KeepEveryPicosecond', () => {
  assert.equal(scale.exactTimeText(12_000_345_678_901n), '12.000345678901 s');
  assert.equal(scale.exactTimeText(-1_500n), '−1.5 ns');
  // Beyond what a number holds.
  assert.equal(scale.exactTimeText(86_400_000_000_000_001n), '86400.000000000001 s');
});

test('Scale_FarFromZero_LosesNoPicosecond', () => {
  const day = 86_400_000_000_000_000n;
  const shown = new scale.TimeScale({ from: day, to: day + 1000n }, 1000);
  assert.equal(shown.x(day + 1n), 1);
  assert.equal(shown.time(999), day + 999n);
});

test('Zoom_KeepsTheTimeAtThePointer', () => {
  const range = { from: 1_000_000n, to: 2_000_000n };
  const next = scale.zoomed(range, 0.5, 0.25);
  assert.deepEqual(next, { from: 1_125_000n, to: 1_625_000n });
  assert.equal(scale.zoomed(range, 1e-9, 0.5).to - scale.zoomed(range, 1e-9, 0.5).from, scale.shortestSpan);
});

test('Marks_AreRoundAndApart', () => {
  for (const span of [1000n, 123_457n, 3_000_000_000n, 86_400_000_000_000_000n]) {
    const from = 987_654_321_000n;
    const shown = new scale.TimeScale({ from, to: from + span }, 1200);
    const { marks } = scale.timeMarks(shown, 110);
    assert.ok(marks.length >= 2, `${marks.length} marks of ${span}`);
    assert.equal(new Set(marks.map(({ text }) => text)).size, marks.length);
    marks.slice(1).forEach(({ x }, i) => assert.ok(x - marks[i].x >= 109));
  }
});

test('Marks_FarFromZero_CountFromABase', () => {
  const from = 86_400_000_000_000_000n;
  const shown = new scale.TimeScale({ from, to: from + 10_000n }, 1200);
  const { marks, base } = scale.timeMarks(shown, 110);
  assert.equal(base, '86400 s');
  assert.equal(marks[1].text, '+1 ns');
});

test('Ticks_TellTheirValuesApart', () => {
  const near = ticks.ticksOf(3_000_000, 3_000_500, 4, 'time');
  const texts = near.values.map(near.text);
  assert.equal(new Set(texts).size, texts.length);
  assert.ok(texts.includes('3.0002 µs'), texts.join());
  const counts = ticks.ticksOf(0, 40_000_000, 4, 'number');
  assert.deepEqual(counts.values.map(counts.text), ['0 M', '10 M', '20 M', '30 M', '40 M']);
  assert.equal(ticks.valueText(24_745_347, 'number', 'counts'), '24\u202f745\u202f347 counts');
});
