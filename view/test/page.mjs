// The built page in the browser of the system, for the tests.
import assert from 'node:assert/strict';
import path from 'node:path';
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
  });
}

/**
 * A page with this part of the address after #. What it asks of a network and what it reports as an
 * error is collected in `requests` and `errors`.
 */
export async function open(browser, hash = '', size = { width: 1280, height: 720 }) {
  const context = await browser.newContext({ viewport: size, acceptDownloads: true });
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
  await page.locator('.status-bar', { hasText: 'Read to the end' }).waitFor({ timeout: 60_000 });
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
