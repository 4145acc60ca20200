// The numbers of the page are those of the command: whole tables, cell by cell, and its messages for
// hostile files. BISS_CAPTURES says how many captures, 27 by default; BISS_SEEDS a folder with files.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { describe, it } from 'node:test';
import { exported } from './actions.mjs';
import { testFolder } from './command.mjs';
import { assertNoRequests, readToEnd, testBrowser } from './page.mjs';

const wanted = Number(process.env.BISS_CAPTURES ?? 27);
const formats = ['resolute-26', 'mt12,st20,nE,nW,lc6,crc16', 'fs-36-28', 'pos18,nE,nW,crc6'];
const faults = [
  [],
  ['--fault', 'flip:0.05', '--fault', 'lost_clock:0.02'],
  ['--fault', 'slo_low:0.05', '--fault', 'burst:0.05', '--cable', '20m', '--jitter', '20ns'],
  ['--fault', 'glitch_slo:0.05', '--fault', 'cut:0.02', '--fault', 'no_answer:0.05'],
  ['--fault', 'nE:0.1', '--fault', 'delay_step:0.05', '--fault', 'glitch_ma:0.02'],
];

// Makes files of a kind from a VCD; returns their names.
const kinds = [
  (plain) => [plain],
  (plain) => one(plain, plain.replace('vcd', 'csv')),
  (plain) => one(plain, plain.replace('vcd', 'sr'), '--rate', '100MHz'),
  (plain) => outside('gzip', ['-kf', plain], `${plain}.gz`),
  (plain) => one(plain, `saleae_${plain.replace('vcd', 'csv')}`, '--to', 'saleae-csv'),
  (plain) => ['MA', 'SLO'].flatMap((line) => one(plain, plain.replace('.vcd', `_${line}.bin`), '--to', 'saleae-bin', '--line', line)),
  (plain) => one(plain, plain.replace('vcd', 'dsl'), '--rate', '100MHz'),
  (plain) => outside('vcd2fst', [plain, plain.replace('vcd', 'fst')], plain.replace('vcd', 'fst')),
  (plain) => one(plain, plain.replace('vcd', 'raw'), '--rate', '100MHz'),
];

const browser = testBrowser();
const folder = testFolder();

function one(plain, name, ...options) {
  folder.make(['convert', plain, name, ...options]);
  return [name];
}

function outside(program, args, name) {
  const ran = spawnSync(program, args, { cwd: folder.at('.') });
  assert.equal(ran.status, 0, `${program}: ${ran.error ?? ran.stderr}`);
  return [name];
}

// A capture with a format, faults and a kind of file that no other number below 180 has together.
function makeCapture(number) {
  const format = formats[number % formats.length];
  const fault = faults[number % faults.length];
  const plain = `capture${number}.vcd`;
  folder.make(['simulate', '-f', format, '--cycles', '120', '--motion', 'random', '--seed', `${number + 1}`,
    ...fault, '-o', plain]);
  const names = kinds[number % kinds.length](plain);
  const further = names[0].endsWith('.raw') ? ['--raw-rate', '100MHz'] : [];
  return { names, format: number % 2 === 0 ? format : '', further };
}

async function openInPage(page, { names, format, further }) {
  await page.locator('#choose-files').setInputFiles(names.map((name) => folder.at(name)));
  await page.waitForFunction((text) => document.querySelector('.file')?.textContent === text, names.join(', '));
  await page.getByLabel('Options').fill(further.join(' '));
  await page.getByLabel('Options').blur();
  await page.locator('#format').fill(format);
  await page.locator('#format').blur();
  await page.waitForFunction((wanted) => {
    const link = new URLSearchParams(location.hash.slice(1));
    return link.get('file') === wanted.file && (link.get('format') ?? '') === wanted.format
      && (link.get('further') ?? '') === wanted.further;
  }, { file: names.join(', '), format, further: further.join(' ') });
  await readToEnd(page);
}

// As the page reads it: with the velocity, where the format allows it.
function rowsOfCommand(args) {
  const ran = folder.run(['decode', ...args, '--velocity', '--to', 'csv']);
  return ran.status < 2 ? ran.out : folder.run(['decode', ...args, '--to', 'csv']).out;
}

describe('numbers', () => {
  it(`${wanted}Captures_EveryCellIsThatOfTheCommand`, { timeout: 1_800_000 }, async () => {
    const { page, requests, errors } = await browser.open();
    let rows = 0;
    for (let number = 0; number < wanted; number += 1) {
      const capture = makeCapture(number);
      await openInPage(page, capture);
      const { names, format, further } = capture;
      const name = names.join(', ');
      const expected = rowsOfCommand([...names, ...(format === '' ? [] : ['-f', format]), ...further]).split('\n');
      const shown = (await exported(page, /CSV of the table/)).toString().split('\n');
      assert.equal(shown.length, expected.length, name);
      expected.forEach((line, i) => assert.deepEqual(shown[i].split(','), line.split(','), `${name}, line ${i + 1}`));
      rows += expected.length - 2;
    }
    assert.ok(rows >= 100 * wanted, `${rows} rows`);
    assertNoRequests(requests);
    assert.deepEqual(errors, []);
    await page.context().close();
  });
});

// Folders of seeds, as fuzz/make_seeds makes them, and the ending that their files have.
const seedEndings = {
  vcd: 'vcd', event_csv: 'csv', sampled_csv: 'csv', pairs_text: 'csv', saleae: 'csv', saleae_analog: 'bin', saleae_binary: 'bin',
  sr: 'sr', dsl: 'dsl', session: 'sr', fst: 'fst', raw: 'raw', compressed: 'vcd.gz',
};
const seedsOfAFolder = Number(process.env.BISS_SEEDS_EACH ?? 64);

function seeds() {
  return Object.entries(seedEndings).flatMap(([folderName, ending]) => {
    const from = path.join(process.env.BISS_SEEDS, folderName);
    if (!fs.existsSync(from)) return [];
    return fs.readdirSync(from).slice(0, seedsOfAFolder).map((name) => {
      const own = `${folderName}_${name}.${ending}`;
      fs.copyFileSync(path.join(from, name), folder.at(own));
      return own;
    });
  });
}

// The errors of the command, without warnings and summary.
function errorsOf(text) {
  return text.split('\n').filter((line) => line.startsWith('biss: '));
}

async function errorsInPage(page, name) {
  await page.locator('#choose-files').setInputFiles(folder.at(name));
  await page.waitForFunction((wanted) => document.querySelector('.file')?.textContent === wanted
    && /^(Read to the end|Failed)/.test(document.querySelector('.status-bar')?.textContent ?? ''), name);
  const more = page.locator('.message button[aria-expanded=false]');
  if (await more.count() > 0) await more.click();
  return errorsOf((await page.locator('.message-text').allInnerTexts()).join('\n'));
}

describe('hostile files', () => {
  it('Seeds_GiveTheMessageOfTheCommandAndNoneStopsThePage', {
    skip: process.env.BISS_SEEDS === undefined && 'BISS_SEEDS is not set', timeout: 1_800_000,
  }, async () => {
    const { page, errors } = await browser.open();
    const names = seeds();
    for (const name of names) {
      const expected = folder.run(['decode', name]);
      const shown = await errorsInPage(page, name);
      if (expected.status >= 2) assert.equal(shown.at(-1), errorsOf(expected.err).at(-1), name);
    }
    assert.ok(names.length > 0);
    assert.deepEqual(errors, []);
    await page.context().close();
  });
});
