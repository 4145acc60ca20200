// The computations for the plots and the waveform. They run in the worker, which has the capture: rows go in
// by column, envelopes and counts come out, so no answer grows with the capture.
import type { Session } from 'biss';
import { causes, type Causes, type CausesAsk } from './causes_of';
import { envelope, type Envelope, type EnvelopeAsk } from './envelope';
import { eye, type Eye, type EyeAsk } from './eye_of';
import { rows, strip, type Rows, type RowsAsk, type Strip, type StripAsk } from './row_classes';

/** The names of the analyses for `client.ask('analyse.NAME', …)`. */
export interface Analyses {
  envelope: { ask: EnvelopeAsk; answer: Envelope };
  strip: { ask: StripAsk; answer: Strip };
  rows: { ask: RowsAsk; answer: Rows };
  causes: { ask: CausesAsk; answer: Causes };
  eye: { ask: EyeAsk; answer: Eye };
}

type Analysis<K extends keyof Analyses> = (
  session: Session,
  ask: Analyses[K]['ask'],
) => Analyses[K]['answer'];

export const analyses: { [K in keyof Analyses]: Analysis<K> } = {
  envelope,
  strip,
  rows,
  causes,
  eye,
};
