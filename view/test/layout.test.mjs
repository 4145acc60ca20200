// The parts of a cycle, from what the core says of simulated captures with faults.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { load } from './typescript.mjs';

const here = path.dirname(fileURLToPath(import.meta.url));
const core = path.resolve(process.env.BISS_WASM ?? path.join(here, '../../build-wasm/wasm'));
const { loadBiss } = await import(pathToFileURL(path.join(core, 'biss.mjs')).href);
const biss = await loadBiss({ wasmBinary: fs.readFileSync(path.join(core, 'biss_core.wasm')) });
const { layOut } = await load('wave/layout.ts');
const { eye: eyeOf } = await load('plots/eye_of.ts');

/** The rows of a simulated capture, each with its cells by column and its layout. */
function cyclesOf(format, ...options) {
  assert.equal(biss.run(['simulate', '-f', format, '-o', 'test.vcd', ...options]).status, 0);
  const { session } = biss.open(['test.vcd', '-f', format]);
  while (session.advance(100).more);
  const count = session.rowCount;
  const cells = session.cells(0, count);
  const cycles = cells.map((row, i) => {
    const cycle = session.cycle(i);
    return {
      cells: Object.fromEntries(session.columns.map(({ name }, k) => [name, row[k]])),
      cycle,
      layout: cycle === undefined ? undefined : layOut(cycle),
    };
  });
  session.close();
  return cycles;
}

function partOf(layout, field) {
  return layout.parts.find(({ texts: [text] }) => text.startsWith(`${field}=`));
}

function valueOf(layout, field) {
  return partOf(layout, field)?.texts[0].slice(field.length + 1);
}

const faults = ['flip', 'burst', 'glitch_ma', 'glitch_slo', 'lost_clock', 'double_clock', 'slo_low', 'slo_high',
  'late_start', 'no_answer', 'cut'].flatMap((kind) => ['--fault', `${kind}:0.03`]);

test('Fields_OfGoodCycles_HaveTheValuesOfTheTable', () => {
  const cycles = cyclesOf('mt12,st20,nE,nW,crc6', '--cycles', '120', '--motion', 'random');
  for (const { cells, layout } of cycles.slice(0, -1)) {
    assert.equal(valueOf(layout, 'mt'), cells.mt);
    assert.equal(valueOf(layout, 'st'), cells.st);
    assert.equal(valueOf(layout, 'nE'), cells.nE);
  }
});

test('Fields_InGrayCode_HaveTheValuesOfTheTable', () => {
  const cycles = cyclesOf('mt8,st13:gray,nE,nW,crc6', '--cycles', '60', '--motion', 'random');
  for (const { cells, layout } of cycles.slice(0, -1)) assert.equal(valueOf(layout, 'st'), cells.st);
});

test('Fields_OfTwoChannels_AreOfTheirChannel', () => {
  const cycles = cyclesOf('fs-36-28', '--cycles', '60', '--motion', 'random');
  for (const { cells, layout } of cycles.slice(0, -1)) {
    assert.equal(valueOf(layout, 'pos'), cells.position);
    assert.equal(valueOf(layout, 'pos.2'), cells.position2);
    assert.equal(valueOf(layout, 'lc.2'), cells.lc2);
    assert.equal(valueOf(layout, 'nE.2'), cells.nE2);
    assert.equal(partOf(layout, 'nE.2').kind, 'flag');
  }
});

test('Parts_OfAnyCycle_FollowOneAnother', () => {
  let laidOut = 0;
  for (const { cycle, layout } of cyclesOf('pos26,nE,nW,crc6', '--cycles', '400', '--cable', '30m', ...faults)) {
    if (layout === undefined) continue;
    laidOut += 1;
    let before = BigInt(cycle.time);
    for (const part of layout.parts) {
      assert.ok(part.from >= before && part.to > part.from, `cycle ${cycle.number}: ${part.texts[0]}`);
      before = part.to;
    }
  }
  assert.ok(laidOut > 300, `${laidOut} cycles`);
});

test('Failures_OfAnyCycle_NameItsStatus', () => {
  const seen = new Set();
  for (const { cells, layout } of cyclesOf('pos26,nE,nW,crc6', '--cycles', '400', ...faults)) {
    if (layout === undefined) continue;
    const good = ['ok', 'unchecked'].includes(cells.status);
    assert.equal(layout.failures.length > 0, !good, cells.status);
    for (const { text } of layout.failures) assert.ok(text.startsWith(`${cells.status}: `), text);
    seen.add(cells.status);
  }
  for (const status of ['ok', 'crc', 'no_response', 'truncated']) assert.ok(seen.has(status), status);
});

test('Crc_WithAFlippedBit_SaysWhichFlipMendsIt', () => {
  const cycles = cyclesOf('pos26,nE,nW,crc6', '--cycles', '10', '--fault', 'flip@4,bit=7');
  const { layout } = cycles[4];
  const part = partOf(layout, 'crc');
  assert.ok(part.wrong);
  assert.match(part.texts[0], /^crc=0x[0-9A-F]+, expected 0x[0-9A-F]+$/);
  assert.equal(layout.failures[0].at, part.from);
  assert.match(layout.failures[0].text, /^crc: received .*; corrected by a flip of (.* or )?pos18\b/);
  assert.ok(layout.samples.find(({ name }) => name === 'pos18').mends);
});

test('Crc_OfTheSecondChannel_IsNamed', () => {
  const { cycle, layout } = cyclesOf('fs-36-28', '--cycles', '10', '--fault', 'flip@4,bit=70')[4];
  assert.deepEqual(cycle.checks.map(({ right }) => right), [true, false]);
  assert.equal(layout.failures.length, 1);
  assert.match(layout.failures[0].text, /^crc: channel 2: received 0x[0-9A-F]+, expected 0x[0-9A-F]+; corrected by a flip of .*\.2\b/);
  assert.equal(layout.failures[0].at, partOf(layout, 'crc.2').from);
});

test('Eye_WithoutJitter_IsHalfAPeriodWideOnBothSides', () => {
  const options = ['--cycles', '50', '--clock', '1MHz', '--cable', '20m'];
  biss.run(['simulate', '-f', 'pos26,nE,nW,crc6', '-o', 'test.vcd', ...options]);
  const { session } = biss.open(['test.vcd', '-f', 'pos26,nE,nW,crc6']);
  while (session.advance(100).more);
  const eye = eyeOf(session, { from: 0n, to: BigInt(session.about().endTime), cycles: 20, bins: 100 });
  assert.equal(eye.of, 50);
  assert.equal(eye.rows.length, 20);
  assert.ok(Math.abs(eye.period - 1e6) < 1e3, `${eye.period}`);
  for (const side of [eye.before, eye.after]) assert.ok(Math.abs(side - 5e5) < 5e4, `${side}`);
  eye.margins.forEach((margin) => assert.ok(Math.abs(margin - 5e5) < 5e4, `${margin}`));
  session.close();
});
