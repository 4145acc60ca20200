// Files as the worker reads them: ahead by a worker of its own, and without one.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { load } from './typescript.mjs';

const size = 70_000_001;
const content = new Uint8Array(size);
for (let i = 0; i < size; i += 1) content[i] = (i * 2_654_435_761) >>> 23;

class FakeFile {
  size = size;
  slice = (begin, end) => ({ begin, end: Math.min(end, size) });
}

let readHere = 0;
class FakeReader {
  readAsArrayBuffer({ begin, end }) {
    readHere += 1;
    return content.slice(begin, end).buffer;
  }
}

const bytesOf = ({ begin, end }) => content.slice(begin, end).buffer;
const empty = () => new ArrayBuffer(0);

// A worker that answers each piece as `answer` says, after some turns of the event loop.
function workerThat(answer) {
  return class {
    postMessage(piece) {
      setImmediate(() => setImmediate(() => answer(this, piece)));
    }
  };
}
const workers = {
  readsAhead: workerThat((worker, piece) => worker.onmessage({ data: bytesOf(piece) })),
  cannotRead: workerThat((worker) => worker.onmessage({ data: empty() })),
  // It says so once, and never answers.
  doesNotLoad: workerThat((worker) => {
    worker.onerror?.();
    worker.onerror = undefined;
  }),
  isNotThere: class { constructor() { throw new Error('no worker within a worker'); } },
};

beforeEach(() => {
  globalThis.File = FakeFile;
  globalThis.FileReaderSync = FakeReader;
  readHere = 0;
});

// What was asked for has come.
async function turns() {
  for (let i = 0; i < 20; i += 1) await new Promise((resolve) => { setImmediate(resolve); });
}

// As reader.ts does: what is soon needed is waited for.
async function readTo(source, from, to, step) {
  for (let at = from; at < to;) {
    const piece = source.read(at, step);
    assert.ok(piece.length > 0 && piece.length <= step);
    assert.ok(Buffer.compare(piece, content.subarray(at, at + piece.length)) === 0, `at ${at}`);
    at += piece.length;
    await source.prefetch();
  }
}

for (const [name, worker] of Object.entries(workers)) {
  test(`WorkerThat_${name}_FileIsReadWhole`, { timeout: 60_000 }, async () => {
    globalThis.Worker = worker;
    const { measuredSource } = await load('core/source.ts');
    const source = measuredSource(new FakeFile());
    await readTo(source, 0, size, 1 << 20);
    if (name === 'readsAhead') assert.ok(readHere <= 2, `${readHere} reads that wait`);
    for (const place of [69_000_000, 5, 60_000_000, 16_777_215]) {
      await readTo(source, place, Math.min(size, place + 20_000_000), 3_000_001);
      await turns();
    }
  });
}

test('WorkerThatIsLate_IsNotWaitedForByARead', async () => {
  globalThis.Worker = workers.readsAhead;
  const { measuredSource } = await load('core/source.ts');
  const source = measuredSource(new FakeFile());
  for (let at = 0; at < size;) {
    const piece = source.read(at, 1 << 20);
    assert.ok(Buffer.compare(piece, content.subarray(at, at + piece.length)) === 0, `at ${at}`);
    at += piece.length;
    void source.prefetch();
  }
});
