// The settings of the page as arguments of the command.
import type { DescribedOption } from '../../../wasm/biss.d.mts';
import type { Settings } from '../state';

type Option = Pick<DescribedOption, 'names' | 'scope'>;
// The options of each verb. The core gives them when the page is built: view/core.mjs.
declare const OPTIONS: Record<string, Option[]>;

function optionOf(verb: string, name: string): Option | undefined {
  return OPTIONS[verb]?.find(({ names }) => names.split(',').includes(name));
}

// Options that choose rows and columns, options for `decode` alone, and columns that the verb does not
// judge change nothing for another verb. `convert` takes the options for reading a file. Every other
// option goes to the verb, which takes it or refuses it by name.
function isFor(verb: string, name: string): boolean {
  const scope = optionOf('decode', name)?.scope;
  if (verb === 'convert') return scope === 'file' && optionOf(verb, name) !== undefined;
  if (scope === 'judging') return optionOf(verb, name) !== undefined;
  return scope !== 'rows' && scope !== 'command';
}

/** Splits as a shell does, with '…' and "…" around words with spaces. */
export function splitArguments(text: string): string[] {
  const found = text.matchAll(/(?:[^\s'"]|'[^']*'|"[^"]*")+/g);
  return [...found].map(([word]) => word.replace(/'([^']*)'|"([^"]*)"/g, '$1$2'));
}

/** Arguments for the lines and the format, for every verb that reads a capture. */
export function captureArguments(settings: Settings): string[] {
  const args: string[] = [];
  if (settings.format !== '') args.push('-f', settings.format);
  if (settings.ma !== '') args.push('--ma', settings.ma);
  if (settings.slo !== '') args.push('--slo', settings.slo);
  if (settings.invertMa) args.push('--invert-ma');
  if (settings.invertSlo) args.push('--invert-slo');
  return args;
}

/** The further options that this verb uses to judge the capture, with their values. */
export function verbFurther(verb: string, settings: Settings): string[] {
  let keeps = true;
  return splitArguments(settings.further).filter((word) => {
    if (/^-[-a-z]/.test(word)) keeps = isFor(verb, word.split('=')[0]!);
    return keeps;
  });
}

/**
 * Lists of arguments of `biss decode`, the preferred list first. Later lists leave out the scale, then the
 * velocity, for formats that do not allow them.
 */
export function decodeArguments(names: readonly string[], settings: Settings): string[][] {
  const base = [...names, ...captureArguments(settings), ...splitArguments(settings.further)];
  const scale = settings.units === 'counts' ? [] : ['--scale', settings.units];
  const all = [[...base, '--velocity', ...scale], [...base, '--velocity'], base];
  return scale.length === 0 ? all.slice(1) : all;
}
