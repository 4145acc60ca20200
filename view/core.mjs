// The core that the page is built with: the folder BISS_WASM, by default build-wasm/wasm.
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url));
export const core = path.resolve(process.env.BISS_WASM ?? path.join(here, '../build-wasm/wasm'));

const { loadBiss } = await import(pathToFileURL(path.join(core, 'biss.mjs')));
const biss = await loadBiss({ wasmBinary: fs.readFileSync(path.join(core, 'biss_core.wasm')) });

const options = Object.fromEntries(biss.verbs().verbs.map((verb) =>
  [verb.name, verb.options.map(({ names, scope }) => ({ names, scope }))]));

/** Values of the core for the sources of the page: `define` of esbuild. */
export const define = { WORDS: JSON.stringify(biss.words()), OPTIONS: JSON.stringify(options) };
