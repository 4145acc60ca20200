// An accessibility audit of the page in each of its states, in both themes.
import { describe, it } from 'node:test';
import { audit, readToEnd, settled, simulated, testBrowser } from './page.mjs';

const args = '-f fs-36-28 --clock 5MHz --cycles 400 --fault flip:0.05 --fault no_answer:0.02';
const browser = testBrowser();

describe('accessibility', () => {
  for (const theme of ['light', 'dark']) {
    it(`PageWithoutACapture_${theme}_HasNoViolation`, async () => {
      const { page } = await browser.open(`theme=${theme}`);
      await page.locator('.drop').waitFor();
      await audit(page, theme);
      await page.context().close();
    });

    it(`EveryPanelAndDialog_${theme}_HasNoViolation`, { timeout: 300_000 }, async () => {
      const { page } = await browser.open(simulated(args, { theme, row: '0', format: 'fs-36-28' }));
      await readToEnd(page);
      await page.locator('#row-0 .good').waitFor();
      for (const name of ['Cycle', 'Plots', 'Summary', 'Explain', 'Check', 'Identify', 'Registers']) {
        await page.getByRole('tab', { name }).click();
        await page.locator('.panel .quiet', { hasText: 'Running' }).waitFor({ state: 'hidden' });
        await settled(page);
        await audit(page, `${name}, ${theme}`);
      }
      await page.getByRole('button', { name: 'Errors' }).click();
      await page.locator('#format').fill('nothing');
      await page.keyboard.press('Enter');
      await page.locator('.message.failed').waitFor();
      await audit(page, `a message, ${theme}`);
      await page.getByRole('button', { name: 'Keys and help' }).click();
      await audit(page, `help, ${theme}`);
      await page.keyboard.press('Escape');
      await page.locator('#table').press('s');
      await page.getByRole('button', { name: 'Add a fault' }).click();
      await audit(page, `simulation, ${theme}`);
      await page.locator('#preset').selectOption('bit');
      await page.locator('.outcome', { hasText: 'cycles fail' }).waitFor();
      await audit(page, `playground, ${theme}`);
      await page.context().close();
    });
  }
});
