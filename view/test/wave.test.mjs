// The waveform and the plots in the page, by pointer and by keys.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { audit, readToEnd, settled, simulated, testBrowser } from './page.mjs';
import { load } from './typescript.mjs';

const { lanesOf, gutter } = await load('wave/lanes.ts');

const capture = '-f pos26,nE,nW,crc6 --cycles 60 --cable 30m --fault flip@3,bit=5 --fault nE@7';

const browser = testBrowser();

async function opened(more = {}, args = capture) {
  const { page, errors } = await browser.open(simulated(args, more));
  await readToEnd(page);
  return { page, errors };
}

async function closed({ page, errors }) {
  assert.deepEqual(errors, []);
  await page.context().close();
}

/** What the picture says of itself, once it says this. */
async function saidBy(page, pattern) {
  const picture = page.locator('.wave-picture canvas');
  await page.waitForFunction(
    ([source]) => new RegExp(source).test(document.querySelector('.wave-picture canvas').getAttribute('aria-label')),
    [pattern.source],
  );
  return picture.getAttribute('aria-label');
}

async function widthOf(page) {
  const text = await saidBy(page, /wide/);
  const [, number, unit] = /, ([\d.]+) (\S+) wide/.exec(text);
  return Number(number) * { s: 1, ms: 1e-3, 'µs': 1e-6, ns: 1e-9, ps: 1e-12 }[unit];
}

async function changed(page, run) {
  const picture = page.locator('.wave-picture canvas');
  const before = await picture.getAttribute('aria-label');
  await run();
  await page.waitForFunction(
    ([text]) => document.querySelector('.wave-picture canvas').getAttribute('aria-label') !== text, [before]);
}

test('Waveform_ByKeys_ZoomsFromTheCaptureToAnEdge', async () => {
  const tab = await opened();
  const { page } = tab;
  await page.locator('.wave-picture').focus();
  await changed(page, () => page.keyboard.press('0'));
  const all = await widthOf(page);
  await changed(page, () => page.keyboard.press('+'));
  assert.ok(Math.abs(await widthOf(page) * 1.5 / all - 1) < 0.01);
  for (let i = 0; i < 50; i += 1) await page.keyboard.press('ArrowUp');
  await saidBy(page, /, 1 ns wide/);
  await changed(page, () => page.keyboard.press('ArrowRight'));
  assert.equal(await widthOf(page), 1e-9);
  await closed(tab);
});

test('Waveform_CaptureThatBeginsBeforeZero_IsSeenFromItsBeginning', async () => {
  const { page, errors } = await browser.open();
  const edges = ['time_ns,MA,SLO', '-60000,1,1'];
  for (let i = 0; i < 300; i += 1) edges.push(`${-50000 + 500 * i},${i % 2},${i < 3 ? 1 : i % 3 === 0 ? 1 : 0}`);
  await page.locator('#choose-files')
    .setInputFiles({ name: 'early.csv', mimeType: 'text/csv', buffer: Buffer.from(`${edges.join('\n')}\n`) });
  await readToEnd(page);
  await page.locator('.wave-picture').focus();
  await page.keyboard.press('0');
  await saidBy(page, /from −60 µs to 99\.5 µs/);
  await closed({ page, errors });
});

test('Waveform_ByWheelAndDrag_ZoomsAndMoves', async () => {
  const tab = await opened();
  const { page } = tab;
  const box = await page.locator('.wave-picture').boundingBox();
  await page.mouse.move(box.x + 600, box.y + 60);
  const wide = await widthOf(page);
  await changed(page, () => page.mouse.wheel(0, -300));
  const narrow = await widthOf(page);
  assert.ok(narrow < wide * 0.7, `${wide} to ${narrow}`);
  await page.mouse.down();
  await changed(page, () => page.mouse.move(box.x + 400, box.y + 60, { steps: 5 }));
  await page.mouse.up();
  assert.equal(await widthOf(page), narrow);
  await closed(tab);
});

test('Waveform_CycleClicked_IsSelectedInTheTable', async () => {
  const tab = await opened();
  const { page } = tab;
  const box = await page.locator('.wave-picture').boundingBox();
  await page.mouse.click(box.x + 700, box.y + lanesOf(box.height).cycle.top + 5);
  const [, row] = /Cycle (\d+) is selected/.exec(await saidBy(page, /Cycle \d+ is selected/));
  await page.locator(`#row-${row}[aria-selected=true]`).waitFor();
  await page.keyboard.press('Escape');
  await page.locator('.wave-picture').focus();
  await changed(page, () => page.keyboard.press('.'));
  await page.locator(`#row-${Number(row) + 1}[aria-selected=true]`).waitFor();
  await closed(tab);
});

