// rp2040.mjs IMAGE.uf2 ENCODER.wasm: starts the example of the RP2040 in rp2040js, with encoders at
// the pins of SPI0, and checks what it writes. The RAM survives from one start to the next.
//
// rp2040js models processor, clocks, GPIO, DMA, UART and the registers of the SPI. It transfers
// bytes, so the eight clocks of each one are made here, at the rate and in the mode of the
// registers.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { ConsoleLogger, LogLevel, RP2040 } from 'rp2040js';
import { Line, starts } from './line.mjs';

const sck = 18;
const miso = 16;
const functionSpi = 1;
const driveLow = 2;
const longestNanos = 3e9;

/// Puts the blocks of a UF2 file into the flash.
function load(mcu, path) {
  const file = readFileSync(path);
  assert.equal(file.length % 512, 0, 'not a UF2 file');
  for (let at = 0; at < file.length; at += 512) {
    assert.equal(file.readUInt32LE(at), 0x0a324655, 'not a block of a UF2 file');
    assert.equal(file.readUInt32LE(at + 28), 0xe48bff56, 'not for an RP2040');
    const offset = file.readUInt32LE(at + 12) - 0x10000000;
    mcu.flash.set(file.subarray(at + 32, at + 32 + file.readUInt32LE(at + 16)), offset);
  }
}

/// The work of the ROM: checks the second stage of the boot loader, copies it to RAM, and calls it.
function boot(mcu) {
  let crc = 0xffffffff;
  for (const byte of mcu.flash.subarray(0, 252)) {
    crc = (crc ^ (byte << 24)) >>> 0;
    for (let i = 0; i < 8; ++i) crc = ((crc << 1) ^ (crc & 0x80000000 ? 0x04c11db7 : 0)) >>> 0;
  }
  assert.equal(crc, mcu.flashView.getUint32(252, true), 'CRC of the second stage');
  mcu.sram.set(mcu.flash.subarray(0, 256), 0x41f00);
  mcu.core.SP = 0x20042000;
  mcu.core.PC = 0x20041f00;
}

/// Connects the encoder to SPI0.
class SpiPins {
  constructor(mcu, line) {
    this.mcu = mcu;
    this.spi = mcu.spi[0];
    this.line = line;
    this.isConnected = false;
    this.bytes = 0;
    this.pauses = 0;
    this.end = 0;
    this.released = 0;
    this.slowestCdm = 0;
    this.alarm = mcu.clock.createAlarm(() => this.byteEnds());
    this.spi.onTransmit = () => this.byteBegins();
    const pin = mcu.gpio[sck];
    const update = pin.checkForUpdates.bind(pin);
    pin.checkForUpdates = () => {
      update();
      this.pinChanges();
    };
  }

  now() {
    return Math.round(this.mcu.clock.nanos * 1000);
  }

  connect() {
    const { spi, mcu } = this;
    assert.equal(spi.control0 & 0xff, 0xc7, 'SSPCR0: 8 bits, CPOL = 1, CPHA = 1');
    assert.equal(spi.control1, 2, 'SSPCR1: enabled, master');
    assert.equal(spi.dmaControl, 3, 'SSPDMACR: both directions');
    assert.equal(mcu.clkPeri, 125e6, 'clk_peri');
    this.isConnected = true;
  }

  byteBegins() {
    if (!this.isConnected) this.connect();
    this.period = 1e12 / this.spi.clockFrequency;
    const { gpio } = this.mcu;
    assert.equal(gpio[sck].functionSelect, functionSpi, 'SCK');
    assert.equal(gpio[miso].functionSelect, functionSpi, 'MISO');
    assert.equal(gpio[sck].outputOverride, 0, 'MA is held low in a transfer');
    const continues = this.end === this.now();
    if (!continues && this.bytes !== 0) ++this.pauses;
    this.begin = this.now();
    if (!continues) assert.ok(this.begin - this.released >= this.period / 2, 'MA was high for less than half a period');
    this.end = this.begin + 8 * this.period;
    this.alarm.schedule((this.end - this.mcu.clock.nanos * 1000) / 1000);
  }

  byteEnds() {
    const byte = this.line.clockByte(this.begin, this.period);
    ++this.bytes;
    this.spi.completeTransmit(byte);
    if (this.spi.busy) return;
    this.line.endTransfer();
    this.bytes = 0;
  }

  pinChanges() {
    if (!this.isConnected) return;
    assert.ok(!this.spi.busy, 'MA is driven in a transfer');
    const level = this.mcu.gpio[sck].outputOverride !== driveLow;
    if (level && !this.line.ma) this.released = this.now();
    if (!level) this.slowestCdm = Math.max(this.slowestCdm, this.now() - this.end);
    this.line.driveMa(this.now(), level);
  }
}

const [image, wasm] = process.argv.slice(2);
assert.ok(image && wasm, 'usage: rp2040.mjs IMAGE.uf2 ENCODER.wasm');
let ram = null;
for (const start of starts) {
  const mcu = new RP2040();
  mcu.logger = new ConsoleLogger(LogLevel.Error, true);
  load(mcu, image);
  if (ram) mcu.sram.set(ram);
  boot(mcu);
  const pins = new SpiPins(mcu, new Line(wasm, start));
  let text = '';
  mcu.uart[0].onByte = (byte) => {
    text += String.fromCharCode(byte);
  };

  while (!/^end, status \d+\n/m.test(text.slice(-40)) && mcu.clock.nanos < longestNanos) {
    for (let i = 0; i < 100000; ++i) {
      if (mcu.core.waiting) {
        mcu.clock.tick(mcu.clock.nanosToNextAlarm);
        // rp2040js wakes the processor for every interrupt but SysTick.
        if (mcu.core.pendingSystick && mcu.core.checkForInterrupts()) mcu.core.waiting = false;
      } else {
        mcu.clock.tick((mcu.core.executeInstruction() * 1e9) / mcu.clkSys);
      }
    }
  }
  process.stdout.write(text);
  assert.equal(pins.pauses, 0, 'the clock paused within a transfer');
  const result = pins.line.check(text);
  // The interrupts are masked while the format is derived from the record.
  assert.ok(result.late <= 1, 'requests that were not made');
  ram = mcu.sram;
  const latency = (pins.slowestCdm / 1e6).toFixed(1);
  console.log(`rp2040js: ready in cycle ${result.readyIn}, ${result.cycles} cycles as on the line; MA low for CDM after ${latency} us at most`);
}
