// The worker and its client without a browser: what is asked while a capture is read, which requests
// replace each other, and how errors come back.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, describe, it } from 'node:test';
import { fileURLToPath } from 'node:url';
import vm from 'node:vm';
import { gzipSync } from 'node:zlib';
import esbuild from 'esbuild';
import { core, define } from '../core.mjs';
import { load } from './typescript.mjs';

const here = path.dirname(fileURLToPath(import.meta.url));
const { Client, Superseded } = await load('core/client.ts');

// A channel of a browser: a message waits for its turn after those of others. In Node one channel may
// take all turns.
class Turns {
  port1 = { onmessage: () => {}, close: () => { this.port1.onmessage = () => {}; } };
  port2 = { postMessage: () => setImmediate(() => this.port1.onmessage()) };
}

// The script of the worker as the page starts it, in a context of its own. What it posts is copied,
// as between threads.
async function startWorker() {
  const { outputFiles } = await esbuild.build({
    absWorkingDir: path.join(here, '..'), entryPoints: ['src/core/worker.ts'], bundle: true, write: false, format: 'iife',
    tsconfigRaw: {}, alias: { biss: path.join(core, 'biss.mjs') }, define: { ...define, 'import.meta.url': '"file:///biss_core.mjs"' },
  });
  const channel = new MessageChannel();
  const self = { postMessage: (message) => channel.port1.postMessage(message), location: { href: 'blob:page' } };
  channel.port1.onmessage = (event) => self.onmessage(event);
  const context = vm.createContext({
    self, console, performance, atob, Blob, Response, DecompressionStream, TextDecoder, TextEncoder, URL, WebAssembly, MessageChannel: Turns,
    setTimeout, clearTimeout, File: class {}, importScripts: () => {}, crypto, Uint8Array, Error, RangeError,
  });
  vm.runInContext(outputFiles[0].text, context);
  return { port: channel.port2, close: () => channel.port1.close() };
}

let worker;
let client;
const readings = [];
before(async () => {
  worker = await startWorker();
  client = new Client(worker.port);
  client.onReading = (reading) => readings.push(reading);
  await client.ask('load', { core: gzipSync(fs.readFileSync(path.join(core, 'biss_core.wasm'))).toString('base64') });
  const made = await client.ask('run', { args: ['simulate', '-f', 'resolute-26', '--cycles', '20000', '--fault', 'flip@5000', '-o', 'made.vcd'] });
  assert.equal(made.status, 0, made.err);
  await client.ask('addFile', { name: 'line.vcd', content: await client.ask('readFile', { name: 'made.vcd' }) });
});
after(() => {
  worker.port.close();
  worker.close();
});

async function until(condition) {
  while (!condition()) await new Promise((resolve) => { setTimeout(resolve, 5); });
}

async function readAll() {
  readings.length = 0;
  const opened = await client.ask('open', { args: ['line.vcd', '-f', 'resolute-26'], anyLines: false });
  await until(() => readings.at(-1)?.generation === opened.generation && !readings.at(-1).more);
  return opened;
}

describe('the worker', () => {
  it('QuestionWithoutACapture_IsAnError', async () => {
    await assert.rejects(client.ask('summary', {}), { message: 'no capture is open' });
  });

  it('RequestsWhileReading_AreAnsweredBeforeTheEnd', async () => {
    readings.length = 0;
    await client.ask('open', { args: ['line.vcd', '-f', 'resolute-26'], anyLines: false });
    let answered = 0;
    const asking = (async () => {
      while (readings.at(-1)?.more !== false) {
        await client.ask('cells', { from: 0, to: 1 });
        answered += 1;
      }
    })();
    await until(() => readings.at(-1)?.more === false);
    await asking;
    assert.ok(answered > 3, `${answered} answers`);
    assert.equal(readings.at(-1).rowCount, 20_000);
    assert.ok(readings.every(({ done }, i) => i === 0 || done >= readings[i - 1].done));
    assert.match(readings.at(-1).messages, /^line\.vcd: 20000 request cycles$/m);
  });

  it('NewCapture_EndsTheOneBefore', async () => {
    const first = await client.ask('open', { args: ['line.vcd'], anyLines: false });
    const second = await readAll();
    assert.equal(second.generation, first.generation + 1);
    const begins = readings.findIndex(({ generation }) => generation === second.generation);
    await client.ask('summary', {});
    assert.ok(readings.slice(begins).every(({ generation }) => generation === second.generation));
  });

  it('RowAt_IsTheLastRowThatHasBegun', async () => {
    await readAll();
    const { values } = await client.ask('column', { name: 'time_ns', from: 0, to: 6000 });
    for (const row of [0, 1, 2999, 5999]) {
      assert.equal(await client.ask('rowAt', { time: values[row] }), row);
      assert.equal(await client.ask('rowAt', { time: values[row] - 1n }), row === 0 ? undefined : row - 1);
    }
  });

  it('RowsApart_AreTheRowsOfTheTable', async () => {
    await readAll();
    const all = await client.ask('cells', { from: 0, to: 6000 });
    assert.deepEqual(await client.ask('cellsOf', { rows: [5000, 3, 777] }), [all[5000], all[3], all[777]]);
    assert.equal(all[5000][2], 'crc');
    assert.equal(await client.ask('find', { condition: 'crc', from: -1, step: 1 }), 5000);
  });

  it('Lane_SendsTheNewestAndRejectsTheOthers', async () => {
    await readAll();
    const asked = [0, 1, 2, 3].map((row) => client.ask('cells', { from: row, to: row + 1 }, { lane: 'test' })
      .then(([cells]) => cells[0], (error) => error));
    const [first, second, third, last] = await Promise.all(asked);
    assert.equal(first, '0');
    assert.ok(second instanceof Superseded && third instanceof Superseded);
    assert.equal(last, '3');
  });

  it('WrongFormat_ComesBackAsTheMessageOfTheCommandAndTheRowsStay', async () => {
    await readAll();
    await assert.rejects(client.ask('open', { args: ['line.vcd', '-f', 'pos26,nothing'], anyLines: false }),
      (error) => error.status === 2 && /^biss: .*nothing/.test(error.message));
    assert.equal((await client.ask('cells', { from: 7, to: 8 }))[0][0], '7');
  });

  // The page shows errors, and drops what is superseded: a question may meet the closing of its capture.
  it('QuestionToAClosedCapture_IsSuperseded', async () => {
    await readAll();
    await client.ask('close', {});
    await assert.rejects(client.ask('summary', {}), (error) => error instanceof Superseded);
  });
});
