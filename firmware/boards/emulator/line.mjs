// The line between a board and the encoder (encoder.cpp in WebAssembly), with faults, and the check
// of what the board wrote about it.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';

/// The bit of a transfer that is inverted to damage the position: 3 leading ones, ACK, START and CDS come
/// before the data.
const flippedBit = 20;

/// The fault of a transfer, by its number from 0.
function faultOf(transfer) {
  if (transfer % 401 === 31) return 'no_response';
  return transfer % 389 === 55 ? 'crc' : null;
}

/// The starts of a board, one after the other: the encoder that is connected, why it is asked, and
/// the most cycles of 100 us until it is ready.
export const starts = [
  { serial: 20260015, causes: ['record magic'], most: 12000 },
  { serial: 20260015, causes: [], most: 500 },
  { serial: 20260016, causes: ['other_encoder'], most: 12000 },
];

export class Line {
  /// \param wasm the encoder \param start of `starts`
  constructor(wasm, start) {
    const module = new WebAssembly.Module(readFileSync(wasm));
    const imports = { wasi_snapshot_preview1: { proc_exit: (code) => assert.fail(`encoder: exit ${code}`) } };
    this.encoder = new WebAssembly.Instance(module, imports).exports;
    this.encoder._initialize?.();
    this.encoder.power_on(start.serial);
    this.start = start;
    this.positions = [];
    this.byteNumber = 0;
    this.ma = true;
  }

  /// \param time picoseconds, here and below
  driveMa(time, level) {
    if (level === this.ma) return;
    this.ma = level;
    this.encoder.drive_ma(BigInt(time), level ? 1 : 0);
  }

  /// One byte of a transfer with this period of MA. Its first falling edge is at `time`.
  clockByte(time, period) {
    const clean = this.encoder.clock_byte(BigInt(time), BigInt(period));
    const fault = faultOf(this.positions.length);
    const number = this.byteNumber++;
    if (fault === 'no_response') return 0xff;
    if (fault === 'crc' && number === flippedBit >> 3) return clean ^ (0x80 >> (flippedBit & 7));
    return clean;
  }

  endTransfer() {
    this.positions.push(this.encoder.sampled());
    this.bytes = this.byteNumber;
    this.byteNumber = 0;
    this.encoder.do_ordered_work();
  }

  /// Compares the text of the board with the events on the line. A board that is slower than its
  /// timer may miss the cycles that pass while it writes a line.
  check(text, { isLate = false } = {}) {
    const lines = text.split('\n');
    const has = (line) => assert.ok(lines.includes(line), `missing: ${line}`);
    const { serial, causes, most } = this.start;
    assert.deepEqual(lines.filter((line) => line.startsWith('start: ')), causes.map((cause) => `start: ${cause}`));
    const ready = /^ready in cycle (\d+): transfer (\d+), checked from (\d+)$/m.exec(text);
    assert.ok(ready, 'not ready');
    const [readyIn, first, linked] = ready.slice(1).map(Number);
    assert.ok(readyIn < most || isLate, `ready in cycle ${readyIn}`);
    has(`serial number ${serial}, position bits 24, data bits 26, CRC bits 6, bytes ${this.bytes}`);

    const written = new Set();
    for (const line of lines) {
      const match = /^cycle (\d+) (?:position (\d+)|(\w+))$/.exec(line);
      if (!match) continue;
      const transfer = first + Number(match[1]) - 1;
      if (match[2]) assert.equal(Number(match[2]), this.positions[transfer], line);
      else if (match[3] !== 'late' || !isLate) assert.equal(match[3], match[1] === '1' ? 'first' : faultOf(transfer), line);
      written.add(transfer);
    }
    assert.ok(written.size > 15, 'positions');
    const counted = (name) => Number(new RegExp(`^(?:cycles.*, )?${name} (\\d+)`, 'm').exec(text)?.[1] ?? 0);
    const [cycles, good, late, early] = ['cycles', 'ok', 'late', 'not_ready'].map((name) => counted(name));
    const faults = { no_response: 0, crc: 0 };
    for (let transfer = linked; transfer < linked + cycles; ++transfer) {
      const fault = faultOf(transfer);
      if (!fault) continue;
      ++faults[fault];
      assert.ok(written.has(transfer) || transfer < first || isLate, `transfer ${transfer} has no cause`);
    }
    for (const [cause, count] of Object.entries(faults)) assert.equal(counted(cause), count, cause);
    assert.equal(counted('first'), 2);
    // After a late request, the next one comes too early. A slow request may still run.
    assert.ok(early <= late, 'not_ready');
    const running = cycles - good - 2 - early - faults.no_response - faults.crc;
    assert.ok(running === 0 || (isLate && running === 1), `${running} cycles without an end`);
    const bytes = [0x45, 0x58, 0x4d, 0x50, 0x4c, 0x31, 0x58, 0x58, 0, 1, 0x62, 0x1a];
    bytes.push(...[24, 16, 8, 0].map((shift) => (serial >> shift) & 255), ...new Array(32).fill(0));
    has(`registers${bytes.map((byte) => ` 0x${byte.toString(16)}`).join('')}`);
    has('end, status 0');
    return { readyIn, asked: linked, cycles, good, late };
  }
}
