// Measures the page with large captures: time to the first picture, time to read all in comparison
// with the command on one thread and without vector instructions, the longest frames while the
// waveform moves, and memory. BISS_GB says how large the VCD is, 1 by default; the .sr has as many
// samples in billions.
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import { makeFolder } from './command.mjs';
import { browse, open } from './page.mjs';

process.env.BISS_SIMD = 'none';
const size = Number(process.env.BISS_GB ?? 1);
const folder = makeFolder();

// A cycle of this simulation takes 2.8 kB of VCD, and 31.9 µs.
const cycles = Math.round((size * 1e9) / 2830);
const simulation = ['simulate', '-f', 'resolute-26', '--clock', '10MHz', '--motion', 'sine', '--fault', 'flip:0.001'];
const captures = [
  { name: 'large.vcd', args: ['--cycles', `${cycles}`] },
  { name: 'large.sr', args: ['--cycles', `${Math.round((size * 1e9) / 3190)}`, '--sample-rate', '100MHz'] },
];
const repetitions = 3;

/** Seconds that something takes. */
async function secondsOf(action) {
  const began = performance.now();
  await action();
  return (performance.now() - began) / 1000;
}

// Resident memory of the browser's processes, in bytes: the largest of them holds the capture.
function largestProcess() {
  const { stdout } = spawnSync('ps', ['-eo', 'rss=,args='], { encoding: 'utf8' });
  const sizes = stdout.split('\n').filter((line) => line.includes('--type=renderer')).map((line) => parseInt(line, 10));
  return Math.max(0, ...sizes) * 1024;
}

// Frames while the waveform zooms from one cycle to all and back, and moves.
async function frames(page) {
  await page.locator('#table').press('Home');
  await page.locator('#table').press('Enter');
  await page.evaluate(() => {
    window.frameTimes = [];
    const take = (time) => {
      window.frameTimes.push(time);
      window.frameRequest = requestAnimationFrame(take);
    };
    window.frameRequest = requestAnimationFrame(take);
  });
  const box = await page.locator('.wave canvas').last().boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  for (let i = 0; i < 120; i += 1) {
    await page.mouse.wheel(i % 40 < 30 ? 0 : 120, i < 60 ? 90 : -90);
    await page.waitForTimeout(16);
  }
  await page.locator('#table').focus();
  for (let i = 0; i < 60; i += 1) await page.keyboard.press('PageDown');
  const times = await page.evaluate(() => {
    cancelAnimationFrame(window.frameRequest);
    return window.frameTimes;
  });
  const gaps = times.slice(1).map((time, i) => time - times[i]).sort((a, b) => a - b);
  return `${gaps.length}, longest ${gaps.at(-1).toFixed(0)} ms, ${gaps.filter((gap) => gap > 33.4).length} over 33 ms`;
}

// A page that opens the capture.
async function choose(browser, name) {
  const { page } = await open(browser, 'format=resolute-26');
  await page.locator('.drop').waitFor();
  const began = performance.now();
  await page.locator('#choose-files').setInputFiles(folder.at(name));
  return { page, began };
}

async function end(page) {
  await page.locator('.status-bar', { hasText: 'Read to the end' }).waitFor({ timeout: 1_200_000 });
}

// First picture, all, and memory, untouched.
async function read(browser, name) {
  const { page, began } = await choose(browser, name);
  await page.locator('#row-0 .good').waitFor({ timeout: 600_000 });
  const first = (performance.now() - began) / 1000;
  await end(page);
  const all = (performance.now() - began) / 1000;
  const status = await page.locator('.status-bar').innerText();
  const memory = largestProcess();
  await page.context().close();
  return { first, all, memory, cycles: /\d+ request cycles/.exec(status) };
}

async function measure(browser, { name, args }) {
  folder.make([...simulation, ...args, '-o', name]);
  const bytes = fs.statSync(folder.at(name)).size;
  const native = [];
  const inPage = [];
  const command = ['decode', name, '-f', 'resolute-26', '--threads', '1', '--velocity', '--to', 'csv', '-o', 'rows.csv'];
  for (let i = 0; i < repetitions; i += 1) {
    native.push(await secondsOf(() => folder.run(command)));
    inPage.push(await read(browser, name));
  }
  const least = (values) => Math.min(...values);
  const best = least(native);
  const total = least(inPage.map((each) => each.all));
  const { page } = await choose(browser, name);
  await page.locator('#row-0 .good').waitFor({ timeout: 600_000 });
  const whileReading = await frames(page);
  await end(page);
  console.log(`${name}: ${(bytes / 1e6).toFixed(0)} MB, ${inPage[0].cycles}
  first rows after            ${least(inPage.map((each) => each.first)).toFixed(2)} s
  read to the end             ${total.toFixed(2)} s; the command ${best.toFixed(2)} s: ${(total / best).toFixed(2)} times
  frames while it reads       ${whileReading}
  frames afterwards           ${await frames(page)}
  memory of the page          ${(Math.max(...inPage.map((each) => each.memory), largestProcess()) / 1e6).toFixed(0)} MB`);
  await page.context().close();
  fs.rmSync(folder.at(name));
  fs.rmSync(folder.at('rows.csv'), { force: true });
}

const browser = await browse();
try {
  for (const capture of captures) await measure(browser, capture);
} finally {
  await browser.close();
  folder.remove();
}
