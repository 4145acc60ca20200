import array
import os
import sys
import threading

import numpy
import sigrokdecode as srd

from . import library

'''
OUTPUT_PYTHON format:

Packet:
['ROW', row]: a request cycle, from the first edge of MA to the last one. `row` is a dict with the
columns of `biss decode`, None where a cell is empty.
['ACCESS', access]: an access to a register, or a command; a dict with the columns of
`biss registers`.
'''

PICOSECONDS = 10 ** 12
# The library counts samples up to this rate. Edges of faster ones, as of a VCD file with the timescale
# 1 ps, get their times here.
COUNTED_RATE = (1 << 32) - 1
# Edges that are decoded at a time.
BLOCK = 8192
LEVELS = {(ma, slo): ma | slo << 1 for ma in (0, 1) for slo in (0, 1)}
# The most edges to keep for results that need the whole capture: 9 bytes each.
KEPT_EDGES = 1 << 25
# If a capture has more edges, a pause does not show the last rows.
PAUSED_EDGES = 1 << 22
# If no data comes for this time, in seconds, the rows so far are shown.
PAUSE = 0.5

ANNOTATIONS = (
    ('request', 'Request'), ('ack', 'ACK'), ('start', 'START'), ('cds', 'CDS'),
    ('data', 'Position'), ('flag', 'nE, nW'), ('lc', 'Sign of life'), ('crc', 'CRC'),
    ('stop', 'STOP'), ('timeout', 'Timeout'), ('other', 'Other bits'), ('wrong', 'Wrong field'),
    ('line-delay', 'Line delay'), ('cdm', 'CDM'),
    ('access', 'Register access'), ('access-failed', 'Failed access'),
    ('position', 'Position, good frame'), ('cause', 'Cause'),
    ('safety', 'Safety state'), ('safety-fault', 'Safety fault'), ('limit', 'Limit exceeded'),
)
CLASS = {name: number for number, (name, _) in enumerate(ANNOTATIONS)}
FIELDS = {'request': 'request', 'ACK': 'ack', 'no ACK': 'wrong', 'START': 'start', 'CDS': 'cds',
          'pos': 'data', 'mt': 'data', 'st': 'data', 'nE': 'flag', 'nW': 'flag', 'E': 'flag',
          'W': 'flag', 'lc': 'lc', 'crc': 'crc', 'STOP': 'stop', 'timeout': 'timeout',
          'line delay': 'line-delay', 'CDM': 'cdm'}
SAFETY_STATES = ('safe', 'starting', 'latched', 'failed')


class SamplerateError(Exception):
    pass


class InputError(Exception):
    pass


def text_of(value, is_time):
    '''As `biss decode --to csv` writes it.'''
    if not isinstance(value, float):
        return '' if value is None else str(value)
    if is_time:
        return ('%.3f' % value).rstrip('0').rstrip('.')
    # The fewest digits that give the same number again, with an exponent if that is shorter.
    fixed = '%.0f' % value if value.is_integer() else numpy.format_float_positional(value, trim='-')
    return min(fixed, numpy.format_float_scientific(value, trim='-', exp_digits=2), key=len)


def colons(text):
    '''sigrok-cli keeps commas and colons for itself: @ is a colon, in a format a space a comma.'''
    return text.replace('@', ':')


