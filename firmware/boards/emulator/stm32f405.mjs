// stm32f405.mjs IMAGE.elf ENCODER.wasm: starts the example of the STM32F405 in QEMU and checks what
// it writes. Each start after the first one is a reset, which the RAM survives.
//
// QEMU's netduinoplus2 models processor, USART and the registers of the SPI. It has no DMA, no GPIO,
// and nothing at the lines of the SPI. Accesses to what it does not have are in its log: this
// script reads from there what the driver does with GPIOA and DMA2, makes the transfers with the
// encoder, writes the received bytes to the memory that the driver named, and raises the interrupt
// of the stream. Time on the line is the script's: the order of events is tested, times are not.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import net from 'node:net';
import { tmpdir } from 'node:os';
import path from 'node:path';
import readline from 'node:readline';
import { setTimeout as sleep } from 'node:timers/promises';
import { Line, starts } from './line.mjs';

const sck = 5;
const miso = 6;
const spi1 = 0x40013000;
const spiData = spi1 + 0x0c;
const dmaInterrupt = 56;
const microsecond = 1_000_000;
const cycle = 100 * microsecond;
/// From the end of a transfer to the next one, longer than the encoder's timeout.
const pause = 30 * microsecond;

/// QEMU's port for tests: reads and writes the memory of the board.
class Memory {
  constructor(socket) {
    this.socket = socket;
    this.waiting = [];
    // QEMU closes it at its end.
    socket.on('error', () => {});
    readline.createInterface({ input: socket }).on('error', () => {}).on('line', (answer) => this.waiting.shift()?.(answer));
  }
  async ask(command) {
    this.socket.write(`${command}\n`);
    const answer = await new Promise((resolve) => this.waiting.push(resolve));
    assert.match(answer, /^OK/, command);
    return Number(answer.split(' ')[1] ?? 0);
  }
  read(address) {
    return this.ask(`readl 0x${address.toString(16)}`);
  }
  write(address, bytes) {
    const hex = Buffer.from(bytes).toString('hex');
    return this.ask(`write 0x${address.toString(16)} 0x${bytes.length.toString(16)} 0x${hex}`);
  }
  setPending(interrupt) {
    const register = 0xe000e200 + (interrupt >> 5) * 4;
    return this.ask(`writel 0x${register.toString(16)} 0x${(2 ** (interrupt & 31)).toString(16)}`);
  }
  /// Resets the board by AIRCR.
  reset() {
    return this.ask('writel 0xe000ed0c 0x5fa0004');
  }
}

/// GPIOA, DMA2 and the lines of SPI1.
class Peripherals {
  constructor(memory, line) {
    this.memory = memory;
    this.line = line;
    this.registers = { GPIOA: new Map(), DMA2: new Map() };
    this.functions = 0;
    this.mode = 0;
    this.latch = true;
    this.time = cycle;
    this.begun = 0;
  }

  async write(device, offset, value) {
    this.registers[device].set(offset, value);
    if (device === 'GPIOA') this.pin(offset, value);
    if (device === 'DMA2' && offset === 0x58 && (value & 1) !== 0) await this.transfer();
  }

  pin(offset, value) {
    // QEMU reads these registers as 0, so the driver's other fields are lost.
    if (offset === 0x20) this.functions |= value;
    if (offset === 0x18 && (value >>> (sck + 16)) & 1) this.latch = false;
    if (offset === 0x18 && (value >>> sck) & 1) {
      this.latch = true;
      this.time = Math.max(this.time + pause, this.begun + cycle);
    }
    if (offset === 0x00 && (value >>> (2 * sck)) & 3) this.mode = (value >>> (2 * sck)) & 3;
    // As an alternate function, the pin is the idle clock of the SPI.
    if (this.mode !== 0) this.line.driveMa(this.time, this.mode === 1 ? this.latch : true);
  }

