// The settings of the page as arguments of the command.
import type { Settings } from '../state';

// Of the further options, those that every verb with a capture has, and how many values they take.
const commonOptions: Record<string, number> = {
  '--resolution': 1,
  '--each': 0,
  '--raw-rate': 1,
  '--raw-bytes': 1,
  '--threshold': 1,
  '--differential': 1,
};

/** Splits as a shell does, with '…' and "…" round what has spaces. */
export function splitArguments(text: string): string[] {
  const found = text.matchAll(/(?:[^\s'"]|'[^']*'|"[^"]*")+/g);
  return [...found].map(([word]) => word.replace(/'([^']*)'|"([^"]*)"/g, '$1$2'));
}

/** Arguments that say which lines and which format, for every verb that reads a capture. */
export function captureArguments(settings: Settings): string[] {
  const args: string[] = [];
  if (settings.format !== '') args.push('-f', settings.format);
  if (settings.ma !== '') args.push('--ma', settings.ma);
  if (settings.slo !== '') args.push('--slo', settings.slo);
  if (settings.invertMa) args.push('--invert-ma');
  if (settings.invertSlo) args.push('--invert-slo');
  return args;
}

/** Of the further options, those that belong to every verb. */
export function commonFurther(settings: Settings): string[] {
  const words = splitArguments(settings.further);
  return words.flatMap((word, i) => {
    const name = word.split('=')[0]!;
    const values = commonOptions[name];
    if (values === undefined) return [];
    return word.includes('=') ? [word] : words.slice(i, i + 1 + values);
  });
}

/**
 * Arguments of `biss decode`, the most wanted first: where the format does not allow a scale or a
 * velocity, the next ones do without.
 */
export function decodeArguments(names: readonly string[], settings: Settings): string[][] {
  const base = [...names, ...captureArguments(settings), ...splitArguments(settings.further)];
  const scale = settings.units === 'counts' ? [] : ['--scale', settings.units];
  const all = [[...base, '--velocity', ...scale], [...base, '--velocity'], base];
  return scale.length === 0 ? all.slice(1) : all;
}
