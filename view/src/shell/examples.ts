// Captures that the page simulates: examples, and the requests of the dialog.
import { splitArguments } from '../core/arguments';
import { fail, openFiles } from '../core/reading';
import { messageOf } from '../core/texts';
import { makeCapture, runToFile, runVerb, writeFile } from '../core/verbs';
import * as state from '../state';

export interface Example {
  name: string;
  about: string;
  /** Arguments of `biss simulate`, without -o. */
  args: string;
  /** Given to -f when it is opened; empty: found out. */
  format: string;
}

// An encoder with registers: a description of its data sheet, from which the core builds the dump that a
// simulation answers from. The arguments of `simulate` name it.
const demoDump = 'demo.hex';

const description = `
[registers]
EDS_BANK = 2
DEV_SN = 4711
DEV_ID = 0x44454D4F3100
MFR_ID = 0x5858

[common]
TMA = 100ns
TBUSY_MAX = 10us?
TO_MAX = 20us?
TCYC = 31.25us?
PON_DLY = 100ms?

[bp3]
PON_PDL = 50ms
EN_TYP = rotary
MT_LEN = 12 bit
MT_CNT = 4096
FI_LEN = 18 bit
SIP_CNT = 1
SIP_RES = 262144
SPD_MAX = 6000 1/min
TMP_MIN = 233 K
TMP_MAX = 378 K
VLT_MIN = 4500 mV
VLT_MAX = 5500 mV
CUR_MAX = 120 mA
`;

export const examples: readonly Example[] = [
  {
    name: 'A link that works',
    about: '26 bits, 10 MHz, 50 m of cable',
    args: '-f resolute-26 --clock 10MHz --cable 50m --cycles 2000 --motion sine --jitter 2ns',
    format: 'resolute-26',
  },
  {
    name: 'Noise and lost answers',
    about: 'flipped bits, glitches, no answer',
    args: '-f resolute-26 --clock 10MHz --cable 50m --cycles 2000 --motion ramp --fault flip:0.01'
      + ' --fault glitch_slo:0.005 --fault no_answer:0.004 --fault lost_clock:0.003 --seed 3',
    format: 'resolute-26',
  },
  {
    name: 'No line delay compensation',
    about: '60 m of cable at 10 MHz: every checksum is wrong at the master',
    args: '-f resolute-32 --clock 10MHz --cable 60m --no-compensation --jitter 15ns --cycles 1000',
    format: 'resolute-32',
  },
  {
    name: 'BiSS Safety',
    about: 'two words with sign of life; replayed and damaged frames',
    args: '-f fs-36-28 --clock 5MHz --cycles 1500 --fault flip:0.01 --fault repeat:0.004'
      + ' --fault loss:0.003 --seed 5',
    format: 'fs-36-28',
  },
  {
    name: 'Unknown encoder',
    about: 'multiturn; the format is found from the frames',
    args: '-f mt12,st20,nE,nW,crc6 --clock 4MHz --cable 10m --cycles 1500 --motion random',
    format: '',
  },
  {
    name: 'Registers and data sheet',
    about: 'a master that configures itself over CDM and CDS',
    args: `--registers ${demoDump} --configure --clock 5MHz`,
    format: 'mt12,st18,nE,nW,crc6',
  },
];

// The worker of the verbs has the capture that is open under its own name.
const madeName = 'new.vcd';
const fileName = 'simulated.vcd';

// Writes the dump if the arguments name it.
async function provideDump(args: readonly string[]): Promise<void> {
  if (!args.includes(demoDump)) return;
  await writeFile('demo.eds', new TextEncoder().encode(description));
  await runVerb(['eds', 'build', 'demo.eds', '-o', demoDump]);
}

let newest = 0;

/** Simulates with these arguments and opens the capture, unless a newer one has been requested. */
export async function openSimulated(args: string, format: string): Promise<void> {
  const own = ++newest;
  state.progress.value = { state: 'loading', done: 0 };
  try {
    const bytes = await makeCapture(async () => {
      const words = splitArguments(args);
      await provideDump(words);
      return runToFile(['simulate', ...words, '-o', madeName], madeName);
    });
    if (own !== newest) return;
    state.settings.value = { ...state.settings.value, format, ma: '', slo: '', invertMa: false, invertSlo: false };
    await openFiles([{ name: fileName, content: bytes }], args);
  } catch (error) {
    if (own !== newest) return;
    fail(messageOf(error));
  }
}

/** A running simulation is no longer opened. */
export function leaveSimulation(): void {
  newest += 1;
}