  async transfer() {
    const dma = (offset) => this.registers.DMA2.get(offset);
    const [receive, transmit] = [0x10, 0x58];
    // CHSEL 3 in both; from the peripheral with MINC, TCIE, TEIE and the highest priority; to it.
    assert.equal(dma(receive), 0x06030415, 'CR of stream 0');
    assert.equal(dma(transmit), 0x06000041, 'CR of stream 3');
    assert.equal(dma(receive + 0x08), spiData, 'PAR of stream 0');
    assert.equal(dma(transmit + 0x08), spiData, 'PAR of stream 3');
    assert.equal(dma(receive + 0x04), dma(transmit + 0x04), 'NDTR');
    assert.equal(this.mode, 2, 'MODER of SCK');
    assert.equal(this.functions, (5 << (4 * sck)) | (5 << (4 * miso)), 'AFRL: AF5');
    // CPHA, CPOL, master, on, SSI, SSM; BR: APB2 at 80 MHz, divided by 2, 4 ... 256.
    const control = await this.memory.read(spi1);
    assert.equal(control & ~0x38, 0x347, 'CR1 of SPI1');
    const period = 25_000 << ((control >> 3) & 7);
    assert.equal(await this.memory.read(spi1 + 4), 3, 'CR2 of SPI1');

    this.time += microsecond;
    this.begun = this.time;
    const bytes = new Uint8Array(dma(receive + 0x04));
    for (let i = 0; i < bytes.length; ++i, this.time += 8 * period) bytes[i] = this.line.clockByte(this.time, period);
    this.line.endTransfer();
    this.time += microsecond;
    await this.memory.write(dma(receive + 0x0c), bytes);
    await this.memory.setPending(dmaInterrupt);
  }
}

const [image, wasm] = process.argv.slice(2);
assert.ok(image && wasm, 'usage: stm32f405.mjs IMAGE.elf ENCODER.wasm');
const folder = mkdtempSync(path.join(tmpdir(), 'biss-stm32-'));
const socketPath = path.join(folder, 'qtest');
const server = net.createServer();
const connected = new Promise((resolve) => server.once('connection', resolve));
await new Promise((resolve) => server.listen(socketPath, resolve));
const qemu = spawn('qemu-system-arm', [
  ...['-M', 'netduinoplus2', '-accel', 'tcg', '-display', 'none', '-monitor', 'none', '-serial', 'stdio'],
  ...['-qtest', `unix:${socketPath}`, '-qtest-log', '/dev/null', '-d', 'unimp', '-kernel', image],
]);

let failure = null;
const stop = (error) => {
  failure ??= error ?? null;
  qemu.kill();
};
const limit = setTimeout(() => stop(new Error('the board did not end')), 120_000);
qemu.on('error', stop);
const exited = new Promise((resolve) => qemu.on('close', resolve));

const left = starts.map((start) => new Line(wasm, start));
let order = connected.then((socket) => new Peripherals(new Memory(socket), left.shift()));
let text = '';
qemu.stdout.on('data', (data) => {
  text += data;
  if (text.endsWith('end, status 0\n')) endStart().catch(stop);
  if (text.endsWith('end, status 1\n')) stop(new Error(text));
});

/// Checks what the board wrote, and resets it for the next start.
async function endStart() {
  // The last accesses may still be on their way from QEMU's log.
  await sleep(300);
  const { memory, line } = await order;
  process.stdout.write(text);
  const { readyIn, cycles } = line.check(text, { isLate: true });
  console.log(`QEMU: ready in cycle ${readyIn}, ${cycles} cycles as on the line; GPIOA and DMA2 made from the driver's accesses`);
  if (left.length === 0) return stop();
  text = '';
  order = Promise.resolve(new Peripherals(memory, left.shift()));
  await memory.reset();
}

const access = /^(GPIOA|DMA2): unimplemented device write \(size 4, offset (0x[0-9a-f]+), value (0x[0-9a-f]+)\)/;
readline.createInterface({ input: qemu.stderr }).on('line', (line) => {
  const match = access.exec(line);
  if (!match) return;
  const [device, offset, value] = [match[1], Number(match[2]), Number(match[3])];
  order = order.then(async (all) => {
    await all.write(device, offset, value);
    return all;
  });
  order.catch(stop);
});

await exited;
clearTimeout(limit);
rmSync(folder, { recursive: true });
if (failure) throw failure;
process.exit(0);
