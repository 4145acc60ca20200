// Modules of the page as Node has them, for tests without a browser.
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import esbuild from 'esbuild';
import { define } from '../core.mjs';

const root = path.join(path.dirname(fileURLToPath(import.meta.url)), '..');

let loads = 0;

/** What src/NAME exports, with a state of its own. */
export async function load(name) {
  const { outputFiles } = await esbuild.build({
    absWorkingDir: root,
    entryPoints: [`src/${name}`],
    bundle: true,
    write: false,
    format: 'esm',
    platform: 'node',
    tsconfigRaw: {},
    define,
  });
  const text = Buffer.from(`${outputFiles[0].text}\n// ${loads += 1}`).toString('base64');
  return import(`data:text/javascript;base64,${text}`);
}
