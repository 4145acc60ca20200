// An encoder with registers for the examples: a description of its data sheet, from which the core
// builds the dump that a simulation answers from.
import { runVerb, writeFile } from '../core/verbs';

/** The dump, as arguments of `simulate` name it. */
export const demoDump = 'demo.hex';

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

/** Writes the dump if the arguments name it. */
export async function provideDump(args: readonly string[]): Promise<void> {
  if (!args.includes(demoDump)) return;
  await writeFile('demo.eds', new TextEncoder().encode(description));
  await runVerb(['eds', 'build', 'demo.eds', '-o', demoDump]);
}
