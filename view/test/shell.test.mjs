// The page as a user works with it: files, format, search, keyboard, links, export.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { describe, it } from 'node:test';
import { cells, choose, exported, failure, selected } from './actions.mjs';
import { testFolder } from './command.mjs';
import { assertNoRequests, readToEnd, settled, simulated, testBrowser } from './page.mjs';

const faulty = '-f resolute-26 --cycles 600 --clock 10MHz --fault flip@120 --fault flip@300 --fault no_answer@450';

const browser = testBrowser();
const folder = testFolder();

// A page with a capture; nothing may be asked for, and no error reported.
async function withPage(hash, use, size) {
  const { page, requests, errors } = await browser.open(hash, size);
  if (hash !== '') await readToEnd(page);
  await use(page);
  assertNoRequests(requests);
  assert.deepEqual(errors, []);
  await page.context().close();
}

describe('files', () => {
  it('ChosenFile_IsReadAndItsRowsAreThoseOfTheCommand', async () => {
    folder.make(['simulate', '-f', 'resolute-26', '--cycles', '40', '-o', 'chosen.vcd']);
    const rows = folder.make(['decode', 'chosen.vcd', '--velocity', '--to', 'csv']).out.split('\n');
    await withPage('', async (page) => {
      await choose(page, folder.at('chosen.vcd'));
      assert.deepEqual(await page.locator('[role=columnheader]').allInnerTexts(), rows[0].split(','));
      await page.locator('#row-3 .good').waitFor();
      assert.deepEqual(await cells(page, 3), rows[4].split(','));
      assert.equal(await page.locator('.file').innerText(), 'chosen.vcd');
    });
  });

  it('TwoFilesWithALineEach_AreOneCapture', async () => {
    folder.make(['simulate', '-f', 'resolute-26', '--cycles', '40', '-o', 'both.vcd']);
    folder.make(['convert', 'both.vcd', 'ma.csv', '--line', 'MA']);
    folder.make(['convert', 'both.vcd', 'slo.csv', '--line', 'SLO']);
    await withPage('', async (page) => {
      await choose(page, [folder.at('ma.csv'), folder.at('slo.csv')]);
      await page.locator('.status-bar', { hasText: '40 request cycles' }).waitFor();
    });
  });

  it('FileThatIsNoCapture_GivesTheMessageOfTheCommand', async () => {
    fs.writeFileSync(folder.at('notes.vcd'), 'These are notes.\n');
    const expected = folder.run(['decode', 'notes.vcd']);
    await withPage('', async (page) => {
      await page.locator('#choose-files').setInputFiles(folder.at('notes.vcd'));
      assert.equal(await failure(page), expected.err.trim());
    });
  });
});

describe('format', () => {
  it('UnknownFormat_IsFoundAndShown', async () => {
    folder.make(['simulate', '-f', 'mt12,st20,nE,nW,crc6', '--cycles', '600', '--motion', 'random', '-o', 'unknown.vcd']);
    const { format } = JSON.parse(folder.make(['identify', 'unknown.vcd', '--to', 'jsonl']).out);
    await withPage('', async (page) => {
      await choose(page, folder.at('unknown.vcd'));
      assert.equal(await page.locator('#format').getAttribute('placeholder'), format);
      assert.match(await page.locator('.found').innerText(), /^found, \d+ % sure$/);
    });
  });

  it('FormatThatIsChanged_TakesEffectAtOnce', async () => {
    await withPage(simulated('-f resolute-26 --cycles 200', { format: 'resolute-26' }), async (page) => {
      await page.locator('#row-0 .good').waitFor();
      await page.locator('#format').fill('pos32,crc6');
      await page.keyboard.press('Enter');
      await page.locator('#row-0 .bad').first().waitFor();
      assert.notEqual((await cells(page, 0))[2], 'ok');
    });
  });

  it('WrongFormat_IsNamedAndTheRowsStay', async () => {
    await withPage(simulated('-f resolute-26 --cycles 200', { format: 'resolute-26' }), async (page) => {
      await page.locator('#row-0 .good').waitFor();
      await page.locator('#format').fill('pos26,nothing');
      await page.keyboard.press('Enter');
      assert.match(await failure(page), /^biss: .*nothing/);
      assert.equal((await cells(page, 0))[2], 'ok');
    });
  });
});

