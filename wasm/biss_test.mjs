// The page's core against the command: the same captures, the same rows, words and exit status.
// Needs BISS (the command) and BISS_WASM (the folder with biss.mjs); BISS_SEEDS may name a folder
// with further hostile files.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, afterEach, before, describe, it } from 'node:test';
import { pathToFileURL } from 'node:url';

const command = path.resolve(process.env.BISS);
const built = path.resolve(process.env.BISS_WASM);
const { BissError, loadBiss } = await import(pathToFileURL(path.join(built, 'biss.mjs')));
const wasmBinary = fs.readFileSync(path.join(built, 'biss_core.wasm'));
const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'biss-wasm-'));
after(() => fs.rmSync(folder, { recursive: true }));

function native(args) {
  const ran = spawnSync(command, args, { cwd: folder, maxBuffer: 1 << 30 });
  assert.equal(ran.error, undefined);
  return { status: ran.status, out: ran.stdout, err: ran.stderr.toString() };
}

// A file of the folder, pulled in pieces as a worker does.
function pulled(name) {
  const descriptor = fs.openSync(path.join(folder, name));
  const source = {
    size: fs.fstatSync(descriptor).size,
    most: 0,
    read(offset, length) {
      source.most = Math.max(source.most, length);
      const into = new Uint8Array(length);
      return into.subarray(0, fs.readSync(descriptor, into, 0, length, offset));
    },
    close: () => fs.closeSync(descriptor),
  };
  return source;
}

function text(bytes) {
  return new TextDecoder().decode(bytes);
}

function assertSameRun(biss, args) {
  const expected = native(args);
  const ran = biss.run(args);
  const of = args.join(' ');
  assert.equal(ran.err, expected.err, `stderr of ${of}`);
  assert.equal(ran.status, expected.status, `status of ${of}`);
  assert.equal(text(ran.out), text(expected.out), `stdout of ${of}`);
}

// zstd reads words of another size here, so it detects damaged data a bit earlier or later.
function assertSameStatus(biss, args) {
  const expected = native(args);
  const ran = biss.run(args);
  const of = args.join(' ');
  assert.equal(ran.status, expected.status, `status of ${of}\n${ran.err}${expected.err}`);
  assert.equal(/^biss: /m.test(ran.err), /^biss: /m.test(expected.err), `${ran.err}${expected.err}`);
}

// Reads to the end in steps of a millisecond.
function readAll(session) {
  let messages = '';
  for (;;) {
    const step = session.advance(1);
    messages += step.messages;
    if (!step.more) return messages;
  }
}

const resolute = ['-f', 'resolute-26'];
const formats = ['resolute-26', 'mt12,st20,nE,nW,lc6,crc16', 'pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0'];
const extensions = ['vcd', 'csv', 'sr', 'vcd.gz', 'csv.zst'];
const compressors = { '.gz': ['gzip', '-kf'], '.zst': ['zstd', '-qf'] };
const faults = [[], ['--fault', 'flip:0.05', '--fault', 'lost_clock:0.02'], ['--fault', 'slo_low:0.05', '--fault', 'burst:0.05', '--cable', '20m', '--jitter', '20ns'],
  ['--fault', 'glitch_slo:0.05', '--fault', 'cut:0.02', '--fault', 'no_answer:0.05']];

// Makes a capture with the command. Returns the name of its file.
function simulated(stem, extension, ...args) {
  const packed = Object.keys(compressors).find((end) => extension.endsWith(end));
  const name = `${stem}.${packed ? extension.slice(0, -packed.length) : extension}`;
  const made = native(['simulate', ...args, '-o', name]);
  assert.equal(made.status, 0, made.err);
  if (!packed) return name;
  const [program, options] = compressors[packed];
  assert.equal(spawnSync(program, [options, name], { cwd: folder }).status, 0, program);
  return `${name}${packed}`;
}

