// What is tested at each change: files are opened, searched, zoomed and read by another format, and
// their numbers are the command's. All else is in the other files.
import assert from 'node:assert/strict';
import { describe, it } from 'node:test';
import { pathToFileURL } from 'node:url';
import { cells, choose, exported, selected } from './actions.mjs';
import { testFolder } from './command.mjs';
import { assertNoRequests, audit, pageFile, readToEnd, settled, testBrowser } from './page.mjs';

const format = 'resolute-26';
const browser = testBrowser();
const folder = testFolder();

function simulate(name, ...options) {
  folder.make(['simulate', '-f', format, '--cycles', '300', '--motion', 'random', ...options, '-o', name]);
}

function rowsOfCommand(name) {
  return folder.run(['decode', name, '-f', format, '--velocity', '--to', 'csv']).out.trimEnd().split('\n');
}

async function setFormat(page, text) {
  await page.locator('#format').fill(text);
  await page.keyboard.press('Enter');
}

describe('the page', () => {
  it('Vcd_IsReadSearchedZoomedAndAuditedWithoutARequest', async () => {
    simulate('line.vcd', '--fault', 'flip@40,bit=7', '--fault', 'no_answer@200');
    const { page, requests, errors } = await browser.open();
    await choose(page, folder.at('line.vcd'));
    await setFormat(page, format);
    await readToEnd(page);
    const rows = rowsOfCommand('line.vcd');
    assert.deepEqual((await exported(page, /CSV of the table/)).toString().trimEnd().split('\n'), rows);

    await page.locator('#search').fill('next crc');
    await page.keyboard.press('Enter');
    await page.locator('#row-40.selected').waitFor();
    assert.deepEqual(await cells(page, 40), rows[41].split(','));

    const picture = page.locator('.wave-picture');
    await picture.focus();
    await page.keyboard.press('Enter');
    await settled(page);
    const seen = await picture.locator('canvas').getAttribute('aria-label');
    assert.match(seen, /In the picture: cycles 39 to 40; failed: 40 crc\. Cycle 40 is selected/);
    await page.keyboard.press('+');
    await settled(page);
    assert.notEqual(await picture.locator('canvas').getAttribute('aria-label'), seen);

    await audit(page, 'a capture');
    await setFormat(page, 'pos32,crc6');
    await page.locator('#row-39 .bad').first().waitFor();
    assert.notEqual((await cells(page, 39))[2], 'ok');
    assertNoRequests(requests);
    assert.deepEqual(errors, []);
    await page.context().close();
  });

  it('Options_AreThoseOfTheTableInEveryPanel', async () => {
    simulate('late.vcd');
    const { page, errors } = await browser.open(`format=${format}&further=${encodeURIComponent('--ack-max 1us --unwrap')}`);
    await choose(page, folder.at('late.vcd'));
    await readToEnd(page);
    assert.equal((await cells(page, 7))[2], 'ack_range');
    const panel = page.locator('#panel');
    const words = (verb, ...more) => folder.run([verb, 'late.vcd', '--ack-max', '1us', '--to', 'jsonl', ...more]).out;
    await page.getByRole('tab', { name: 'Explain' }).click();
    const first = JSON.parse(words('explain', '-f', format).split('\n')[0]);
    assert.notEqual(first.cause, 'healthy');
    await panel.getByRole('heading', { name: first.cause }).waitFor();
    await page.getByRole('tab', { name: 'Check' }).click();
    const failed = words('check', '-f', format, '--against', 'biss-c').trimEnd().split('\n').map((line) => JSON.parse(line))
      .filter(({ verdict }) => verdict === 'fail').map(({ rule }) => rule);
    assert.ok(failed.length > 0);
    for (const rule of failed) await panel.getByRole('row').filter({ hasText: 'fail' }).filter({ hasText: rule }).first().waitFor();
    await page.getByLabel('Options').fill('--ack-max 1us --since 1ms');
    await page.keyboard.press('Enter');
    await page.getByRole('tab', { name: 'Explain' }).click();
    const later = JSON.parse(words('explain', '-f', format, '--since', '1ms').split('\n')[0]);
    await panel.getByRole('heading', { name: later.cause }).waitFor();
    assert.deepEqual(errors, []);
    await page.context().close();
  });

  it('SigrokSession_HasTheRowsOfTheCommand', async () => {
    simulate('samples.vcd');
    folder.make(['convert', 'samples.vcd', 'samples.sr', '--rate', '100MHz']);
    const { page, errors } = await browser.open(`format=${format}`);
    await choose(page, folder.at('samples.sr'));
    const shown = (await exported(page, /CSV of the table/)).toString().trimEnd().split('\n');
    assert.deepEqual(shown, rowsOfCommand('samples.sr'));
    assert.deepEqual(errors, []);
    await page.context().close();
  });

  it('Report_OpensFromAFolderWithItsCapture', async () => {
    simulate('sent.vcd', '--fault', 'flip@5');
    folder.make(['report', 'sent.vcd', '-f', format, '--page', pageFile, '-o', 'report.html']);
    const { page, errors } = await browser.open();
    await page.goto(pathToFileURL(folder.at('report.html')).href);
    await readToEnd(page);
    await page.locator('#table').press('e');
    assert.equal(await selected(page), 5);
    assert.deepEqual(await cells(page, 5), rowsOfCommand('sent.vcd')[6].split(','));
    assert.deepEqual(errors, []);
    await page.context().close();
  });
});
