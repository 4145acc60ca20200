// The conditions of search and filter, on rows of the core, against the same conditions over the cells
// of the CSV.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { before, describe, it } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { load } from './typescript.mjs';

const here = path.dirname(fileURLToPath(import.meta.url));
const core = path.resolve(process.env.BISS_WASM ?? path.join(here, '../../build-wasm/wasm'));
const { loadBiss } = await import(pathToFileURL(path.join(core, 'biss.mjs')));
const { findRow, findRows } = await load('core/matching.ts');
const { splitArguments, decodeArguments, verbFurther } = await load('core/arguments.ts');

let session;
let cells;
let names;

before(async () => {
  const biss = await loadBiss({ wasmBinary: fs.readFileSync(path.join(core, 'biss_core.wasm')) });
  const made = biss.run(['simulate', '-f', 'fs-36-28', '--cycles', '500', '--clock', '5MHz', '--seed', '7', '--fault', 'flip:0.1',
    '--fault', 'no_answer:0.05', '--fault', 'nE:0.05', '--fault', 'nW:0.05', '--jitter', '2ns', '--cable', '20m', '-o', 'line.vcd']);
  assert.equal(made.status, 0, made.err);
  ({ session } = biss.open(['line.vcd', '-f', 'fs-36-28', '--velocity']));
  while (session.advance(50).more);
  cells = session.cells(0, session.rowCount);
  names = session.columns.map((column) => column.name);
});

const cell = (row, name) => row[names.indexOf(name)];

function rowsWhere(test) {
  return cells.flatMap((row, i) => (test((name) => cell(row, name)) ? [i] : []));
}

describe('conditions', () => {
  const middle = () => cell(cells[250], 'position');
  for (const [name, condition, test] of [
    ['Status', () => 'crc', (of) => of('status') === 'crc'],
    ['StatusInCapitals', () => 'CRC', (of) => of('status') === 'crc'],
    ['NotOk', () => 'not ok', (of) => of('status') !== 'ok'],
    ['Flag', () => 'nW=0', (of) => of('nW') === '0'],
    ['FlagByName', () => 'nE', (of) => of('nE') === '0'],
    ['LargeInteger', () => `position > ${middle()}`, (of) => of('position') !== '' && BigInt(of('position')) > BigInt(middle())],
    ['Hexadecimal', () => `position = 0x${BigInt(middle()).toString(16)}`, (of) => of('position') === middle()],
    ['Fraction', () => 'ack_ns <= 3200.5', (of) => of('ack_ns') !== '' && Number(of('ack_ns')) <= 3200.5],
    ['Microseconds', () => 'ack > 3.199us', (of) => of('ack_ns') !== '' && Number(of('ack_ns')) > 3199],
    ['Time', () => 'time >= 1ms and time < 2.5ms', (of) => Number(of('time_ns')) >= 1e6 && Number(of('time_ns')) < 2.5e6],
    ['Rate', () => 'clock > 4.9MHz and cycle < 99', (of) => of('clock_hz') !== '' && Number(of('cycle')) < 99],
    ['Real', () => 'velocity > 0', (of) => Number(of('velocity_counts_s') || NaN) > 0],
    ['Verdict', () => 'cpw_crc or spw_crc', (of) => ['cpw_crc', 'spw_crc'].includes(of('safety'))],
    ['Bits', () => `raw = ${cell(cells[3], 'raw')}`, (of) => of('raw') === cell(cells[3], 'raw')],
    ['Brackets', () => '(crc or nE=0) and not (cycle < 100)', (of) => (of('status') === 'crc' || of('nE') === '0') && Number(of('cycle')) >= 100],
    ['Row', () => '120', (of) => of('cycle') === '120'],
  ]) {
    it(`${name}_FindsTheRowsOfTheCells`, () => {
      const expected = rowsWhere(test);
      assert.ok(expected.length > 0 && expected.length < cells.length, `${expected.length} rows`);
      assert.deepEqual([...findRows(session, condition(), 10_000)], expected);
    });
  }

  it('Error_FindsTheRowsOfOnlyErrors', async () => {
    const biss = await loadBiss({ wasmBinary: fs.readFileSync(path.join(core, 'biss_core.wasm')) });
    for (const [format, ...faults] of [['fs-36-28', 'flip:0.1', 'repeat:0.05', 'cut:0.02'], ['resolute-26', 'nE:0.1', 'lost_clock:0.1', 'glitch_slo:0.1']]) {
      biss.run(['simulate', '-f', format, '--cycles', '400', '--seed', '9', ...faults.flatMap((fault) => ['--fault', fault]), '-o', 'some.vcd']);
      const { out } = biss.run(['decode', 'some.vcd', '-f', format, '--only-errors', '--columns', 'cycle', '--to', 'csv']);
      const expected = new TextDecoder().decode(out).trim().split('\n').slice(1).map(Number);
      const { session: other } = biss.open(['some.vcd', '-f', format]);
      while (other.advance(50).more);
      assert.ok(expected.length > 20);
      assert.deepEqual([...findRows(other, 'error', 10_000)], expected, format);
      other.close();
    }
  });

  it('NextAndPrevious_GoThroughTheSameRows', () => {
    const all = [...findRows(session, 'crc', 10_000)];
    const forward = [];
    for (let row = findRow(session, 'crc', -1, 1); row !== undefined; row = findRow(session, 'crc', row, 1)) forward.push(row);
    const back = [];
    for (let row = findRow(session, 'crc', session.rowCount, -1); row !== undefined; row = findRow(session, 'crc', row, -1)) back.unshift(row);
    assert.deepEqual(forward, all);
    assert.deepEqual(back, all);
  });

  for (const [text, message] of [
    ['', 'a condition is missing'],
    ['crx', '"crx" is not a status'],
    ['position', '"position" is not a status'],
    ['nothing = 3', '"nothing" is not a column'],
    ['position >', 'a value is missing'],
    ['position > many', '"many" is not a number'],
    ['(crc', 'a ")" is missing'],
    ['crc stop_bit', 'join with and, or'],
    ['ack > 3MHz', 'does not have this unit'],
    ['position > 3ns', 'does not have this unit'],
    ['status > crc', 'compare it with = or !='],
    ['crc and', 'a condition is missing'],
    ['= 3', '"=" is not expected'],
  ]) {
    it(`Wrong_${text.replace(/\W+/g, '_')}_IsNamed`, () => {
      assert.throws(() => findRows(session, text, 10), (error) => error.message.includes(message));
    });
  }
});

