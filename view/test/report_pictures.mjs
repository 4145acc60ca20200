// Reports of a small and of a large capture as they look in Chromium and Firefox and on A4: pictures in
// a folder, to be looked at, and how long the large one takes to open.
//
//     node report_pictures.mjs FOLDER [REPORT.html…]
import { execFile, execFileSync } from 'node:child_process';
import fs from 'node:fs';
import http from 'node:http';
import os from 'node:os';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { promisify } from 'node:util';
import { makeFolder } from './command.mjs';
import { browse, pageFile, readToEnd } from './page.mjs';

const [given = 'report-pictures', ...others] = process.argv.slice(2);
const output = path.resolve(given);
fs.mkdirSync(output, { recursive: true });
const size = { width: 1400, height: 900 };

function makeReports() {
  const folder = makeFolder();
  const faults = ['--fault', 'flip:0.004', '--fault', 'no_answer:0.001', '--jitter', '2ns'];
  const simulate = ['simulate', '-f', 'resolute-26', '--cable', '10m'];
  folder.make([...simulate, '--cycles', '60', '--fault', 'flip@7,bit=9', '-o', 'small.vcd']);
  folder.make([...simulate, '--cycles', '20000', ...faults, '-o', 'large.vcd']);
  const reports = ['small', 'large'].map((name) => {
    const report = path.join(output, `${name}.html`);
    folder.make(['report', `${name}.vcd`, '-f', 'resolute-26', '--page', pageFile, '-o', report]);
    return report;
  });
  folder.remove();
  return reports;
}

async function inChromium(browser, report, base) {
  const page = await browser.newPage({ viewport: size });
  const begin = performance.now();
  await page.goto(pathToFileURL(report).href);
  await readToEnd(page);
  console.log(`${path.basename(report)}: read to the end after ${Math.round(performance.now() - begin)} ms`);
  await page.locator('.print h2').last().waitFor({ state: 'attached' });
  await page.waitForTimeout(1500);
  await page.screenshot({ path: `${base}-chromium.png` });
  await page.locator('#tab-plots').click();
  await page.waitForTimeout(1500);
  await page.screenshot({ path: `${base}-chromium-plots.png` });
  await page.pdf({ path: `${base}.pdf`, preferCSSPageSize: true });
  await page.close();
  execFileSync('pdftoppm', ['-r', '70', '-png', `${base}.pdf`, `${base}-print`]);
}

// Firefox makes its picture as soon as a page is loaded. This one is loaded when an image has come,
// which takes its time.
async function inFirefox(report, base) {
  const frame = '<body style="margin:0"><iframe src="report" style="border:0;width:100vw;height:100vh"></iframe><img src="wait" hidden>';
  const server = http.createServer((request, response) => {
    response.setHeader('Content-Type', 'text/html');
    if (request.url === '/report') response.end(fs.readFileSync(report));
    else if (request.url === '/wait') setTimeout(() => response.end(), 8000);
    else response.end(frame);
  });
  await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
  const profile = fs.mkdtempSync(path.join(os.tmpdir(), 'biss-firefox-'));
  await promisify(execFile)('firefox-esr', ['--headless', '--profile', profile, '--window-size',
    `${size.width},${size.height}`, '--screenshot', `${base}-firefox.png`, `http://127.0.0.1:${server.address().port}/`]);
  fs.rmSync(profile, { recursive: true, force: true });
  server.closeAllConnections();
  server.close();
}

const browser = await browse();
for (const report of others.length > 0 ? others : makeReports()) {
  const base = path.join(output, path.basename(report, '.html'));
  await inChromium(browser, report, base);
  await inFirefox(report, base);
}
await browser.close();
console.log(output);