// Every format, extension and fault, with a seed of its own.
function* captures() {
  let seed = 0;
  for (const format of formats) {
    for (const extension of extensions) {
      for (const fault of faults) {
        seed += 1;
        yield { format,
          name: simulated(`capture${seed}`, extension, '-f', format, '--cycles', '150',
            '--motion', 'random', '--seed', `${seed}`, ...fault) };
      }
    }
  }
}

let biss;
before(async () => {
  biss = await loadBiss({ wasmBinary });
});

// A session of a file of the folder, read to its end and closed after the test.
let sessions = [];
function read(name, ...options) {
  biss.addFile(name, pulled(name));
  const { session } = biss.open([name, ...options]);
  sessions.push(session);
  readAll(session);
  return session;
}
afterEach(() => {
  for (const session of sessions) session.close();
  sessions = [];
});

// A file of an oscilloscope: two lines that change.
function voltages() {
  const rows = Array.from({ length: 2000 }, (_, i) =>
    `${(i * 1e-8).toFixed(8)},${i % 40 < 20 ? 3.3 : 0.1},${i % 160 < 80 ? 3.2 : 0.0}`);
  return `Time,MA,SLO\n${rows.join('\n')}\n`;
}

describe('a session', () => {
  it('SimulatedCaptures_EveryRowAndTheSummaryAreThoseOfTheCommand', () => {
    let rows = 0;
    for (const { name, format } of captures()) {
      const source = pulled(name);
      biss.addFile(name, source);
      for (const args of [[name], [name, '-f', format], [name, '-f', 'none']]) {
        const expected = native(['decode', ...args, '--to', 'csv']);
        const { session, messages } = biss.open(args);
        const all = messages + readAll(session);
        assert.equal(session.csv(0, session.rowCount), text(expected.out), args.join(' '));
        assert.equal(all, expected.err, args.join(' '));
        assert.equal(session.about().status, expected.status);
        assert.ok(all.endsWith(session.summary()) || all.includes(session.summary()));
        rows += session.rowCount;
        session.close();
      }
      biss.removeFile(name);
      source.close();
    }
    assert.ok(rows > 10_000, `${rows} rows`);
  });

  it('Columns_HaveTheValuesOfTheCells', () => {
    const format = ['-f', 'mt12,st20,nE,nW,lc6,crc16'];
    const session = read(simulated('columns', 'vcd', ...format, '--cycles', '200', '--fault', 'flip:0.2'),
      ...format, '--scale', 'deg', '--velocity', '--unwrap');
    const cells = session.cells(0, session.rowCount);
    session.columns.forEach((column, index) => {
      const { kind, present, values, texts } = session.column(column.name, 0, session.rowCount);
      cells.forEach((row, i) => {
        const cell = row[index];
        assert.equal(present[i] !== 0, cell !== '', `${column.name} of row ${i}`);
        if (cell === '' || kind === 'bits') return;
        if (kind === 'text') assert.equal(texts[Number(values[i])], cell);
        else if (kind === 'real') assert.equal(values[i], Number(cell));
        else if (kind === 'time') assert.equal(Number(values[i]) / 1000, Number(cell));
        else assert.equal(String(values[i]), cell);
      });
    });
    assert.equal(session.column('status', 5, 8).present.length, 3);
    assert.throws(() => session.column('nothing', 0, 1), RangeError);
  });

  it('Columns_SayWhatTheirValuesMean', () => {
    const format = 'mt12,st20,nE,nW,crc6+pos12,nE,nW,crc6';
    native(['simulate', '-f', format, '--cycles', '20', '-o', 'roles.vcd']);
    biss.addFile('roles.vcd', fs.readFileSync(path.join(folder, 'roles.vcd')));
    const columnsWith = (options) => {
      const { session } = biss.open(['roles.vcd', '-f', format, '--velocity', ...options]);
      const { columns } = session;
      session.close();
      return columns;
    };
    const columns = columnsWith([]);
    const named = (wanted) => columns.filter(({ role }) => role === wanted).map(({ name }) => name);
    assert.deepEqual(['status', 'verdict', 'warnings', 'error_at_0', 'check_at_0', 'warning_at_0', 'warning_at_1'].map(named),
      [['status'], ['safety'], ['limits'], ['nE', 'nE2'], ['crc_ok', 'crc2_ok'], ['nW', 'nW2'], ['marginal']]);
    for (const { name, kind, role, title, plot } of columns) {
      assert.equal(/_at_[01]$/.test(role), kind === 'flag', name);
      assert.equal(title !== '', role !== 'value' || plot > 0, name);
    }
    const plots = (of) => of.filter(({ plot }) => plot > 0).sort((a, b) => a.plot - b.plot).map(({ name }) => name);
    assert.deepEqual(plots(columns),
      ['position', 'velocity_counts_s', 'position2', 'line_delay_ns', 'ack_ns', 'clock_hz']);
    assert.deepEqual(plots(columnsWith(['--scale', 'deg'])).slice(0, 3), ['position_deg', 'velocity_deg_s', 'position2']);
  });

  it('Lines_ShowTheChangesOfTheFile', () => {
    const session = read(simulated('lines', 'csv', ...resolute, '--cycles', '40', '--fault', 'glitch_slo:0.3'), ...resolute);
    const rows = fs.readFileSync(path.join(folder, 'lines.csv'), 'utf8').trim().split('\n');
    const names = rows[0].split(',');
    for (const line of ['ma', 'slo']) {
      const index = names.findIndex((name) => name.toLowerCase() === line);
      const changes = [];
      for (const row of rows.slice(1)) {
        const cells = row.split(',');
        const [whole, fraction = ''] = cells[0].split('.');
        const time = BigInt(whole + fraction.padEnd(3, '0'));
        if (changes.at(-1)?.level !== Number(cells[index])) changes.push({ time, level: Number(cells[index]) });
      }
      const first = changes[0].time;
      const last = changes.at(-1).time + 1n;
      const view = session.view(line, first, last, 100_000_000);
      assert.deepEqual([...view.times], changes.map((change) => change.time));
      assert.deepEqual([...view.levels], changes.map((change) => change.level));
      const far = session.view(line, first, last, 50);
      assert.ok(far.times.length <= 150 && far.levels.includes(3));
    }
  });

  it('Cycle_IsDrawnAsByExplain', () => {
    const session = read(simulated('drawn', 'vcd', ...resolute, '--cycles', '60', '--fault', 'flip:0.3'), ...resolute);
    for (const row of [0, 1, 17, 59]) {
      const expected = native(['explain', 'drawn.vcd', '-f', 'resolute-26', '--cycle', `${row}`]);
      const cycle = session.cycle(row);
      assert.equal(`${cycle.title}\n${cycle.text}`, text(expected.out), `cycle ${row}`);
      assert.equal(cycle.status, session.cells(row, row + 1)[0][2]);
    }
  });

  it('Cycle_HasThePartsThatDrawPrints', () => {
    const session = read(simulated('parts', 'vcd', '-f', 'fs-36-28', '--cycles', '40', '--fault', 'flip:0.2'), '-f', 'fs-36-28');
    for (const row of [0, 5, 11, 38]) {
      const svg = text(native(['draw', 'parts.vcd', '-f', 'fs-36-28', '--cycle', `${row}`, '--to', 'svg']).out);
      const [, drawn] = /<desc id="description">(.*?)<\/desc>/s.exec(svg);
      const { tracks, failures } = session.cycle(row);
      const said = ['frame', 'delay', 'CDM'].filter((name) => name in tracks)
        .map((name) => `${name}: ${tracks[name].map((part) => part.text).join('; ')}.`);
      const failed = failures.map((failure) => `Failure: ${failure.text}.`);
      assert.ok(drawn.endsWith([...said, ...failed].join(' ').replaceAll('µs', 'us')), `${drawn}\n${said}`);
    }
  });

  it('Cycle_HasTheBitOfTheMasterAndTheRelease', () => {
    const session = read(simulated('bits', 'vcd', ...resolute, '--cycles', '120', '--access', 'read:0x42'), ...resolute);
    const seen = new Set();
    for (let row = 12; row < 40; row += 3) {
      const drawn = text(native(['draw', 'bits.vcd', '-f', 'resolute-26', '--cycle', `${row}`, '--to', 'svg']).out);
      const { cdm, release } = session.cycle(row);
      assert.equal(cdm, Number(/CDM=(\d)/.exec(drawn)[1]), `cycle ${row}`);
      const timeout = Number(/timeout ([\d.]+) us/.exec(drawn)[1]);
      assert.ok(Math.abs(Number(release) / 1e6 - timeout) < 0.001, `cycle ${row}: ${release} ps, ${timeout} us`);
      seen.add(cdm);
    }
    assert.deepEqual([...seen].sort(), [0, 1]);
  });

  it('CyclesThatAreSkipped_DoNotChangeTheNumbers', () => {
    const session = read('bits.vcd', ...resolute, '--since', '1ms');
    const number = Number(session.cells(3, 4)[0][0]);
    assert.ok(number > 3);
    assert.equal(session.cycle(3).number, number);
    assert.match(session.cycle(3).title, new RegExp(`^cycle ${number} at `));
  });

  it('Accesses_AreTheRowsOfRegisters', () => {
    simulated('accesses', 'vcd', ...resolute, '--cycles', '1200', '--access', 'read:0x42,3', '--access', '0,3/command:channels',
      '--access', 'write:0x10=AB');
    const expected = text(native(['registers', 'accesses.vcd', '-f', 'resolute-26', '--to', 'jsonl']).out)
      .trimEnd().split('\n').map((line) => JSON.parse(line));
    assert.ok(expected.length > 3);
    const session = read('accesses.vcd', ...resolute);
    assert.equal(session.about().accesses, expected.length);
    assert.deepEqual(session.accesses(0, 1200), expected);
    for (const from of [0, 20, 60, 200]) {
      const within = expected.filter(({ cycle, cycles }) => cycle < from + 30 && cycle + cycles > from);
      assert.deepEqual(session.accesses(from, from + 30), within, `from ${from}`);
    }
  });

  it('About_NamesTheFormatAndWhatTheLinesAre', () => {
    simulated('about', 'vcd', ...resolute, '--cycles', '600', '--motion', 'random');
    native(['convert', 'about.vcd', 'about.sr', '--rate', '100MHz']);
    const named = read('about.vcd', ...resolute).about();
    assert.deepEqual([named.formatName, named.format, named.lineKind], ['resolute-26', 'pos26,nE,nW,crc6;cds0', 'changes']);
    const found = read('about.sr').about();
    assert.equal(found.formatName, undefined);
    assert.ok(found.encoders.includes('resolute-26'));
    assert.equal(found.lineKind, 'samples');
    fs.writeFileSync(path.join(folder, 'volts.csv'), voltages());
    biss.addFile('volts.csv', pulled('volts.csv'));
    assert.equal(biss.open(['volts.csv', '-f', 'none'], { anyLines: true }).session.about().lineKind, 'voltages');
  });

  it('LargeFile_IsReadInPiecesAndGivesRowsBeforeItsEnd', () => {
    native(['simulate', '-f', 'resolute-26', '--cycles', '20000', '-o', 'large.vcd']);
    const source = pulled('large.vcd');
    assert.ok(source.size > 8 << 20, `${source.size} bytes`);
    biss.addFile('large.vcd', source);
    const { session } = biss.open(['large.vcd', '-f', 'resolute-26']);
    const { more } = session.advance(1);
    assert.ok(more && session.rowCount > 0 && session.rowCount < 20_000);
    assert.ok(source.most <= 4 << 20, `a block of ${source.most} bytes`);
    readAll(session);
    assert.equal(session.rowCount, 20_000);
    session.close();
  });

  it('LinesThatAreNotFound_ThrowTheMessageOfTheCommand', () => {
    fs.writeFileSync(path.join(folder, 'idle.csv'), 'time_ns,A,B\n0,1,1\n100,0,1\n200,1,1\n');
    biss.addFile('idle.csv', pulled('idle.csv'));
    const expected = native(['decode', 'idle.csv']);
    assert.throws(() => biss.open(['idle.csv']), (error) => {
      assert.ok(error instanceof BissError);
      assert.equal(error.message, expected.err);
      assert.equal(error.status, expected.status);
      return true;
    });
    const { session } = biss.open(['idle.csv'], { anyLines: true });
    readAll(session);
    assert.equal(session.about().ma, 'A');
    assert.equal(session.view('ma', 0n, 300_000n, 100).times.length, 3);
    session.close();
  });

  it('WrongOption_ThrowsTheMessageOfTheCommand', () => {
    const expected = native(['decode', 'idle.csv', '-f', 'pos26,nothing']);
    assert.throws(() => biss.open(['idle.csv', '-f', 'pos26,nothing']), { message: expected.err, status: 2 });
  });
});