describe('search', () => {
  it('NextStatus_SelectsTheRowsOneAfterTheOther', async () => {
    await withPage(simulated(faulty, { format: 'resolute-26' }), async (page) => {
      await page.locator('body').press('/');
      await page.keyboard.type('next crc');
      await page.keyboard.press('Enter');
      await page.locator('#row-120.selected').waitFor();
      await page.keyboard.press('Enter');
      await page.locator('#row-300.selected').waitFor();
      await page.keyboard.press('Shift+Enter');
      await page.locator('#row-120.selected').waitFor();
      await page.locator('#search-result', { hasText: '2 rows' }).waitFor();
    });
  });

  it('Comparison_FindsWhatTheRowsSay', async () => {
    folder.make(['simulate', '-f', 'resolute-26', '--cycles', '300', '-o', 'moving.vcd']);
    const rows = folder.make(['decode', 'moving.vcd', '--to', 'csv']).out.trim().split('\n').slice(1);
    const positions = rows.map((row) => Number(row.split(',')[3]));
    const limit = [...positions].sort((a, b) => a - b)[150];
    await withPage('', async (page) => {
      await choose(page, folder.at('moving.vcd'));
      const count = positions.filter((position) => position > limit).length;
      await page.locator('#search').fill(`position > ${limit} and not crc`);
      await page.locator('#search-result', { hasText: `${count} rows` }).waitFor();
      await page.locator('#search').fill('time >= 1ms and time < 2ms');
      const between = rows.map((row) => Number(row.split(',')[1])).filter((time) => time >= 1e6 && time < 2e6);
      await page.locator('#search-result', { hasText: `${between.length} rows` }).waitFor();
    });
  });

  it('WrongCondition_SaysWhatIsWrong', async () => {
    await withPage(simulated('-f resolute-26 --cycles 50'), async (page) => {
      for (const [text, message] of [
        ['crx', '"crx" is not a status'],
        ['positon > 3', '"positon" is not a column'],
        ['position >', 'a value is missing'],
        ['(crc', '")" is missing'],
        ['ack > 3MHz', 'does not have this unit'],
      ]) {
        await page.locator('#search').fill(text);
        await page.keyboard.press('Enter');
        await page.locator('#search-result', { hasText: message }).waitFor();
      }
    });
  });

  it('Filter_LeavesTheFailedRows', async () => {
    await withPage(simulated(faulty, { format: 'resolute-26' }), async (page) => {
      await page.getByRole('button', { name: 'Errors' }).click();
      await page.locator('#row-450 .bad').first().waitFor();
      assert.equal(await page.locator('.row').count(), 3);
    });
  });
});

describe('keyboard', () => {
  it('EveryPartIsReachedByKeysAlone', async () => {
    await withPage('', async (page) => {
      const name = () => page.evaluate(() => document.activeElement.textContent);
      for (let i = 0; i < 10 && !(await name()).startsWith('Noise'); i += 1) await page.keyboard.press('Tab');
      await page.keyboard.press('Enter');
      await readToEnd(page);
      await page.keyboard.press('g');
      await page.keyboard.press('ArrowDown');
      await page.keyboard.press('ArrowDown');
      assert.equal(await selected(page), 1);
      await page.keyboard.press('End');
      await page.locator('#row-1999.selected').waitFor();
      await page.keyboard.press('Home');
      await page.keyboard.press('e');
      await page.locator('.row.selected .bad').first().waitFor();
      await page.keyboard.press('4');
      await page.locator('.causes li').first().waitFor();
      await page.keyboard.press('t');
      assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'dark');
      await page.keyboard.press('?');
      await page.getByRole('dialog').waitFor();
      await page.keyboard.press('Escape');
      await page.getByRole('dialog').waitFor({ state: 'hidden' });
    });
  });
});

describe('a link', () => {
  it('Link_ShowsTheSameView', async () => {
    const first = simulated(faulty, { format: 'resolute-26', filter: 'error', panel: 'summary', theme: 'dark', row: '300' });
    let link;
    await withPage(first, async (page) => {
      await page.locator('#row-300.selected').waitFor();
      await settled(page);
      await page.getByRole('button', { name: 'Link' }).click();
      link = new URL(page.url()).hash.slice(1);
    });
    const state = new URLSearchParams(link);
    for (const name of ['from', 'to', 'row', 'filter', 'panel', 'theme']) assert.ok(state.has(name), name);
    await withPage(link, async (page) => {
      assert.equal(await selected(page), 300);
      await page.getByRole('button', { name: 'Link' }).click();
      assert.equal(new URL(page.url()).hash.slice(1), link);
    });
  });

  it('LinkToAFileOfTheUser_AsksForItAndShowsTheView', async () => {
    folder.make(['simulate', '-f', 'resolute-26', '--cycles', '100', '-o', 'mine.vcd']);
    await withPage('', async (page) => {
      await page.evaluate(() => { location.hash = 'file=mine.vcd&row=42&panel=summary&from=1000000&to=9000000'; });
      await page.reload();
      await page.locator('.message', { hasText: 'Open this file to see it' }).waitFor();
      await choose(page, folder.at('mine.vcd'));
      assert.equal(await selected(page), 42);
    });
  });
});

