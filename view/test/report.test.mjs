// Pages that `biss report` writes: what they show, against the command and the whole capture.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { after, before, describe, it } from 'node:test';
import { pathToFileURL } from 'node:url';
import { cells } from './actions.mjs';
import { makeFolder } from './command.mjs';
import { browse, pageFile, readToEnd } from './page.mjs';

const format = 'pos12,nE,nW,crc6';
let browser;
let folder;
let rows;
before(async () => {
  browser = await browse();
  folder = makeFolder();
  folder.make(['simulate', '-f', format, '--cycles', '24000', '--seed', '5', '--fault', 'flip:0.01', '-o', 'line.vcd']);
  folder.make(['simulate', '-f', format, '--cycles', '50', '-o', 'small.vcd']);
  rows = folder.make(['decode', 'line.vcd', '-f', format, '--velocity', '--to', 'csv']).out.trimEnd().split('\n').slice(1);
  for (const name of ['line', 'small']) {
    folder.make(['report', `${name}.vcd`, '-f', format, '--page', pageFile, '-o', `${name}.html`]);
  }
});
after(async () => {
  await browser.close();
  folder.remove();
});

async function open(name, panel = '') {
  const page = await browser.newPage();
  const errors = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('console', (message) => { if (message.type() === 'error') errors.push(message.text()); });
  await page.goto(pathToFileURL(folder.at(name)).href);
  await readToEnd(page);
  if (panel !== '') await page.locator(`#tab-${panel}`).click();
  return { page, errors };
}

async function bar(page) {
  await page.locator('.report-bar').waitFor();
  return page.locator('.report-bar').textContent();
}

describe('a report with a part of the capture', () => {
  it('RowsOfThePart_AreThoseOfTheWhole', async () => {
    const { page, errors } = await open('line.html');
    const failed = rows.filter((row) => row.split(',')[2] !== 'ok' && !/cut_/.test(row));
    assert.ok(failed.length > 50);
    const shown = Number(/(\d+) rows/.exec(await page.locator('.filter-bar').textContent())[1]);
    assert.ok(shown > 100 + failed.length && shown < rows.length / 2, `${shown}`);
    const numbers = new Set();
    for (let row = 0; row < shown; row += 1) {
      if (row % 7 !== 0 && row > 120) continue;
      const found = await readRow(page, row);
      assert.deepEqual(found, rows[Number(found[0])].split(','));
      numbers.add(found[0]);
    }
    assert.ok(numbers.size > 100);
    assert.deepEqual(errors, []);
    await page.close();
  });

  it('Bar_SaysWhatIsInThePage', async () => {
    const { page } = await open('line.html');
    const failed = rows.filter((row) => row.split(',')[2] !== 'ok' && !/cut_/.test(row)).length;
    const text = await bar(page);
    assert.match(text, /of 24000 request cycles/);
    assert.match(text, new RegExp(`All ${failed} failed cycles are in it`));
    await page.close();
  });

  it('SummaryAndExplain_AreThoseOfTheWhole', async () => {
    const { page } = await open('line.html', 'summary');
    await page.locator('.panel', { hasText: '24000 request cycles' }).waitFor();
    await page.locator('#tab-explain').click();
    const cause = JSON.parse(folder.make(['explain', 'line.vcd', '-f', format, '--to', 'jsonl']).out.split('\n')[0]);
    await page.locator('.panel .causes', { hasText: cause.evidence.split('; ')[0] }).waitFor();
    await page.close();
  });

  it('Check_OfEachLimitCarried_IsThatOfTheWhole', async () => {
    const { page } = await open('line.html', 'check');
    const limits = page.getByLabel('Against');
    assert.deepEqual(await limits.locator('option').evaluateAll((all) => all.map(({ value }) => value)), ['biss-c', 'renishaw']);
    for (const against of ['renishaw', 'biss-c']) {
      const { out } = folder.run(['check', 'line.vcd', '-f', format, '--against', against, '--to', 'jsonl']);
      const judged = out.trimEnd().split('\n').map((line) => JSON.parse(line)).filter(({ verdict }) => verdict !== 'not_judged');
      await limits.selectOption(against);
      await page.waitForFunction((count) => document.querySelectorAll('.rules tbody tr').length === count, judged.length);
      const shown = await page.locator('.rules tbody tr').evaluateAll((all) =>
        Object.fromEntries(all.map((row) => [row.children[1].textContent, row.children[7].textContent])));
      for (const { rule, cases } of judged) assert.equal(shown[rule], `${cases}`, `${against} ${rule}`);
    }
    await page.close();
  });

  it('Waveform_NamesCyclesByTheirNumbersInTheWhole', async () => {
    const { page } = await open('line.html');
    const failed = rows.filter((row) => row.split(',')[2] === 'crc').map((row) => row.split(',')[0]);
    const number = failed.at(-1);
    await page.locator('#search').fill(`cycle = ${number}`);
    await page.locator('#search').press('Enter');
    await page.locator('.row.selected', { hasText: number }).waitFor();
    await page.locator('.wave-picture').focus();
    await page.keyboard.press('Enter');
    await page.locator(`.wave-picture canvas[aria-label*="Cycle ${number} is selected"]`).waitFor();
    await page.locator(`.wave-picture canvas[aria-label*="${number} crc"]`).waitFor();
    await page.close();
  });

  it('AccessesToRegisters_AreThoseOfTheWhole', async () => {
    folder.make(['simulate', '-f', format, '--cycles', '24000', '--access', 'read:0x42@50', '--access', 'read:0x44,2@20000',
      '-o', 'control.vcd']);
    folder.make(['report', 'control.vcd', '-f', format, '--page', pageFile, '-o', 'control.html']);
    const expected = folder.make(['registers', 'control.vcd', '-f', format, '--to', 'jsonl']).out.trimEnd().split('\n')
      .map((line) => JSON.parse(line));
    const { page, errors } = await open('control.html', 'eds');
    const accesses = page.locator('[aria-label=Accesses] tbody tr');
    await accesses.first().waitFor();
    const shown = await accesses.evaluateAll((all) => all.map((row) => [...row.children].map((cell) => cell.textContent)));
    assert.deepEqual(shown.map(([cycle, , access, address, , , outcome]) => [Number(cycle), access, address, outcome]),
      expected.map(({ cycle, access, address, outcome }) => [cycle, access, address, outcome]));
    await accesses.first().getByRole('button').click();
    await page.locator('.row.selected', { hasText: `${expected[0].cycle}` }).waitFor();
    await accesses.last().getByRole('button').click();
    await page.locator('.message', { hasText: `Cycle ${expected.at(-1).cycle} is not in this report.` }).waitFor();
    assert.deepEqual(errors, []);
    await page.close();
  });

  it('OtherFormat_IsSaidToBeOfThePart', async () => {
    const { page } = await open('line.html');
    await page.locator('#format').fill('none');
    await page.locator('#format').press('Enter');
    await page.locator('.report-bar', { hasText: 'other settings' }).waitFor();
    await page.close();
  });

  it('Print_HasFailedCyclesAndSummary', async () => {
    const { page } = await open('line.html');
    await page.locator('.print').waitFor({ state: 'attached' });
    await page.emulateMedia({ media: 'print' });
    await page.locator('.print h2', { hasText: 'Failed cycles' }).waitFor();
    const text = await page.locator('.print').textContent();
    assert.match(text, /24000 request cycles/);
    assert.equal(await page.locator('.app').isVisible(), false);
    assert.ok((await page.locator('.print svg').count()) >= 4);
    await page.close();
  });
});

