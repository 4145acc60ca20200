// The page as `biss view` serves it.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, describe, it } from 'node:test';
import { cells, choose, failure } from './actions.mjs';
import { command, makeFolder } from './command.mjs';
import { browse, pageFile, readToEnd } from './page.mjs';

let browser;
let folder;
const servers = [];
before(async () => {
  browser = await browse();
  folder = makeFolder();
  folder.make(['simulate', '-f', 'resolute-26', '--cycles', '300', '--fault', 'flip@7', '-o', 'line.vcd']);
});
after(async () => {
  servers.forEach((server) => server.kill('SIGKILL'));
  await browser.close();
  folder.remove();
});

/** Starts the server; the address that it prints. */
async function serve(args) {
  const server = spawn(command, ['view', ...args, '--no-open', '--page', pageFile], { stdio: ['ignore', 'pipe', 'inherit'] });
  servers.push(server);
  const address = await new Promise((resolve, reject) => {
    server.stdout.once('data', (text) => resolve(String(text).trim()));
    server.once('exit', (status) => reject(new Error(`biss view ended with ${status}`)));
  });
  const end = () => new Promise((resolve) => {
    server.once('exit', (status, signal) => resolve(signal ?? status));
    server.kill('SIGTERM');
  });
  return { address, end };
}

async function open(address) {
  const page = await browser.newPage();
  const errors = [];
  const requests = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('request', (request) => requests.push(request.url()));
  await page.goto(address);
  return { page, errors, requests };
}

/** Rows of the command, as the page asks for them. */
function rowsOf(name, more = []) {
  return folder.make(['decode', name, '-f', 'resolute-26', '--velocity', ...more, '--to', 'csv']).out.trim().split('\n').slice(1);
}

async function assertRows(page, rows) {
  await page.locator('.status-bar', { hasText: `${rows.length} request cycles` }).waitFor({ timeout: 30_000 });
  for (const row of [0, 7, rows.length - 1].filter((each) => each < rows.length)) {
    await page.locator('#table').press('Home');
    await page.locator('body').press('/');
    await page.locator('#search').fill(String(row));
    await page.keyboard.press('Enter');
    await page.locator(`#row-${row} [role=gridcell]`).first().waitFor();
    assert.deepEqual((await cells(page, row)).join(','), rows[row]);
  }
}

describe('a capture that is served', () => {
  it('Capture_IsShownAsByTheCommandAndNothingElseIsAsked', async () => {
    const { address, end } = await serve([folder.at('line.vcd'), '-f', 'resolute-26', '--unwrap', '--no-compensation']);
    const { page, errors, requests } = await open(address);
    await readToEnd(page);
    assert.equal(await page.locator('#format').inputValue(), 'resolute-26');
    assert.equal(await page.locator('.further input').inputValue(), '--no-compensation --unwrap');
    await assertRows(page, rowsOf('line.vcd', ['--unwrap', '--no-compensation']));
    assert.deepEqual(requests.filter((url) => !url.startsWith(address) && !/^(blob|data):/.test(url)), []);
    assert.deepEqual(errors, []);
    assert.equal(await end(), 0);
    await page.locator('.message', { hasText: 'biss view has ended. The data so far stay here.' }).waitFor();
    await page.close();
  });

  it('FileThatIsReplaced_IsNamed', async () => {
    fs.copyFileSync(folder.at('line.vcd'), folder.at('replaced.vcd'));
    const { address, end } = await serve([folder.at('replaced.vcd')]);
    const { page } = await open(address);
    await readToEnd(page);
    fs.copyFileSync(folder.at('line.vcd'), folder.at('other.vcd'));
    fs.renameSync(folder.at('other.vcd'), folder.at('replaced.vcd'));
    assert.match(await failure(page), /replaced\.vcd: was replaced by another file/);
    await end();
    await page.close();
  });

  it('FileOfTheUser_TakesThePlaceOfTheServedOne', async () => {
    const { address, end } = await serve([folder.at('line.vcd')]);
    const { page } = await open(address);
    await readToEnd(page);
    folder.make(['simulate', '-f', 'resolute-26', '--cycles', '40', '-o', 'own.vcd']);
    await choose(page, folder.at('own.vcd'));
    await page.locator('.status-bar', { hasText: '40 request cycles' }).waitFor();
    await end();
    await page.waitForTimeout(1_000);
    assert.equal(await page.locator('.message', { hasText: 'biss view has ended' }).count(), 0);
    await page.close();
  });
});

describe('a capture that grows', () => {
  it('Rows_FollowTheFile', { timeout: 120_000 }, async () => {
    const whole = fs.readFileSync(folder.at('line.vcd'));
    const growing = folder.at('growing.vcd');
    fs.writeFileSync(growing, '');
    const { address, end } = await serve([growing, '-f', 'resolute-26', '--follow']);
    const { page, errors } = await open(address);
    // Within the header, within lines, at the end of one, and all.
    const inLine = (part) => whole.indexOf('\n', Math.floor(whole.length * part)) - 2;
    const cuts = [40, inLine(0.2), inLine(0.5), whole.indexOf('\n', whole.length * 0.7) + 1, whole.length];
    let written = 0;
    for (const cut of cuts) {
      fs.appendFileSync(growing, whole.subarray(written, cut));
      written = cut;
      if (cut === 40) {
        await page.waitForTimeout(700);
        continue;
      }
      fs.writeFileSync(folder.at('part.vcd'), whole.subarray(0, whole.lastIndexOf('\n', cut - 1) + 1));
      await assertRows(page, rowsOf('part.vcd'));
      assert.equal(await page.locator('.message.failed').count(), 0);
    }
    await page.locator('.status-bar', { hasText: 'following the file' }).waitFor();
    fs.truncateSync(growing, 1000);
    assert.match(await failure(page), /growing\.vcd: has shrunk from \d+ to 1000 bytes/);
    assert.deepEqual(errors, []);
    assert.equal(await end(), 0);
    await page.close();
  });

  it('SettingsOfTheUser_StayWhileItGrows', { timeout: 60_000 }, async () => {
    const whole = fs.readFileSync(folder.at('line.vcd'));
    const growing = folder.at('settings.vcd');
    const half = whole.indexOf('\n', whole.length / 2) + 1;
    fs.writeFileSync(growing, whole.subarray(0, half));
    const { address, end } = await serve([growing, '-f', 'resolute-26', '--follow']);
    const { page } = await open(address);
    await readToEnd(page);
    await page.locator('#row-0').click();
    await page.getByRole('button', { name: 'Errors' }).click();
    fs.appendFileSync(growing, whole.subarray(half));
    await page.locator('.status-bar', { hasText: '300 request cycles' }).waitFor();
    await page.locator('#row-7').waitFor();
    assert.equal(await page.getByRole('button', { name: 'Errors' }).getAttribute('aria-pressed'), 'true');
    await end();
    await page.close();
  });
});

it('FormatsThatAreWholeOnlyAtTheirEnd_AreNamed', () => {
  folder.make(['convert', 'line.vcd', 'line.sr', '--rate', '100MHz']);
  const { status, err } = folder.run(['view', path.basename('line.sr'), '--follow', '--no-open', '--page', pageFile]);
  assert.equal(status, 3);
  assert.match(err, /^biss: line\.sr: cannot be followed while it grows: .* is at its end; leave out --follow$/m);
});