describe('arguments', () => {
  const settings = { format: 'resolute-26', ma: '', slo: 'D1', invertMa: true, invertSlo: false, units: 'counts', further: '' };

  it('Options_AreSplitAsByAShell', () => {
    assert.deepEqual(splitArguments(`--a 1  --b='two words' "three \\ four" ''`), ['--a', '1', '--b=two words', 'three \\ four', '']);
  });

  it('Decode_TriesTheScaleFirst', () => {
    const [first, second, last] = decodeArguments(['x.vcd'], { ...settings, units: 'deg' });
    const base = ['x.vcd', '-f', 'resolute-26', '--slo', 'D1', '--invert-ma'];
    assert.deepEqual(first, [...base, '--velocity', '--scale', 'deg']);
    assert.deepEqual(second, [...base, '--velocity']);
    assert.deepEqual(last, base);
  });

  const furtherOf = (verb, further) => verbFurther(verb, { ...settings, further });

  it('OtherVerbs_GetTheOptionsByWhichTheyJudge', () => {
    const lines = '--raw-rate 100MHz --unwrap --threshold=1.2V --scale deg --each --columns raw,cycle --latch';
    const kept = ['--raw-rate', '100MHz', '--threshold=1.2V', '--each'];
    assert.deepEqual(furtherOf('explain', lines), [...kept, '--latch']);
    assert.deepEqual(furtherOf('identify', lines), kept);
    const timing = ['--ack-max', '16us', '--ack-clocks=3', '--timeout', 'static:20us', '--release', '1us', '--clock-max', '10MHz',
      '--cycle-min', '31us'];
    for (const verb of ['explain', 'identify', 'check', 'registers']) {
      assert.deepEqual(furtherOf(verb, `--fail-on crc ${timing.join(' ')} --no-compensation --threads 2`),
        verb === 'explain' || verb === 'check' ? [...timing, '--no-compensation'] : timing);
    }
  });

  it('OptionThatAVerbDoesNotHave_GoesToItAndIsRefusedByName', () => {
    assert.deepEqual(furtherOf('registers', '--unwrap --since 1ms --until=-2ms'), ['--since', '1ms', '--until=-2ms']);
    assert.deepEqual(furtherOf('check', '--threshold -1.5V --no-such 3'), ['--threshold', '-1.5V', '--no-such', '3']);
  });

  it('EveryOptionOfDecode_IsTakenByAPanelOrRefusedOrForRowsAlone', async () => {
    const biss = await loadBiss({ wasmBinary: fs.readFileSync(path.join(core, 'biss_core.wasm')) });
    const optionsOf = (verb) => {
      const { out } = biss.run([verb, '--help']);
      return new Set(new TextDecoder().decode(out).match(/(?<=^ +(-., )?)--[a-z-]+/gm));
    };
    // The panel has its own.
    const own = ['--help', '--output', '--to'];
    // A log of words takes the place of a capture, which the page has.
    const words = ['--words', '--digits', '--bit-order', '--byte-order', '--invert', '--first-bit', '--bits', '--payload'];
    for (const verb of ['explain', 'identify', 'check', 'registers']) {
      const refused = verb === 'registers' ? ['--since', '--until', ...words] : words;
      const has = optionsOf(verb);
      assert.ok(has.has('--ack-max'));
      for (const option of optionsOf('decode')) {
        const goes = furtherOf(verb, option).length > 0;
        const wanted = has.has(option) ? !own.includes(option) : refused.includes(option);
        assert.equal(goes, wanted, `${verb} ${option}`);
      }
    }
  });
});