describe('a report of BiSS Safety', () => {
  it('VerdictsThatDependOnOtherCycles_AreThoseOfTheWhole', async () => {
    folder.make(['simulate', '-f', 'rsm', '--cycles', '8000', '--fault', 'flip:0.003', '--fault', 'repeat:0.003', '-o', 'safe.vcd']);
    folder.make(['report', 'safe.vcd', '-f', 'rsm', '--page', pageFile, '-o', 'safe.html']);
    const decoded = folder.make(['decode', 'safe.vcd', '-f', 'rsm', '--velocity', '--to', 'csv']).out.trimEnd().split('\n');
    const safety = decoded[0].split(',').indexOf('safety');
    const { page } = await open('safe.html');
    await page.locator('.filter-bar button', { hasText: 'Errors' }).click();
    const failed = decoded.slice(1).filter((row) => !['ok', 'cut_start', 'cut_end'].includes(row.split(',')[2]));
    await page.locator('.filter-bar', { hasText: /\d+ of \d+ rows/ }).waitFor();
    await page.locator('.row .bad').first().waitFor();
    const shown = await page.locator('.table .row').evaluateAll((all) =>
      all.map((row) => [...row.children].map((cell) => cell.textContent)));
    assert.ok(failed.length > 10 && shown.length > 5);
    for (const found of shown) assert.deepEqual(found, decoded[Number(found[0]) + 1].split(','));
    assert.ok(shown.some((found) => found[safety] !== 'safe'));
    await page.close();
  });
});

async function readRow(page, row) {
  await page.locator('#table').evaluate((table, top) => { table.scrollTop = top; }, Math.max(0, row - 3) * 24);
  await page.locator(`#row-${row} .text`).first().filter({ hasText: /\w/ }).waitFor();
  return cells(page, row);
}

describe('a report with the whole capture', () => {
  it('SmallCapture_IsReadAsAnyOther', async () => {
    const { page, errors } = await open('small.html');
    assert.equal(await page.locator('.report-bar').count(), 0);
    const expected = folder.make(['decode', 'small.vcd', '-f', format, '--velocity', '--to', 'csv']).out.split('\n');
    assert.deepEqual(await readRow(page, 7), expected[8].split(','));
    assert.deepEqual(errors, []);
    await page.close();
  });

  it('HostileName_IsText', async () => {
    const name = '"><img src=x onerror=alert(1)>.vcd';
    fs.copyFileSync(folder.at('small.vcd'), folder.at(name));
    folder.make(['report', name, '-f', format, '--page', pageFile, '-o', 'hostile.html']);
    const { page, errors } = await open('hostile.html');
    assert.equal(await page.locator('img').count(), 0);
    assert.match(await page.locator('.file').textContent(), /onerror/);
    assert.deepEqual(errors, []);
    await page.close();
  });
});