describe('the verbs', () => {
  it('Verbs_PrintWhatTheCommandPrints', () => {
    native(['simulate', '-f', 'fs-36-28', '--cycles', '300', '--fault', 'flip:0.05', '-o', 'verbs.vcd']);
    biss.addFile('verbs.vcd', pulled('verbs.vcd'));
    for (const args of [
      ['identify', 'verbs.vcd', '--to', 'jsonl'],
      ['identify', 'verbs.vcd'],
      ['check', 'verbs.vcd', '--against', 'renishaw', '-f', 'fs-36-28', '--to', 'jsonl'],
      ['check', 'verbs.vcd', '--against', 'biss-c', '--to', 'jsonl'],
      ['explain', 'verbs.vcd', '-f', 'fs-36-28', '--to', 'jsonl'],
      ['explain', 'verbs.vcd', '-f', 'fs-36-28', '--cycle', '7'],
      ['decode', 'verbs.vcd', '-f', 'fs-36-28', '--to', 'jsonl'],
      ['decode', 'verbs.vcd', '-f', 'fs-36-28'],
      ['safety', 'analyse', '-f', 'pos26,nE,nW,crc6'],
      ['plan', '-f', 'resolute-26', '--clock', '10MHz', '--cable', '50m'],
      ['crc', '-f', 'pos26,nE,nW,crc6', '12345'],
      ['encoders', '--to', 'jsonl'],
      ['decode', '--help'],
      ['decode', 'missing.vcd'],
      ['decode', 'verbs.vcd', '--nothing'],
    ]) {
      assertSameRun(biss, args);
    }
    biss.removeFile('verbs.vcd');
  });

  it('EveryTextOfADevice_MeansWhatItMeansInTheCommand', () => {
    const texts = new URL('../tests/devices/texts.tsv', import.meta.url);
    for (const line of fs.readFileSync(texts, 'utf8').trimEnd().split('\n')) {
      const [device, format, ack, timeout] = line.split('\t');
      const ran = biss.run(['plan', '-f', device, '--clock', '1MHz', '--to', 'jsonl']);
      assert.equal(ran.status, format === '-' ? 2 : 0, device);
      if (format === '-') continue;
      const row = JSON.parse(text(ran.out));
      assert.deepEqual([row.format, row.ack_ns, row.timeout_ns], [format, Number(ack), Number(timeout)], device);
    }
  });

  it('Simulate_MakesTheCaptureOfTheCommand', () => {
    for (const name of ['made.vcd', 'made.csv', 'made.sr']) {
      const args = ['simulate', '-f', 'resolute-26', '--cycles', '50', '--seed', '7',
        '--fault', 'flip:0.1', '--cable', '50m', '-o', name];
      assertSameRun(biss, args);
      const made = biss.readFile(name);
      assert.deepEqual(Buffer.from(made), fs.readFileSync(path.join(folder, name)));
      biss.removeFile(name);
    }
  });

  it('Hdf5_IsRefusedByName', () => {
    native(['simulate', '-f', 'resolute-26', '--cycles', '5', '-o', 'five.vcd']);
    biss.addFile('five.vcd', pulled('five.vcd'));
    const ran = biss.run(['decode', 'five.vcd', '-f', 'resolute-26', '--to', 'hdf5', '-o', 'rows.h5']);
    assert.equal(ran.status, 3);
    assert.match(ran.err, /no HDF5/);
  });
});

