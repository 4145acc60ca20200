// A session of rows alone, as biss.d.mts has it, for the tests of what the worker computes.

const columns = [
  { name: 'cycle', kind: 'unsigned', role: 'value' },
  { name: 'time_ns', kind: 'time', role: 'value' },
  { name: 'status', kind: 'text', role: 'status' },
  { name: 'position', kind: 'unsigned', role: 'value' },
  { name: 'nE', kind: 'flag', role: 'error_at_0' },
  { name: 'line_delay_ns', kind: 'time', role: 'value' },
  { name: 'ack_ns', kind: 'time', role: 'value' },
  { name: 'limits', kind: 'text', role: 'warnings' },
];
const arrays = { time: BigInt64Array, text: BigUint64Array, unsigned: BigUint64Array, flag: BigUint64Array };

/** Rows are objects by column; what is missing in them is an empty cell. Times are picoseconds. */
export function sessionOf(rows) {
  const written = rows.flatMap(({ status, limits }) => [status, limits]);
  const texts = [...new Set(written.filter((text) => text !== undefined))];
  return {
    columns,
    rowCount: rows.length,
    accesses: () => [],
    about: () => ({ endTime: String((rows.at(-1)?.time_ns ?? 0n) + 1000n) }),
    column(name, from, to) {
      const found = columns.find((column) => column.name === name);
      if (found === undefined) throw new RangeError(`no column ${name}`);
      const cells = rows.slice(from, to).map((row) => row[name]);
      const values = cells.map((cell) => {
        if (cell === undefined) return 0n;
        return found.kind === 'text' ? BigInt(texts.indexOf(cell)) : BigInt(cell);
      });
      return {
        kind: found.kind,
        present: Uint8Array.from(cells, (cell) => (cell === undefined ? 0 : 1)),
        values: arrays[found.kind].from(values),
        texts: found.kind === 'text' ? texts : found.kind === 'flag' ? ['0', '1'] : [],
      };
    },
  };
}

/** Rows of a sine with failures, 40 µs apart, with a pause now and then. */
export function manyRows(count) {
  let time = 20_000_000n;
  return Array.from({ length: count }, (_, i) => {
    time += i % 1000 === 999 ? 5_000_000_000n : 40_000_000n;
    const row = {
      cycle: BigInt(i),
      time_ns: time,
      status: i % 97 === 5 ? 'crc' : 'ok',
      line_delay_ns: 300_000n + BigInt(i % 7),
      ack_ns: 3_000_000n,
      limits: '',
    };
    if (row.status === 'ok') {
      row.position = BigInt(Math.round(1e6 * (1 + Math.sin(i / 500))));
      row.nE = i % 203 === 7 ? 0n : 1n;
    }
    return row;
  });
}
