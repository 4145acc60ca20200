// The built page in the browser of the system, for the tests.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { after, before } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const here = path.dirname(fileURLToPath(import.meta.url));
/** The page that is tested. */
export const pageFile = path.resolve(process.env.BISS_VIEW ?? path.join(here, '../dist/biss.html'));

/** The address of the page, from its folder. */
export const address = pathToFileURL(pageFile).href;

/** A browser; `close` it at the end. */
export function browse() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox'],
    timeout: 120_000,
  });
}

/**
 * The browser of a file of tests: started before the first one, closed after the last one.
 * `open(hash, size)` is the function below.
 */
export function testBrowser() {
  let browser;
  before(async () => { browser = await browse(); });
  after(() => browser?.close());
  return {
    open: (hash, size) => open(browser, hash, size),
    newPage: () => browser.newPage(),
  };
}

// How long anything in the page may take: as long as a busy machine needs. No test waits for a time.
const patience = 60_000;

/**
 * A page with this part of the address after #. What it asks of a network and what it reports as an
 * error is collected in `requests` and `errors`.
 */
export async function open(browser, hash = '', size = { width: 1280, height: 720 }) {
  const context = await browser.newContext({ viewport: size, acceptDownloads: true });
  context.setDefaultTimeout(patience);
  const page = await context.newPage();
  const requests = [];
  const errors = [];
  page.on('request', (request) => requests.push(request.url()));
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('console', (message) => { if (message.type() === 'error') errors.push(message.text()); });
  await page.goto(hash === '' ? address : `${address}#${hash}`);
  return { page, requests, errors };
}

/** Waits until the capture has been read to its end. */
export async function readToEnd(page) {
  await page.locator('.status-bar', { hasText: 'Read to the end' }).waitFor();
}

/** Waits until nothing is being asked of the core, and what has been answered is drawn. */
export async function settled(page) {
  await page.evaluate(() => new Promise((resolve) => {
    let quietFrames = 0;
    const look = () => {
      quietFrames = document.documentElement.hasAttribute('data-waiting') ? 0 : quietFrames + 1;
      if (quietFrames > 3) resolve();
      else requestAnimationFrame(look);
    };
    look();
  }));
}

/** A link to a simulated capture, with more of the state. */
export function simulated(args, more = {}) {
  return new URLSearchParams({ simulate: args, ...more }).toString();
}

/** Nothing but the page itself, its worker and pictures was asked for. */
export function assertNoRequests(requests) {
  const others = requests.filter((url) => !url.startsWith(address) && !/^(blob|data):/.test(url));
  assert.deepEqual(others, []);
}

const axe = fs.readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

/** What an accessibility audit finds: no violation, in all of the page or in a part of it. */
export async function audit(page, where, part = 'html') {
  await page.evaluate(`${axe};0`);
  const { violations } = await page.evaluate((within) => window.axe.run(within), part);
  const found = violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html).join(' ')}`);
  assert.deepEqual(found, [], where);
}