test('Waveform_FailedCycle_SaysWhatItsChecksumNeeds', async () => {
  const tab = await opened({ row: '3' });
  const { page } = tab;
  await page.locator('.wave-picture').focus();
  await changed(page, () => page.keyboard.press('Enter'));
  const box = await page.locator('.wave-picture').boundingBox();
  const pointer = page.locator('.wave-pointer');
  const y = box.y + lanesOf(box.height).cause.top + 8;
  await settled(page);
  let said = '';
  for (let x = gutter; x < box.width && !said.includes('crc: received'); x += 8) {
    await page.mouse.move(box.x + x, y);
    said = await pointer.textContent();
  }
  assert.match(said, /#3 crc: received 0x[0-9A-F]+, expected 0x[0-9A-F]+; corrected by a flip of .*pos20/);
  await closed(tab);
});

// The pointer over the access shows its register and outcome.
async function accessIsNamed(page) {
  const picture = page.locator('.wave-picture');
  await picture.focus();
  await page.keyboard.press('Enter');
  const box = await picture.boundingBox();
  const y = box.y + lanesOf(box.height, true).access.top + 8;
  await settled(page);
  await page.mouse.move(box.x + 500, y);
  await page.locator('.wave-pointer', { hasText: /0x42 BP_ID .*no_answer/ }).waitFor();
}

test('Waveform_AccessToARegister_IsNamed', async () => {
  const tab = await opened({ row: '20' }, '-f pos26,nE,nW,crc6 --cycles 100 --access read:0x42');
  const { page } = tab;
  await accessIsNamed(page);
  await closed(tab);
});

test('Waveform_AccessInALargeCapture_IsNamed', async () => {
  const tab = await opened({ row: '20' }, '-f pos26,nE,nW,crc6 --cycles 12000 --access read:0x42');
  const { page } = tab;
  assert.ok(Number(/([\d.]+) MB/.exec(await page.locator('.status-bar').innerText())[1]) > 16);
  await accessIsNamed(page);
  await closed(tab);
});

test('Waveform_WithCyclesSkipped_NamesThemByTheirNumbers', async () => {
  const tab = await opened({ row: '3', further: '--since 1ms' }, '-f pos26,nE,nW,crc6 --cycles 100');
  const { page } = tab;
  const [number] = await page.locator('#row-3 [role=gridcell]').allInnerTexts();
  assert.ok(Number(number) > 3);
  await page.locator('.wave-picture').focus();
  await page.keyboard.press('Enter');
  await saidBy(page, new RegExp(`cycles ${number - 1} to \\d+; none failed\\. Cycle ${number} is selected`));
  await closed(tab);
});

test('Cursors_Dragged_ShowTheirDifference', async () => {
  const tab = await opened();
  const { page } = tab;
  const box = await page.locator('.wave-picture').boundingBox();
  await page.keyboard.down('Shift');
  await page.mouse.move(box.x + 300, box.y + 50);
  await page.mouse.down();
  await page.mouse.move(box.x + 800, box.y + 50, { steps: 4 });
  await page.mouse.up();
  await page.keyboard.up('Shift');
  const text = await page.locator('.wave-difference').textContent();
  assert.match(text, /^Δ \d+(\.\d+)? µs \(\d+(\.\d+)? k?Hz\)$/);
  await audit(page, 'cursors', '.wave');
  await page.locator('.wave-picture').focus();
  await page.keyboard.press('x');
  await page.locator('.wave-difference').waitFor({ state: 'detached' });
  await closed(tab);
});

test('Cursors_ByKeys_GoFromChangeToChange', async () => {
  const tab = await opened();
  const { page } = tab;
  await page.locator('.wave-picture').focus();
  await page.keyboard.press('b');
  await page.keyboard.press(']');
  const label = page.locator('.wave-cursor-b');
  const first = await label.textContent();
  for (const key of [']', ']', '[', '[']) await page.keyboard.press(key);
  assert.equal(await label.textContent(), first);
  await page.keyboard.press(']');
  assert.notEqual(await label.textContent(), first);
  await closed(tab);
});

test('Plots_OfAPosition_HaveItsExtremesInWords', async () => {
  const tab = await opened({ panel: 'plots' });
  const { page } = tab;
  const positions = await page.evaluate(() => [...document.querySelectorAll('.table [role=row]')].length);
  assert.ok(positions > 3);
  const canvas = page.locator('.plot', { hasText: 'Position' }).first().locator('canvas');
  await page.waitForFunction(() => /counts$/.test(document.querySelector('.plot canvas').getAttribute('aria-label')));
  assert.match(await canvas.getAttribute('aria-label'), /^Position from .* to .*: \d[\d\u202f]* counts to \d[\d\u202f]* counts$/);
  const eye = page.locator('.plot-eye canvas');
  await page.waitForFunction(() => /samples of 60 cycles/.test(document.querySelector('.plot-eye canvas').getAttribute('aria-label')));
  // Half a period of 1 MHz on both sides, but for the jitter that there is none of.
  assert.match(await eye.getAttribute('aria-label'), /nearest change \d+(\.\d+)? ns \(\d+\.\d %\) before/);
  await closed(tab);
});

test('Causes_Clicked_GoToTheirCycle', async () => {
  const tab = await opened({ panel: 'plots' });
  const { page } = tab;
  await page.getByRole('button', { name: 'Next cycle with crc', exact: true }).click();
  await saidBy(page, /Cycle 3 is selected/);
  await page.getByRole('button', { name: 'Next cycle with nE=0', exact: true }).click();
  await saidBy(page, /Cycle 7 is selected/);
  await closed(tab);
});
