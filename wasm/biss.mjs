// The core as a page and Node use it: see biss.d.mts. Nothing here reads a file or the network.
import createCore from './biss_core.mjs';

// Small reads are served from a block of this size.
const blockBytes = 1 << 20;

/** @type {import('./biss.d.mts').BissError} */
export class BissError extends Error {
  constructor(status, message) {
    super(message);
    this.name = 'BissError';
    this.status = status;
  }
}

// Reads of a source, small ones from the block around them.
class Blocks {
  #source;
  #start = 0;
  #block = new Uint8Array(0);

  constructor(source) {
    this.#source = source;
  }

  // At least one byte, unless `place` is at the end.
  read(place, length) {
    const left = this.#source.size - place;
    if (left <= 0) return new Uint8Array(0);
    if (length > blockBytes) return this.#source.read(place, Math.min(length, left));
    if (place < this.#start || place >= this.#start + this.#block.length) {
      this.#block = this.#source.read(place, Math.min(left, blockBytes));
      this.#start = place;
    }
    return this.#block.subarray(place - this.#start, place - this.#start + length);
  }
}

// The module, with its memory, and its standard output and error as files.
class Core {
  constructor(module) {
    this.module = module;
    for (const [descriptor, path] of [[1, '/out'], [2, '/err']]) {
      module.FS.close(module.FS.getStream(descriptor));
      module.FS.open(path, 'w');
    }
  }

  // Calls `use` with the value as JSON.
  withJson(value, use) {
    const { module } = this;
    const text = JSON.stringify(value);
    const bytes = module.lengthBytesUTF8(text) + 1;
    const at = module._malloc(bytes);
    module.stringToUTF8(text, at, bytes);
    try {
      return use(at);
    } finally {
      module._free(at);
    }
  }

  text(at) {
    return at === 0 ? undefined : this.module.UTF8ToString(at);
  }

  object(at) {
    return at === 0 ? undefined : JSON.parse(this.text(at));
  }

  // A copy: the memory of the core may move at any call.
  array(Type, at, count) {
    return new Type(this.module.HEAPU8.buffer, at, count).slice();
  }

  #take(descriptor, path) {
    const { FS } = this.module;
    const bytes = FS.readFile(path);
    FS.truncate(path, 0);
    FS.getStream(descriptor).position = 0;
    return bytes;
  }

  takeOut() {
    return this.#take(1, '/out');
  }

  takeErr() {
    return new TextDecoder().decode(this.#take(2, '/err'));
  }
}

class Session {
  #core;
  #session;
  #columns;

  constructor(core, session) {
    this.#core = core;
    this.#session = session;
    this.#columns = core.object(this.#call('columns'));
  }