describe('export', () => {
  it('Vcd_HasEveryEdgeOfTheWaveform', async () => {
    folder.make(['simulate', '-f', 'resolute-26', '--cycles', '30', '-o', 'edges.vcd']);
    await withPage('', async (page) => {
      await choose(page, folder.at('edges.vcd'));
      await page.getByRole('button', { name: 'All: show the whole capture' }).click();
      fs.writeFileSync(folder.at('part.vcd'), await exported(page, /VCD of the waveform/));
      const decode = (name) => folder.make(['decode', name, '-f', 'resolute-26', '--to', 'csv']).out;
      assert.equal(decode('part.vcd'), decode('edges.vcd'));
    });
  });

  it('Vcd_OfTwoFiles_HasTheLinesOfBoth', async () => {
    folder.make(['simulate', '-f', 'resolute-26', '--cycles', '30', '-o', 'lines.vcd']);
    const decode = (name) => folder.make(['decode', name, '-f', 'resolute-26', '--to', 'csv']).out;
    for (const names of [['MA', 'SLO'], ['D0', 'D0']]) {
      ['MA', 'SLO'].forEach((line, i) => folder.make(['convert', 'lines.vcd', `${line}.csv`, '--line', `${line}=${names[i]}`]));
      await withPage('', async (page) => {
        await choose(page, [folder.at('MA.csv'), folder.at('SLO.csv')]);
        await page.locator('.status-bar', { hasText: '30 request cycles' }).waitFor();
        await page.getByRole('button', { name: 'All: show the whole capture' }).click();
        fs.writeFileSync(folder.at('lines_part.vcd'), await exported(page, /VCD of the waveform/));
        assert.equal(decode('lines_part.vcd'), decode('lines.vcd'));
      });
    }
  });

  it('Png_IsAPicture', async () => {
    await withPage(simulated('-f resolute-26 --cycles 50'), async (page) => {
      const picture = await exported(page, /PNG of the waveform/);
      assert.equal(picture.subarray(1, 4).toString(), 'PNG');
      assert.ok(picture.length > 5_000, `${picture.length} bytes`);
    });
  });

  it('CsvOfTheFilteredTable_HasTheFailedRows', async () => {
    await withPage(simulated(faulty, { format: 'resolute-26', filter: 'error' }), async (page) => {
      await page.locator('#row-120').waitFor();
      const lines = (await exported(page, /CSV of the table/)).toString().trim().split('\n');
      assert.deepEqual(lines.slice(1).map((line) => line.split(',')[0]), ['120', '300', '450']);
    });
  });
});

describe('panels', () => {
  it('RegistersThatTheCaptureShows_GiveTheDataSheet', async () => {
    await withPage('', async (page) => {
      await page.getByRole('button', { name: /^Registers and data sheet/ }).click();
      await readToEnd(page);
      await page.getByRole('tab', { name: 'Registers' }).click();
      await page.getByText('Data sheet of the registers of the capture').waitFor();
      await page.getByLabel('What the data sheet says').filter({ hasText: 'format' }).waitFor();
      assert.match(await page.getByLabel('What the data sheet says').innerText(), /^format +mt12,st18,nE,nW,crc6$/m);
      await page.getByLabel('Check of the data sheet').filter({ hasText: /./ }).waitFor();
      assert.match(await page.getByLabel('Check of the data sheet').innerText(), /nothing wrong found/);
      await page.getByRole('cell', { name: 'DEV_ID' }).first().waitFor();
    });
  });

  it('Check_ListsTheRulesOfTheCommand', async () => {
    folder.make(['simulate', '-f', 'resolute-26', '--cycles', '80', '--fault', 'flip:0.1', '-o', 'checked.vcd']);
    const rules = folder.run(['check', 'checked.vcd', '--to', 'jsonl']).out.trim().split('\n').map((line) => JSON.parse(line));
    await withPage('', async (page) => {
      await choose(page, folder.at('checked.vcd'));
      await page.getByRole('tab', { name: 'Check' }).click();
      await page.getByLabel('Judged rules only').uncheck();
      await page.locator('.rules tbody tr').first().waitFor();
      const shown = await page.locator('.rules tbody th').allInnerTexts();
      assert.deepEqual([...shown].sort(), rules.map(({ rule }) => rule).sort());
      const failed = rules.filter(({ verdict }) => verdict === 'fail').length;
      assert.equal(await page.locator('.rules .bad-text').count(), failed);
    });
  });

  it('Explain_NamesTheCausesOfTheCommand', async () => {
    folder.make(['simulate', '-f', 'resolute-26', '--cycles', '80', '--fault', 'no_answer:0.2', '-o', 'explained.vcd']);
    const causes = folder.run(['explain', 'explained.vcd', '--to', 'jsonl']).out.trim().split('\n').map((line) => JSON.parse(line));
    await withPage('', async (page) => {
      await choose(page, folder.at('explained.vcd'));
      await page.getByRole('tab', { name: 'Explain' }).click();
      await page.locator('.causes h3').first().waitFor();
      const shown = await page.locator('.causes h3').allInnerTexts();
      assert.deepEqual(shown, causes.map(({ cause, likelihood }) => `${cause} ${likelihood.toFixed(2)}`));
    });
  });
});

