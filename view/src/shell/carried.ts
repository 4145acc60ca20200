// A capture in the page, or from its own server:
//
//     <script type="text/plain" id="biss-capture" data-name="NAME" data-view="VIEW">BASE64</script>
//
// with the bytes as base64 of gzip; or empty, with data-address and data-size, if the server gives
// them in pieces (Range). data-watch is an address that gives the size: with it the page continues
// to read as the file grows; data-follow permits this. VIEW is the part of a link after #; a view
// in the address of the page takes precedence. With data-live the address is the record of a line
// that is read now: see live.tsx. If the capture is a part of a larger one, an element
// `biss-report` has the object of core/report.ts, as JSON in base64 of gzip.
import { isFollowing, watchServed } from '../core/following';
import { openFiles } from '../core/reading';
import type { Report } from '../core/report';
import { decoded } from '../core/texts';
import { unpack } from '../core/unpack';
import { followLine } from './live';

const element = document.getElementById('biss-capture');

/** The view that comes with the capture. */
export function carriedView(): string {
  return element?.dataset['view'] ?? '';
}

/** The page has the bytes of its capture: it is a report. */
export const isCarried = element !== null && element.dataset['address'] === undefined;

async function carriedReport(): Promise<Report | undefined> {
  const text = document.getElementById('biss-report')?.textContent ?? '';
  if (text === '') return undefined;
  return JSON.parse(decoded(await unpack(text))) as Report;
}

/** Opens the capture in the page. Returns false if the page has no capture. */
export async function openCarried(): Promise<boolean> {
  const { name, address, size, watch, follow, live } = element?.dataset ?? {};
  if (element === null || name === undefined) return false;
  if (address === undefined) {
    await openFiles([{ name, content: await unpack(element.textContent ?? '') }], undefined, await carriedReport());
    return true;
  }
  const content = { address: new URL(address, location.href).href, size: Number(size) };
  if (live !== undefined) {
    void followLine(name, content);
    return true;
  }
  await openFiles([{ name, content }]);
  if (watch !== undefined) {
    isFollowing.value = (follow ?? '') !== '';
    void watchServed(name, content, new URL(watch, location.href).href);
  }
  return true;
}
