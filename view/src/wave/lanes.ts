/** The places of the lanes of the waveform, one below the other. */

export interface Lane {
  top: number;
  height: number;
  /** Names of the lane, with single cycles and without them. */
  name: string;
  farName: string;
}

/** Width of the names at the left. */
export const gutter = 84;

const plan = [
  { key: 'axis', height: 24, gap: 6, name: '', farName: '' },
  { key: 'ma', height: 0, gap: 12, name: 'MA', farName: 'MA' },
  { key: 'slo', height: 0, gap: 6, name: 'SLO', farName: 'SLO' },
  { key: 'bits', height: 20, gap: 6, name: 'bits', farName: '' },
  { key: 'cycle', height: 22, gap: 3, name: 'cycle', farName: 'cycles' },
  { key: 'frame', height: 24, gap: 3, name: 'frame', farName: 'failed' },
  { key: 'cdm', height: 20, gap: 3, name: 'delay, CDM', farName: 'flagged' },
  { key: 'access', height: 20, gap: 3, name: 'registers', farName: '' },
  { key: 'cause', height: 20, gap: 3, name: 'failure', farName: '' },
  { key: 'flags', height: 20, gap: 4, name: 'flags', farName: '' },
] as const;

/** The lane of accesses is there only if there are accesses. */
export type Lanes = Record<Exclude<(typeof plan)[number]['key'], 'access'>, Lane> & { access?: Lane };

const waveHeight = { least: 18, most: 110 };

export function lanesOf(height: number, withAccesses = false): Lanes {
  const shown = plan.filter(({ key }) => key !== 'access' || withAccesses);
  const fixed = shown.reduce((sum, lane) => sum + lane.height + lane.gap, 0);
  const wave = Math.max(waveHeight.least, Math.min(waveHeight.most, (height - fixed) / 2));
  let top = 0;
  const lanes = shown.map(({ key, height: given, gap, name, farName }) => {
    const lane = { top, height: given === 0 ? wave : given, name, farName };
    top += lane.height + gap;
    return [key, lane] as const;
  });
  return Object.fromEntries(lanes) as unknown as Lanes;
}