describe('the playground', () => {
  const expected = {
    good: /^All 300 cycles are right/,
    compensation: /^\d+ of 300 cycles are sampled too close/,
    sampling: /^\d+ of 300 cycles are sampled too close/,
    format: /^300 of 300 cycles fail.*truncated$/,
    bit: /^\d{1,2} of 300 cycles fail.*crc$/,
    timeout: /^300 of 300 cycles fail.*no_response$/,
    start: /^\d+ of 300 cycles fail.*(no_start|truncated)$/,
    cable: /^\d+ of 300 cycles fail/,
  };
  it('EachPreset_ShowsItsMistakeAtTheFirstCycleThatHasIt', { timeout: 120_000 }, async () => {
    const { page, requests, errors } = await browser.open('play');
    const ids = await page.locator('#preset option').evaluateAll((options) => options.map(({ value }) => value));
    assert.deepEqual(ids, Object.keys(expected));
    const choose = async (id) => {
      await page.locator('#preset').selectOption(id);
      await page.locator('.outcome', { hasText: expected[id] }).waitFor({ timeout: 20_000 }).catch(async () => {
        assert.fail(`${id}: ${await page.locator('.outcome').innerText()}`);
      });
    };
    for (const id of ids) {
      // The outcome of one preset may fit the next one, too.
      await choose('good');
      await choose(id);
      if (id !== 'good') {
        const [, row] = /cycle (\d+):/.exec(await page.locator('.outcome').innerText());
        await page.locator(`#row-${row}.selected`).waitFor();
      }
    }
    assertNoRequests(requests);
    assert.deepEqual(errors, []);
    await page.context().close();
  });

  it('PresetsChosenOneAfterAnother_TheLastIsShownWithoutAnError', async () => {
    const { page, errors } = await browser.open('play');
    const preset = page.locator('#preset');
    await page.locator('.outcome', { hasText: expected.good }).waitFor();
    for (let round = 0; round < 12; round += 1) {
      for (const id of ['bit', 'cable', 'start']) {
        await preset.selectOption(id);
        await page.waitForTimeout(40 * round);
      }
    }
    await preset.selectOption('format');
    await page.locator('.outcome', { hasText: expected.format }).waitFor();
    assert.deepEqual(errors, []);
    await page.context().close();
  });

  it('LinkToAPreset_BeginsWithIt', async () => {
    const { page } = await browser.open('play=timeout');
    await page.locator('.outcome', { hasText: expected.timeout }).waitFor();
    assert.equal(await page.locator('#preset').inputValue(), 'timeout');
    assert.equal(await page.getByLabel('Timeout', { exact: true }).inputValue(), 'static:400ns');
    await page.context().close();
  });

  it('FaultThatIsAdded_IsSeenInTheRows', async () => {
    await withPage('', async (page) => {
      await page.locator('body').press('s');
      await readToEnd(page);
      await page.locator('#row-0 .good').waitFor();
      await page.getByRole('button', { name: 'Add a fault' }).click();
      await page.getByLabel('Share of cycles with fault 1').fill('1');
      await page.keyboard.press('Enter');
      await page.locator('#row-0 .bad').first().waitFor();
    });
  });
});
