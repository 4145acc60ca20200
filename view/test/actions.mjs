// What the tests do with the page, as a user does it.
import fs from 'node:fs';
import { readToEnd } from './page.mjs';

/** Chooses files by the dialog, and waits until they are read. */
export async function choose(page, files) {
  await page.locator('#choose-files').setInputFiles(files);
  await readToEnd(page);
}

/** Takes an entry of the menu Export; the text of the file that is saved. */
export async function exported(page, name) {
  await page.locator('.menu summary', { hasText: 'Export' }).click();
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', { name }).click(),
  ]);
  return fs.readFileSync(await download.path());
}

/** Waits for a message of the command, and returns it. */
export async function failure(page) {
  const message = page.locator('.message.failed .message-text');
  await message.waitFor();
  const more = page.getByRole('button', { name: / more$/ });
  if (await more.count() > 0) await more.click();
  return message.innerText();
}

/** The cells of a row that the table shows. */
export async function cells(page, row) {
  return page.locator(`#row-${row} [role=gridcell]`).allInnerTexts();
}

/** The number of the row that is selected. */
export async function selected(page) {
  const row = page.locator('.row.selected');
  await row.waitFor();
  return Number((await row.getAttribute('id')).slice('row-'.length));
}