  #call(name, ...args) {
    return this.#core.module[`_biss_${name}`](this.#session, ...args);
  }

  advance(milliseconds) {
    const more = this.#call('advance', milliseconds);
    const messages = this.#core.takeErr();
    if (more < 0) throw new BissError(3, messages);
    return { more: more !== 0, messages };
  }

  about() {
    return this.#core.object(this.#call('about'));
  }

  get columns() {
    return this.#columns;
  }

  get rowCount() {
    return this.#call('row_count');
  }

  #range(from, to) {
    const end = Math.max(0, Math.min(to, this.rowCount));
    return [Math.max(0, Math.min(from, end)), end];
  }

  csv(from, to) {
    return this.#core.text(this.#call('rows', ...this.#range(from, to)));
  }

  // No cell of the command holds a comma, a quote or a line feed.
  cells(from, to) {
    const lines = this.csv(from, to).split('\n').slice(1, -1);
    return lines.map((line) => line.split(','));
  }

  column(name, from, to) {
    const index = this.#columns.findIndex((column) => column.name === name);
    if (index < 0) throw new RangeError(`no column ${name}`);
    const [begin, end] = this.#range(from, to);
    const count = end - begin;
    const { kind } = this.#columns[index];
    const at = this.#call('column', index, begin, end);
    const present = this.#core.array(Uint8Array, this.#core.module._biss_present(), count);
    if (kind === 'bits') return { kind, present, values: new BigUint64Array(0), texts: [] };
    const Type = { real: Float64Array, time: BigInt64Array, signed: BigInt64Array }[kind];
    const values = this.#core.array(Type ?? BigUint64Array, at, count);
    if (kind === 'text') return { kind, present, values, texts: this.#core.object(this.#call('column_texts', index)) };
    return { kind, present, values, texts: kind === 'flag' ? ['0', '1'] : [] };
  }

  view(line, from, to, columns) {
    if (to <= from || columns < 1) throw new RangeError('an empty view');
    const count = this.#call('view', line === 'ma' ? 1 : 0, from, to, columns);
    return {
      times: this.#core.array(BigInt64Array, this.#core.module._biss_view_times(), count),
      levels: this.#core.array(Uint8Array, this.#core.module._biss_view_levels(), count),
    };
  }

  accesses(from, to) {
    const text = this.#core.text(this.#call('accesses', from, Math.max(from, to)));
    return text.split('\n').filter((line) => line !== '').map((line) => JSON.parse(line));
  }

  summary() {
    return this.#core.text(this.#call('summary'));
  }

  cycle(row, number = -1) {
    if (row < 0 || row >= this.rowCount) throw new RangeError(`no row ${row}`);
    return this.#core.object(this.#call('cycle', row, number));
  }

  close() {
    if (this.#session !== 0) this.#call('close');
    this.#session = 0;
  }
}

// A command line as the core takes it: the words, and the values of each option.
function requestOf(command, args) {
  const request = { words: [], options: [] };
  const left = [...args];
  let verb = command;
  let isWord = () => false;
  for (let word = left.shift(); word !== undefined; word = left.shift()) {
    const [, long, longValue, short, shortValue] = /^(--[^=]+)(?:=(.*))?$|^(-[^-])(.+)?$/s.exec(word) ?? [];
    const [name, value] = [long ?? short, longValue ?? shortValue];
    if (word === '--') {
      isWord = () => true;
    } else if (name === undefined || isWord()) {
      request.words.push(word);
      verb = verb.verbs.find((each) => each.name === word) ?? verb;
    } else {
      const option = verb.options.find(({ names }) => names.split(',').includes(name));
      const isNext = value === undefined && option?.value && left.length > 0;
      request.options.push([option?.name ?? name, isNext ? [left.shift()] : value === undefined ? [] : [value]]);
    }
  }
  return request;
}

class Biss {
  #core;
  #verbs;

  constructor(module) {
    this.#core = new Core(module);
    module.FS.mkdir('/captures');
    module.FS.chdir('/captures');
  }

  addFile(name, source) {
    const { FS } = this.#core.module;
    if (name.includes('/')) throw new RangeError(`a name without folder, not ${name}`);
    this.removeFile(name);
    if (source instanceof Uint8Array) {
      FS.writeFile(`/captures/${name}`, source);
      return;
    }
    const node = FS.createFile('/captures', name, {}, true, false);
    const blocks = new Blocks(source);
    Object.defineProperty(node, 'usedBytes', { get: () => source.size });
    node.stream_ops = {
      llseek: node.stream_ops.llseek,
      read(stream, buffer, offset, length, position) {
        let bytes;
        try {
          bytes = blocks.read(position, length);
        } catch {
          const inputOutputError = 29;
          throw new FS.ErrnoError(inputOutputError);
        }
        buffer.set(bytes, offset);
        return bytes.length;
      },
    };
  }

  removeFile(name) {
    const { FS } = this.#core.module;
    const path = `/captures/${name}`;
    if (FS.analyzePath(path).exists) FS.unlink(path);
  }

  fileNames() {
    const { FS } = this.#core.module;
    return FS.readdir('/captures').filter((name) => FS.isFile(FS.stat(`/captures/${name}`).mode));
  }

  readFile(name) {
    return this.#core.module.FS.readFile(`/captures/${name}`);
  }

  words() {
    return this.#core.object(this.#core.module._biss_words());
  }

  verbs() {
    this.#verbs ??= this.#core.object(this.#core.module._biss_verbs());
    return this.#verbs;
  }

  run(args) {
    const status = this.#core.withJson(requestOf(this.verbs(), args), (request) =>
      this.#core.module._biss_run(request));
    return { status, out: this.#core.takeOut(), err: this.#core.takeErr() };
  }

  open(args, { anyLines = false } = {}) {
    const session = this.#core.withJson(requestOf(this.verbs(), ['decode', ...args]), (request) =>
      this.#core.module._biss_open(request, anyLines ? 1 : 0));
    const out = new TextDecoder().decode(this.#core.takeOut());
    const messages = this.#core.takeErr();
    const status = session === 0 ? 3 : this.#core.module._biss_status(session);
    if (session !== 0 && status === 0 && out === '') {
      return { session: new Session(this.#core, session), messages };
    }
    if (session !== 0) this.#core.module._biss_close(session);
    throw new BissError(status, messages || out);
  }
}

export async function loadBiss(options = {}) {
  return new Biss(await createCore(options));
}