class Decoder(srd.Decoder):
    api_version = 3
    id = 'biss'
    name = 'BiSS C'
    longname = 'BiSS C encoder interface'
    desc = 'Serial interface of position encoders.'
    license = 'apache-2.0'
    inputs = ['logic']
    outputs = ['biss']
    tags = ['Embedded/industrial', 'Sensor']
    channels = (
        {'id': 'ma', 'name': 'MA', 'desc': 'Clock of the master'},
        {'id': 'slo', 'name': 'SLO', 'desc': 'Data of the encoder'},
    )
    options = (
        {'id': 'format', 'desc': 'Frame format or encoder; empty: identify', 'default': ''},
        {'id': 'options', 'desc': 'Further options of biss decode', 'default': ''},
        {'id': 'fields', 'desc': 'Show the fields of each frame', 'default': 'yes',
         'values': ('yes', 'no')},
        {'id': 'registers', 'desc': 'Show register accesses', 'default': 'yes',
         'values': ('yes', 'no')},
        {'id': 'pauses', 'desc': 'Show the last rows in a pause', 'default': 'auto',
         'values': ('auto', 'yes', 'no')},
    )
    annotations = ANNOTATIONS
    annotation_rows = (
        ('fields', 'Frame', tuple(range(CLASS['request'], CLASS['wrong'] + 1))),
        ('delays', 'Line delay', (CLASS['line-delay'],)),
        ('cycles', 'Position or cause', (CLASS['position'], CLASS['cause'])),
        ('control', 'CDM', (CLASS['cdm'],)),
        ('accesses', 'Registers', (CLASS['access'], CLASS['access-failed'])),
        ('safety', 'Safety', (CLASS['safety'], CLASS['safety-fault'])),
        ('limits', 'Limits', (CLASS['limit'],)),
    )
    binary = (
        ('csv', 'Rows as CSV'),
    )

    def __init__(self):
        self.reset()

    def reset(self):
        self.samplerate = None
        self.reader = None
        self.clear_block()
        self.kept = []
        self.kept_edges = 0
        self.edges_read = 0
        self.rows_read = 0
        self.rows_shown = 0
        self.accesses_shown = 0
        self.over = threading.Event()
        # Held by the thread that decodes and shows: the thread of sigrok, or the thread that
        # watches for pauses.
        self.lock = threading.RLock()
        self.has_control = False
        self.names = []
        self.classes = {}
        self.begins = array.array('q')
        self.end = 0

    def clear_block(self):
        self.numbers = array.array('q')
        self.levels = bytearray()

    def metadata(self, key, value):
        if key == srd.SRD_CONF_SAMPLERATE:
            self.samplerate = value

    def start(self):
        self.out_ann = self.register(srd.OUTPUT_ANN)
        self.out_python = self.register(srd.OUTPUT_PYTHON)
        self.out_binary = self.register(srd.OUTPUT_BINARY)

    # Edges

    def decode(self):
        if not self.samplerate:
            raise SamplerateError('Cannot decode without samplerate.')
        self.biss = library.load()
        watch = threading.Thread(target=self.watch_pauses, daemon=True)
        try:
            self.open()
            if self.has_pauses():
                watch.start()
            self.read_edges()
        # The capture has ended: libsigrokdecode 0.6 raises the first, 0.5 the second.
        except (EOFError, SystemError):
            self.over.set()
            with self.lock:
                self.finish()
            raise
        # Wrong options, or nothing that can be decoded.
        except (InputError, self.biss.Error) as error:
            self.show_error(error)
        finally:
            self.over.set()

    def finish(self):
        try:
            self.read_block()
            self.show(self.end_of(self.reader, self.end))
            if not self.names:
                self.show_names(self.reader.columns)
            self.show_accesses()
        except self.biss.Error as error:
            self.show_error(error)

    def show_error(self, error):
        self.put(0, self.end, self.out_ann, [CLASS['cause'], [str(error), 'not decoded']])
        # sigrok-cli shows only the requested outputs, and ends with 0.
        self.tell(error)

    @staticmethod
    def tell(text):
        print(f'biss: {text}', file=sys.stderr, flush=True)

    # Pauses

    def has_pauses(self):
        '''
        PulseView with libsigrokdecode 0.5 never says that a capture has ended. sigrok-cli does, and
        its rows must not depend on how fast they come.
        '''
        if self.options['pauses'] != 'auto':
            return self.options['pauses'] == 'yes'
        try:
            return os.path.basename(os.readlink('/proc/self/exe')) != 'sigrok-cli'
        except OSError:
            return True

    def watch_pauses(self):
        shown = seen = None
        while not self.over.wait(PAUSE):
            now = self.edges_read + len(self.levels), self.end
            if now == seen and now != shown:
                with self.lock:
                    if not self.over.is_set() and now[0] <= PAUSED_EDGES:
                        self.show_pause()
                shown = now
            seen = now

    def show_pause(self):
        '''Shows the rows so far as if the capture ended here.'''
        reader, first, end = self.new_reader(), 0, self.end
        try:
            for numbers, levels in self.edges():
                rows = self.changes_of(reader, numbers, levels)
                self.show_from(rows, first)
                first += len(rows)
                end = max(end, int(numbers[-1]))
            self.show_from(self.end_of(reader, end), first)
            self.show_accesses()
        # It may be decoded with later data.
        except self.biss.Error:
            pass

    def edges(self):
        '''Those kept and a copy of those that wait.'''
        waiting = self.numbers[:len(self.levels)], self.levels[:]
        if not waiting[0]:
            return self.kept
        return [*self.kept, (numpy.frombuffer(waiting[0], dtype=numpy.int64),
                             numpy.frombuffer(waiting[1][:len(waiting[0])], dtype=numpy.uint8))]

    def open(self):
        if self.samplerate > PICOSECONDS:
            raise InputError(f'{self.samplerate} samples per second are more than 10^12; let sigrok read '
                             'fewer, of a VCD file with -I vcd:downsample=1000')
        if self.samplerate > COUNTED_RATE:
            self.tell(f'{self.samplerate} samples per second take long; of a VCD file, '
                      '-I vcd:downsample=1000 reads one in 1000')
        self.further = self.further_options()
        self.format = colons(self.options['format'].strip().replace(' ', ',')) or None
        self.reader = self.new_reader()

    def new_reader(self):
        further, rate = self.further, self.samplerate
        if rate > COUNTED_RATE:
            further, rate = {'resolution': f'{-(-PICOSECONDS // rate)}ps', **further}, 0
        return self.biss.Decoder(self.format, sample_rate=rate,
                                 fields=self.options['fields'] == 'yes', **further)

    def changes_of(self, reader, numbers, levels):
        if self.samplerate > COUNTED_RATE:
            return reader.edges(self.times_of(numbers), levels & 1, levels >> 1)
        return reader.changes(numbers, levels & 1, levels >> 1)

    def end_of(self, reader, end):
        if self.samplerate > COUNTED_RATE:
            return reader.finish(end_ps=int(self.times_of(numpy.array([end]))[0]))
        return reader.finish(end_sample=end)

    def further_options(self):
        '''"--ack-max 16us --latch" as keywords of the library.'''
        options = {}
        first, *words = (' ' + self.options['options']).split(' --')
        if first.strip():
            raise InputError(f"options: '{first.strip()}' does not begin with --")
        for word in words:
            name, _, value = word.strip().replace('=', ' ', 1).partition(' ')
            key = name.replace('-', '_')
            if key in options:
                raise InputError(f'options: --{name} is given twice')
            options[key] = colons(value.strip()) or True
        return options

    def read_edges(self):
        '''
        Every edge. While MA rests, the time goes on in steps, so that the end of the capture is
        known: each step costs time, so there are none at the other level of MA.
        '''
        wait, code = self.wait, LEVELS
        pause = max(1, self.samplerate // 1000000)
        skip = {'skip': pause}
        edge, edge_or_step = [{0: 'e'}, {1: 'e'}], [{0: 'e'}, {1: 'e'}, skip]
        conditions = [edge_or_step, edge_or_step]
        levels = wait({})
        now = self.samplenum
        self.numbers.append(now)
        self.levels.append(code[levels])
        while True:
            add_number, add_levels = self.numbers.append, self.levels.append
            for _ in range(BLOCK):
                before = levels
                levels = wait(conditions[before[0]])
                if levels == before:
                    while levels == before:
                        self.end = self.samplenum
                        skip['skip'] = max(pause, (self.end - now) // 2)
                        levels = wait(edge_or_step)
                    skip['skip'] = pause
                now = self.samplenum
                add_number(now)
                add_levels(code[levels])
            rest = self.read_block()
            conditions[rest], conditions[1 - rest] = edge_or_step, edge

    def read_block(self):
        '''Decodes the edges so far. Returns the level at which MA rests.'''
        if not self.levels:
            return 1
        with self.lock:
            self.end = max(self.end, self.numbers[-1])
            numbers = numpy.frombuffer(self.numbers, dtype=numpy.int64)
            levels = numpy.frombuffer(self.levels, dtype=numpy.uint8)
            if self.kept_edges < KEPT_EDGES:
                self.kept.append((numbers, levels))
                self.kept_edges += len(levels)
            self.edges_read += len(levels)
            self.clear_block()
            self.show(self.changes_of(self.reader, numbers, levels))
        ma = levels & 1
        return int(ma[numpy.diff(numbers).argmax()]) if len(numbers) > 1 else 1

    # Rows

    def sample_of(self, time_ps):
        return (time_ps * self.samplerate + PICOSECONDS // 2) // PICOSECONDS

    def show(self, rows):
        self.show_from(rows, self.rows_read)
        self.rows_read += len(rows)

    def show_from(self, rows, first):
        '''Shows rows, the first of which has this number, that a pause has not shown.'''
        rows = rows[max(0, self.rows_shown - first):]
        self.rows_shown += len(rows)
        if rows and not self.names:
            self.show_names(list(rows[0]))
            self.are_times = [name.endswith('_ns') for name in self.names]
            self.positions = [name for name in self.names
                              if name == 'position' or name[:8] == 'position' and name[8:].isdigit()]
        for row in rows:
            self.show_fields(row)
            self.show_row(row)

    def show_names(self, names):
        self.names = names
        self.put(0, 0, self.out_binary, [0, (','.join(names) + '\n').encode()])

    def show_fields(self, row):
        put, out, sample_of, classes = self.put, self.out_ann, self.sample_of, self.classes
        for field in row.fields:
            if field.name not in classes:
                name = field.name.partition('.')[0]
                classes[field.name] = CLASS[FIELDS.get(name, 'other')], name
            kind, name = classes[field.name]
            texts = [field.text]
            if len(field.brief) < len(field.text):
                texts.append(field.brief)
            if len(name) < len(field.brief):
                texts.append(name)
            put(sample_of(field.begin_ps), sample_of(field.end_ps), out,
                [CLASS['wrong'] if field.wrong else kind, texts])
            if name == 'CDM' and field.value:
                self.has_control = True

    def show_row(self, row):
        begin, end = self.sample_of(row.begin_ps), self.sample_of(row.end_ps)
        if self.kept_edges < KEPT_EDGES:
            self.begins.append(begin)
        self.put(begin, end, self.out_python, ['ROW', row])
        line = ','.join(map(text_of, row.values(), self.are_times)) + '\n'
        self.put(begin, end, self.out_binary, [0, line.encode()])
        if row['status'] == 'ok':
            kind = CLASS['position']
            texts = [' '.join([f'{name}={row[name]}' for name in self.positions]),
                     str(row['position'])]
        else:
            kind, texts = CLASS['cause'], [row['status']]
        self.put(begin, end, self.out_ann, [kind, texts])
        if row['safety'] is not None:
            kind = 'safety' if row['safety'] in SAFETY_STATES else 'safety-fault'
            self.put(begin, end, self.out_ann, [CLASS[kind], [row['safety']]])
        if row['limits'] is not None:
            self.put(begin, end, self.out_ann, [CLASS['limit'], [row['limits']]])

    # Registers

    def times_of(self, numbers):
        '''Picoseconds of samples, to the nearest one, as the library computes them.'''
        rate = self.samplerate
        seconds, rest = numpy.divmod(numbers, rate)
        scaled = rest * 10 ** 6
        fine = (scaled % rate * 10 ** 6 + rate // 2) // rate
        return seconds * PICOSECONDS + scaled // rate * 10 ** 6 + fine

    def show_accesses(self):
        if not self.has_control or self.options['registers'] != 'yes':
            return
        edges = self.edges()
        numbers = numpy.concatenate([each for each, _ in edges])
        levels = numpy.concatenate([each for _, each in edges])
        period = -(-PICOSECONDS // self.samplerate)
        capture = self.biss.Capture.edges(self.times_of(numbers), levels & 1, levels >> 1,
                                          resolution_ps=period)
        found = self.biss.run('registers', capture, to='jsonl', format=self.format).records()
        for access in found[self.accesses_shown:]:
            self.show_access(access)
        self.accesses_shown = len(found)

    def show_access(self, access):
        begin = self.sample_of(round(access['time_ns'] * 1000))
        last = access['cycle'] + access['cycles']
        end = max(begin, self.begins[last] if last < len(self.begins) else self.end)
        failed = access['outcome'] != 'ok'
        words = [f'{name}={value}' for name, value in access.items()
                 if value is not None and name not in ('cycle', 'time_ns')]
        brief = [str(access[name]) for name in ('access', 'address', 'data') if access.get(name)]
        self.put(begin, end, self.out_python, ['ACCESS', access])
        self.put(begin, end, self.out_ann, [CLASS['access-failed' if failed else 'access'],
                                            [' '.join(words), ' '.join(brief), brief[0][:1]]])
