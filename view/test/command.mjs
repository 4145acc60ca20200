// The command, for the tests that compare the page with it: BISS, by default build/biss.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after } from 'node:test';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url));
export const command = path.resolve(process.env.BISS ?? path.join(here, '../../build/biss'));

/** A folder of its own; `remove` it at the end. */
export function makeFolder() {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'biss-view-'));
  return {
    at: (name) => path.join(folder, name),
    remove: () => fs.rmSync(folder, { recursive: true }),
    /** Runs the command there. */
    run(args) {
      const ran = spawnSync(command, args, { cwd: folder, maxBuffer: 1 << 30 });
      assert.equal(ran.error, undefined);
      return { status: ran.status, out: ran.stdout.toString(), err: ran.stderr.toString() };
    },
    /** Runs it, and it must succeed. */
    make(args) {
      const ran = this.run(args);
      assert.equal(ran.status, 0, ran.err);
      return ran;
    },
  };
}

/** A folder for a file of tests, removed after the last one. */
export function testFolder() {
  const folder = makeFolder();
  after(() => folder.remove());
  return folder;
}
