// A page that carries its capture, as a report does, and one whose server gives it in pieces.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import http from 'node:http';
import { before, describe, it } from 'node:test';
import { pathToFileURL } from 'node:url';
import { gzipSync } from 'node:zlib';
import { cells, selected } from './actions.mjs';
import { testFolder } from './command.mjs';
import { pageFile, readToEnd, testBrowser } from './page.mjs';

const browser = testBrowser();
const folder = testFolder();
let capture;
let rows;
before(() => {
  folder.make(['simulate', '-f', 'resolute-26', '--cycles', '900', '-o', 'line.vcd']);
  rows = folder.make(['decode', 'line.vcd', '-f', 'resolute-26', '--velocity', '--to', 'csv']).out.split('\n');
  capture = fs.readFileSync(folder.at('line.vcd'));
});

function pageWith(attributes, content) {
  const element = `<script type="text/plain" id="biss-capture" data-name="line.vcd" ${attributes}>${content}</script>`;
  return fs.readFileSync(pageFile, 'utf8').replace('<script type="text/plain" id="biss-core">', (core) => element + core);
}

async function assertRows(page, row) {
  await readToEnd(page);
  assert.equal(await selected(page), row);
  await page.locator(`#row-${row} .good`).waitFor();
  assert.deepEqual(await cells(page, row), rows[row + 1].split(','));
}

describe('a capture of the page itself', () => {
  it('CaptureInThePage_IsOpenedWithItsView', async () => {
    const html = pageWith('data-view="format=resolute-26&amp;row=700"', gzipSync(capture).toString('base64'));
    fs.writeFileSync(folder.at('report.html'), html);
    const page = await browser.newPage();
    page.setDefaultNavigationTimeout(120_000);
    await page.goto(pathToFileURL(folder.at('report.html')).href);
    // Loaded means shown, for programs that take a picture of it.
    assert.match(await page.locator('.status-bar').innerText(), /^Read to the end/);
    await assertRows(page, 700);
    await page.close();
  });

  it('CaptureOfTheServer_IsReadInPieces', async () => {
    const html = pageWith(`data-address="capture" data-size="${capture.length}" data-view="format=resolute-26&amp;row=7"`, '');
    const pieces = [];
    const server = http.createServer((request, response) => {
      const [, from, to] = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? '') ?? [];
      if (request.url !== '/capture') response.setHeader('Content-Type', 'text/html').end(html);
      else {
        pieces.push(Number(to) + 1 - Number(from));
        response.writeHead(206).end(capture.subarray(Number(from), Number(to) + 1));
      }
    });
    await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
    const page = await browser.newPage();
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    await assertRows(page, 7);
    assert.ok(pieces.length > 0 && Math.max(...pieces) <= 8 << 20, `${pieces}`);
    await page.close();
    server.close();
  });
});