// A generator with a fixed seed.
function generator(seed) {
  let state = seed;
  return (below) => {
    state = (Math.imul(state, 1_664_525) + 1_013_904_223) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
}

// Cuts, flips, repeats and removes bytes.
function damaged(bytes, next) {
  const result = Buffer.from(bytes);
  switch (next(4)) {
    case 0:
      return result.subarray(0, next(result.length));
    case 1:
      for (let i = 0; i <= next(8); i += 1) result[next(result.length)] = next(256);
      return result;
    case 2: {
      const at = next(result.length);
      return Buffer.concat([result.subarray(0, at), result.subarray(next(at + 1))]);
    }
    default: {
      const at = next(result.length);
      return Buffer.concat([result.subarray(0, at), result.subarray(at + next(64))]);
    }
  }
}

describe('hostile files', () => {
  const decodeArgs = (name) => (/\.(raw|bin)$/.test(name)
    ? ['decode', name, '--raw-rate', '100MHz', '--to', 'csv'] : ['decode', name, '--to', 'csv']);

  it('DamagedCaptures_GiveTheRowsAndTheMessageOfTheCommand', () => {
    const next = generator(14);
    const assertSame = { 'csv.zst': assertSameStatus };
    for (const extension of extensions) {
      const made = simulated('whole', extension, '-f', 'resolute-26', '--cycles', '20');
      const whole = fs.readFileSync(path.join(folder, made));
      for (let i = 0; i < 60; i += 1) {
        const name = `damaged${i}.${extension}`;
        fs.writeFileSync(path.join(folder, name), damaged(whole, next));
        biss.addFile(name, pulled(name));
        (assertSame[extension] ?? assertSameRun)(biss, decodeArgs(name));
        biss.removeFile(name);
      }
    }
  });

  it('SeedsOfTheFuzzTargets_GiveTheMessageOfTheCommand', { skip: process.env.BISS_SEEDS === undefined && 'BISS_SEEDS is not set' }, () => {
    const extensions = { vcd: 'vcd', event_csv: 'csv', sampled_csv: 'csv', saleae: 'csv',
      saleae_binary: 'bin', saleae_analog: 'bin', sr: 'sr', dsl: 'dsl', compressed: 'gz', fst: 'fst', raw: 'raw' };
    for (const [target, extension] of Object.entries(extensions)) {
      const seeds = path.join(process.env.BISS_SEEDS, target);
      for (const seed of fs.readdirSync(seeds)) {
        const name = `${target}_${seed}.${extension}`;
        fs.copyFileSync(path.join(seeds, seed), path.join(folder, name));
        biss.addFile(name, pulled(name));
        assertSameRun(biss, decodeArgs(name));
        biss.removeFile(name);
      }
    }
  });

  it('FileThatCannotBeRead_IsNamed', () => {
    biss.addFile('gone.vcd', { size: 1000, read() { throw new Error('gone'); } });
    const ran = biss.run(['decode', 'gone.vcd']);
    assert.equal(ran.status, 3);
    assert.match(ran.err, /gone\.vcd: cannot be read further/);
  });
});
