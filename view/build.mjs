// Builds the page: one file that holds everything, dist/biss.html.
import { createHash } from 'node:crypto';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import esbuild from 'esbuild';
import { core, define } from './core.mjs';

const here = path.dirname(fileURLToPath(import.meta.url));
const output = path.resolve(process.env.BISS_VIEW ?? path.join(here, 'dist/biss.html'));
const limitBytes = Number(process.env.BISS_VIEW_BYTES ?? 3 << 20);

const common = {
  absWorkingDir: here,
  bundle: true,
  write: false,
  minify: true,
  format: 'iife',
  target: ['chrome110', 'firefox115', 'safari16.4'],
  charset: 'utf8',
  legalComments: 'none',
  jsx: 'automatic',
  jsxImportSource: 'preact',
  tsconfigRaw: {},
  alias: { biss: path.join(core, 'biss.mjs') },
  outdir: 'dist',
  logLevel: 'warning',
};

async function textsOf(options) {
  const { outputFiles } = await esbuild.build({ ...common, ...options });
  const text = (ending) => outputFiles.find((file) => file.path.endsWith(ending))?.text ?? '';
  return { script: text('.js'), style: text('.css') };
}

const worker = await textsOf({
  entryPoints: ['src/core/worker.ts'],
  // The core uses its own address to find the bytes that the page gives to it.
  define: { ...define, 'import.meta.url': '"file:///biss_core.mjs"' },
});
const page = await textsOf({
  entryPoints: ['src/main.tsx'],
  define: { ...define, WORKER_SOURCE: JSON.stringify(worker.script) },
});

function hashOf(text) {
  return `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
}

// Nothing is fetched from anywhere; 'self' is for a capture that the page's own server gives.
const policy = [
  "default-src 'none'",
  `script-src ${hashOf(page.script)} 'wasm-unsafe-eval'`,
  `style-src ${hashOf(page.style)}`,
  'worker-src blob:',
  'img-src data: blob:',
  "connect-src 'self'",
  "base-uri 'none'",
  "form-action 'none'",
].join('; ');

const wasm = gzipSync(fs.readFileSync(path.join(core, 'biss_core.wasm')), { level: 9 });
const parts = {
  POLICY: policy,
  STYLE: page.style,
  CORE: wasm.toString('base64'),
  SCRIPT: page.script,
};
const template = fs.readFileSync(path.join(here, 'src/page.html'), 'utf8');
const html = template.replace(/@(POLICY|STYLE|CORE|SCRIPT)@/g, (_, name) => parts[name]);

if (html.length > limitBytes) {
  throw new Error(`the page has ${html.length} bytes, and ${limitBytes} are allowed`);
}
fs.mkdirSync(path.dirname(output), { recursive: true });
fs.writeFileSync(output, html);
console.log(`${output}: ${(Buffer.byteLength(html) / 1e6).toFixed(2)} MB`);
