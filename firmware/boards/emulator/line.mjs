// The line between a board and the encoder (encoder.cpp in WebAssembly), with faults, and the check
// of what the board wrote about it.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';

/// The bit of a transfer that is inverted to damage the position: 3 leading ones, ACK, START and CDS come
/// before the data.
const flippedBit = 20;

/// The faults and their cycles: the first ones while positions are read, the others while
/// registers are read and written.
const faults = new Map([
  [31, 'no_response'],
  [32, 'no_response'],
  [90, 'no_response'],
  [55, 'crc'],
  [121, 'crc'],
  [260, 'no_response'],
  [700, 'crc'],
  [1500, 'crc'],
]);

export class Line {
  /// \param wasm the encoder \param period of MA, picoseconds
  constructor(wasm, period) {
    const module = new WebAssembly.Module(readFileSync(wasm));
    const imports = { wasi_snapshot_preview1: { proc_exit: (code) => assert.fail(`encoder: exit ${code}`) } };
    this.encoder = new WebAssembly.Instance(module, imports).exports;
    this.encoder._initialize?.();
    this.period = BigInt(period);
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

  /// One byte of a transfer. Its first falling edge is at `time`.
  clockByte(time) {
    const clean = this.encoder.clock_byte(BigInt(time), this.period);
    const fault = faults.get(this.positions.length);
    const number = this.byteNumber++;
    if (fault === 'no_response') return 0xff;
    if (fault === 'crc' && number === flippedBit >> 3) return clean ^ (0x80 >> (flippedBit & 7));
    return clean;
  }

  endTransfer() {
    this.positions.push(this.encoder.sampled());
    this.byteNumber = 0;
    this.encoder.do_ordered_work();
  }

  /// Compares the text of the board with the events on the line. A board that is slower than its
  /// timer may miss the cycles that pass while it writes a line, and have a late request.
  check(text, { isLate = false } = {}) {
    const lines = text.split('\n');
    const count = (cause) => [...faults.values()].filter((each) => each === cause).length;
    let positions = 0;
    const written = new Set();
    for (const line of lines) {
      const position = /^cycle (\d+) position (\d+)$/.exec(line);
      if (position) {
        assert.equal(Number(position[2]), this.positions[Number(position[1]) - 1], line);
        ++positions;
        written.add(Number(position[1]));
        continue;
      }
      const bad = /^cycle (\d+) (\w+)$/.exec(line);
      if (!bad) continue;
      written.add(Number(bad[1]));
      if (isLate && bad[2] === 'late') continue;
      assert.equal(bad[2], bad[1] === '1' ? 'first' : faults.get(Number(bad[1]) - 1), line);
    }
    assert.equal(positions, 11, 'positions');
    for (const cycle of [...faults.keys()].filter((each) => each < 200)) {
      const missed = isLate && [0, 1, 2].some((before) => written.has(cycle - before));
      assert.ok(written.has(cycle + 1) || missed, `cycle ${cycle} has no cause`);
    }

    const has = (line) => assert.ok(lines.includes(line), `missing: ${line}`);
    has('registers 0x78 0x45 0x58 0x4d 0x50 0x4c 0x31 0x58 0x58');
    has('registers 0x40 0x0 0x1 0x62 0x1a 0x1 0x35 0x24 0xaf');
    has('serial number 20260015');
    has('data sheet: position bits 24, data bits 26, CRC bits 6, clock at most 5000000 Hz');
    has('the format is the one in use');
    assert.equal(lines.filter((line) => /^bank [12]( 0x[0-9a-f]+){64}$/.test(line)).length, 2, 'banks');
    const counted = (name) => Number(new RegExp(`^(?:cycles.*, )?${name} (\\d+)`, 'm').exec(text)?.[1] ?? 0);
    const [cycles, good, late] = ['cycles', 'ok', 'late'].map((name) => counted(name));
    assert.equal(counted('no_response'), count('no_response'));
    assert.equal(counted('crc'), count('crc'));
    assert.equal(counted('first'), 1);
    // A slow request may still run when the board counts.
    const running = cycles - good - 1 - faults.size;
    assert.ok(running === 0 || (isLate && running === 1), `${running} cycles without an end`);
    has('end, status 0');
    return { cycles, good, late };
  }
}
