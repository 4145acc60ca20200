// The picture of the playground for the README: docs/pictures/playground.png.
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { browse, open, readToEnd } from './page.mjs';

const here = path.dirname(fileURLToPath(import.meta.url));
const output = process.env.BISS_PICTURE ?? path.join(here, '../../docs/pictures/playground.png');
const mostBytes = 150_000;

const browser = await browse();
const { page } = await open(browser, 'theme=light&play=bit', { width: 1120, height: 620 });
await readToEnd(page);
await page.locator('.outcome', { hasText: 'cycles fail' }).waitFor();
await page.waitForTimeout(1_500);
await page.screenshot({ path: output });
await browser.close();
const { size } = fs.statSync(output);
if (size > mostBytes) throw new Error(`${output} has ${size} bytes, and ${mostBytes} are allowed`);
