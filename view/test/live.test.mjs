// A line that is read now, as `biss view` serves it: an emulated encoder, its faults and its end.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import { after, it } from 'node:test';
import { command, testFolder } from './command.mjs';
import { audit, pageFile, testBrowser } from './page.mjs';

const browser = testBrowser();
const folder = testFolder();
const programs = [];
after(() => programs.forEach((program) => program.kill('SIGKILL')));

/** Starts the command there; the first line that it prints. */
function start(args) {
  const program = spawn(command, args, { stdio: ['ignore', 'pipe', 'inherit'] });
  programs.push(program);
  return new Promise((resolve, reject) => {
    program.stdout.once('data', (text) => resolve({ program, line: String(text).trim() }));
    program.once('exit', (status) => reject(new Error(`it ended with ${status}`)));
  });
}

const hasFuse = folder.run(['emulate', '-f', 'resolute-26', '--', 'true']).status === 0;

it('LiveLine_ShowsPositionFaultsAndTheEnd', { skip: !hasFuse && 'FUSE cannot be mounted here' }, async () => {
  const device = ['-f', 'resolute-26', '--motion', 'constant', '--at', folder.at('spidev'), '--ctl', folder.at('ctl')];
  const { program: encoder } = await start(['emulate', ...device]);
  const ask = (text) => folder.make(['emulate', 'ctl', folder.at('ctl'), text]);
  ask('at 4711');
  const { program: server, line } = await start(
    ['view', '--port', `spi:${folder.at('spidev')}`, '-f', 'resolute-26', '--no-open', '--page', pageFile]);
  const page = await browser.newPage();
  const errors = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(line);
  const shown = (selector, hasText) => page.locator(selector, { hasText }).waitFor({ timeout: 30_000 });
  await shown('.live-position', /^4711$/);
  await audit(page, 'a live line');
  ask('move 100');
  await shown('.live-position', /^4811$/);
  ask('fault flip@next,bit=3');
  await shown('.live table', /crc1/);
  ask('unplug');
  await shown('.live p', 'no_response');
  ask('plug');
  await shown('.live-position', /^4811$/);

  const download = page.waitForEvent('download');
  await page.getByRole('button', { name: 'Keep the last 10 seconds' }).click();
  await (await download).saveAs(folder.at('live.log'));
  const { out } = folder.make(['decode', '--words', 'live.log', '-f', 'resolute-26', '--to', 'csv']);
  assert.match(out, /,crc,/);
  assert.match(out, /,ok,4811,/);

  encoder.kill('SIGKILL');
  await shown('.live-notice', 'The port: a transfer failed: gone');
  server.removeAllListeners('exit');
  server.kill('SIGTERM');
  assert.equal(await new Promise((resolve) => { server.once('exit', resolve); }), 0);
  await shown('.live-notice', 'biss view has ended, or does not answer');
  assert.deepEqual(errors, []);
  fs.rmSync(folder.at('ctl'), { force: true });
  folder.run(['emulate', 'ctl', folder.at('ctl'), 'status']);
  spawn('fusermount3', ['-q', '-u', '-z', folder.at('spidev')]);
  await page.close();
});
