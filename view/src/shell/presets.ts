// The presets of the playground: a link that works, and the usual mistakes.

export interface Fault {
  kind: string;
  rate: string;
}

export interface Setup {
  format: string;
  /** The format by which the capture is read; empty: the format that is sent. */
  readAs: string;
  clock: string;
  cable: string;
  compensation: boolean;
  jitter: string;
  timeout: string;
  motion: string;
  cycles: string;
  seed: string;
  faults: Fault[];
}

export interface Preset {
  /** In a link: #play=ID. */
  id: string;
  name: string;
  about: string;
  setup: Partial<Setup>;
}

export const usualSetup: Setup = {
  format: 'resolute-26',
  readAs: '',
  clock: '5MHz',
  cable: '20m',
  compensation: true,
  jitter: '2ns',
  timeout: '',
  motion: 'sine',
  cycles: '300',
  seed: '1',
  faults: [],
};

export const presets: readonly Preset[] = [
  {
    id: 'good',
    name: 'A link that works',
    about: 'Every cycle is right: the master measures the line delay and samples SLO after it.',
    setup: {},
  },
  {
    id: 'compensation',
    name: 'Long cable, no compensation',
    about: 'SLO comes more than 600 ns late, six clocks of 10 MHz; the master samples by its own clock, while SLO changes.',
    setup: { clock: '10MHz', cable: '60m', compensation: false, jitter: '15ns' },
  },
  {
    id: 'sampling',
    name: 'Sampling at the wrong moment',
    about: 'The cable delays SLO by half a clock, so that a master without compensation samples while SLO changes.',
    setup: { clock: '5MHz', cable: '6m', compensation: false, jitter: '5ns' },
  },
  {
    id: 'format',
    name: 'Wrong format',
    about: 'The encoder sends 26 bits and the master reads 32: it takes the CRC for position, and the frame ends too soon.',
    setup: { readAs: 'resolute-32' },
  },
  {
    id: 'bit',
    name: 'Bit errors',
    about: 'Noise inverts one bit in every twentieth frame; the CRC detects it, and shows which bit to correct.',
    setup: { faults: [{ kind: 'flip', rate: '0.05' }] },
  },
  {
    id: 'timeout',
    name: 'Timeout too short',
    about: 'The timeout of 400 ns is shorter than half a clock of 1 MHz: the encoder gives up before the frame begins.',
    setup: { clock: '1MHz', timeout: 'static:400ns' },
  },
  {
    id: 'start',
    name: 'Encoder too slow',
    about: 'In every tenth cycle START comes later than its data sheet allows, after the master has ended the frame.',
    setup: { faults: [{ kind: 'late_start', rate: '0.1' }] },
  },
  {
    id: 'cable',
    name: 'Loose contact',
    about: 'The cable is open for moments: frames are cut, and some requests have no answer.',
    setup: { faults: [{ kind: 'cut', rate: '0.03' }] },
  },
];
