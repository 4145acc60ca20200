// Texts of the core as data.

export function decoded(bytes: Uint8Array): string {
  return new TextDecoder().decode(bytes);
}

function linesOf(text: string): string[] {
  return text.split('\n').filter((line) => line !== '');
}

/** The objects of JSON lines, as --to jsonl writes them. */
export function objectsOf<T = Record<string, unknown>>(text: string): T[] {
  return linesOf(text).map((line) => JSON.parse(line) as T);
}

/** The cells of lines of CSV, the header first. A cell with a comma or a quote stands in quotes. */
export function cellsOfCsv(text: string): string[][] {
  return linesOf(text).map((line) => [...`,${line}`.matchAll(/,("(?:[^"]|"")*"|[^,]*)/g)]
    .map(([, cell = '']) => (cell.startsWith('"') ? cell.slice(1, -1).replaceAll('""', '"') : cell)));
}

/** The text of an exception. */
export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
