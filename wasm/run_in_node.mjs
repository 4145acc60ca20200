#!/usr/bin/env node
// The verbs of the module as a command, on the files of the current folder:
//     BISS_WASM=build-wasm/wasm wasm/run_in_node.mjs decode capture.vcd
// For comparisons with the command, as in scripts/compare-versions.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const built = path.resolve(process.env.BISS_WASM);
const { loadBiss } = await import(pathToFileURL(path.join(built, 'biss.mjs')));
const biss = await loadBiss({ wasmBinary: fs.readFileSync(path.join(built, 'biss_core.wasm')) });

const args = process.argv.slice(2);
const before = new Set(fs.readdirSync('.').filter((name) => fs.statSync(name).isFile()));
for (const name of before) biss.addFile(name, fs.readFileSync(name));
const ran = biss.run(args);
for (const name of biss.fileNames()) {
  if (!before.has(name) || args.includes(name)) {
    const bytes = biss.readFile(name);
    if (!before.has(name) || !fs.readFileSync(name).equals(bytes)) fs.writeFileSync(name, bytes);
  }
}
fs.writeSync(2, ran.err);
for (let at = 0; at < ran.out.length;) at += fs.writeSync(1, ran.out, at);
process.exitCode = ran.status;
