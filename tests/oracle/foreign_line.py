"""One line: an encoder, its master and the wires, drawn at random, run, captured and read again."""
import bisect
import math

from foreign_format import FLAGS, USUAL, Channel, Format, Item
from foreign_physics import Answer, Control, Encoder, Master, Plan, Wire, nibble

HEALTHY_PERIOD = (101.0, 4000.0)
RATES = (1, 2, 4, 5, 8, 10, 12, 16, 20, 24, 25, 32, 40, 48, 50, 62.5, 80, 96, 100, 125, 160, 200, 250,
         400, 500, 800, 1000, 1250)  # samples per microsecond


class Motion:
    """A position that is a smooth function of time, in counts."""

    KINDS = ("still", "dither", "slow", "steady", "sine", "ramp", "stops", "wander", "fast")

    def __init__(self, luck, bits, interval, kind):
        self.luck, self.bits, self.kind = luck, bits, kind
        self.origin = luck.randrange(1 << bits)
        if luck.random() < 0.3:
            self.origin = luck.randrange(1 << max(1, bits // 2))
        size = 2.0 ** bits
        step = {"slow": luck.uniform(0.02, 1.5), "fast": size / luck.uniform(9, 40)}.get(kind)
        if step is None:
            step = 2.0 ** luck.uniform(1, max(2, min(bits - 5, 18)))
        self.speed = luck.choice((-1, 1)) * step / interval
        self.interval = interval
        self.turn = interval * luck.uniform(40, 400)
        self.stop = [luck.uniform(5, 60) * interval for _ in range(2)]
        self.place, self.now, self.drift = 0.0, None, 0.0

    def at(self, time):
        if self.now is None:
            self.now = time
        kind, speed = self.kind, self.speed
        if kind == "still":
            moved = 0.0
        elif kind == "dither":
            moved = self.luck.choice((-1, 0, 0, 0, 1))
        elif kind == "sine":
            moved = speed * self.turn / 6.28 * math.sin(6.28 * time / self.turn)
        elif kind == "ramp":
            moved = speed * time * time / (2 * self.turn)
        elif kind == "stops":
            whole, rest = divmod(time, sum(self.stop))
            moved = speed * (whole * self.stop[0] + min(rest, self.stop[0]))
        elif kind == "wander":
            steps = (time - self.now) / self.interval
            self.drift += self.luck.gauss(0, 0.05) * speed * steps
            self.drift *= 0.999
            self.place += (speed * 0.2 + self.drift) * (time - self.now)
            self.now = time
            moved = self.place
        else:
            moved = speed * time
        return (self.origin + math.floor(moved)) % (1 << self.bits)


class Flag:
    """Whether a flag is active in a request."""

    KINDS = ("none", "rare", "tenth", "third", "most", "all", "block", "end", "start", "often")

    def __init__(self, luck, count, kind):
        self.kind, self.luck, self.count = kind, luck, count
        self.share = {"rare": 0.01, "tenth": 0.1, "third": 0.3, "most": 0.6, "often": 0.9}.get(kind, 0)
        length = luck.uniform(0.03, 0.4) * count
        self.first = luck.uniform(0, count - length)
        if kind == "end":
            self.first, length = count - max(3, luck.uniform(0.002, 0.06) * count), count
        elif kind == "start":
            self.first = -1
        self.last = self.first + length
        self.sticky, self.now = luck.random() < 0.4, False

    def active(self, number):
        if self.kind in ("none", "all"):
            return self.kind == "all"
        if not self.share:
            return self.first <= number <= self.last
        if self.sticky:  # comes and goes in runs
            stay = 0.85 if self.share >= 0.1 else 0.5
            leave = (1 - stay) * (1 - self.share) / self.share
            if self.luck.random() < (min(0.9, leave) if self.now else
                                     min(0.9, leave) * self.share / (1 - self.share)):
                self.now = not self.now
            return self.now
        return self.luck.random() < self.share


def draw_format(luck, wide):
    """A frame format; `wide` asks for unusual ones too."""
    def position(low=10, high=40):
        return luck.choice((18, 26, 32, 36, 17, 19, 20, 21, 22, 24, 13, 14, 16)) if luck.random() < 0.5 \
            else luck.randint(low, high)

    def channel(bits, counter, width):
        items = [Item("pos", bits)]
        if luck.random() < 0.3 and bits >= 20:
            turns = luck.choice((12, 12, 16, bits // 3))
            if bits - turns >= 8:
                items = [Item("mt", turns), Item("st", bits - turns)]
        if wide:
            dice = luck.random()
            if dice < 0.06:
                items = [Item(i.kind, i.bits, gray=True) for i in items]
            elif dice < 0.08:
                items = [Item("pos", bits, lsb=True)]
        flags = [Item("nE", 1), Item("nW", 1)]
        dice = luck.random() if wide else 0
        if dice > 0.97:
            flags = [Item("E", 1), Item("W", 1)]
        elif dice > 0.94:
            flags = [Item("nE", 1), Item("pad", 1)]
        elif dice > 0.92:
            flags = [Item("nE", 1)]
        elif dice > 0.90:
            flags = [Item("E", 1), Item("nW", 1)]
        elif dice > 0.89:
            flags = []
        pads = [Item("pad", luck.randint(1, 6))] if wide and luck.random() < 0.08 else []
        if wide and flags and luck.random() < 0.05:
            items = flags + pads + items
        else:
            items = items + pads + flags
        if counter:
            items.append(Item("lc", 6))
        parameters = {"width": width}
        if wide and luck.random() < 0.12:
            wanted = luck.choice((5, 6, 7, 8, 9, 10, 12, 16))
            parameters = {"width": wanted,
                          "polynomial": 1 << wanted | luck.getrandbits(wanted) | 1}
            if luck.random() < 0.3:
                parameters["start"] = luck.randint(1, (1 << wanted) - 1)
        elif wide and luck.random() < 0.05:
            parameters["start"] = luck.randint(1, (1 << width) - 1)
        elif wide and luck.random() < 0.03:
            parameters["plain"] = True
        elif wide and luck.random() < 0.05 and width == 6 and not counter:
            parameters["error"] = luck.choice(("reversed", "no-flags", "cds", "previous"))
            if parameters["error"] == "no-flags" and (not flags or items[-1].kind == "pos"
                                                      or any(i.kind == "pad" for i in items)):
                parameters["error"] = "reversed"
        return Channel(items, **parameters)

    dice = luck.random()
    if dice < 0.10:
        first = position(16, 36)
        return Format([channel(first, False, 6), channel(luck.choice((first, max(12, first - 8))), True, 16)])
    if dice < 0.18:
        return Format([channel(position(10, 30), False, 6) for _ in range(luck.choice((2, 2, 3)))])
    width = luck.choice((5, 8, 16, 16, 7, 4)) if luck.random() < 0.15 else 6
    return Format([channel(position(), width == 16 and luck.random() < 0.5, width)])


class Line:
    """All that makes one line: drawn at random, then changed by its causes, then run."""

    def __init__(self, luck, wide=False):
        self.luck = luck
        self.causes, self.about, self.options, self.with_options = [], {}, [], []
        self.accept = {}
        self.format = draw_format(luck, wide)
        self.told = None  # another format for -f than the true one
        low, high = HEALTHY_PERIOD
        self.period = math.exp(luck.uniform(math.log(low), math.log(high)))
        if luck.random() < 0.3:
            self.period = luck.choice((125.0, 200.0, 250.0, 400.0, 500.0, 1000.0, 2000.0))
        self.period *= 1 + luck.uniform(-1e-4, 1e-4)
        metres = luck.choice((luck.uniform(0, 3), luck.uniform(0, 20), luck.uniform(0, 100)))
        metres = min(metres, 50 if self.period < 199 else 100)
        share = luck.uniform(0.3, 0.7)
        self.delays = [metres * 10 * share, metres * 10 * (1 - share)]
        self.slopes = [0.0, 0.0]
        self.thresholds = [0.5, 0.5]
        self.internal = luck.uniform(2, 60)
        self.duty = 0.5 if luck.random() < 0.7 else luck.uniform(0.42, 0.58)
        if self.period * min(self.duty, 1 - self.duty) < 42:
            self.duty = 0.5
        self.jitter = luck.choice((0, 0.002, 0.01, 0.03))  # of a period
        self.draw_ack()
        self.timeout = luck.choice((("fixed", luck.uniform(12600, 39000)), ("fixed", 20000.0),
                                    ("adaptive", luck.uniform(0, 300)), ("cycle", 31250.0),
                                    ("cycle_hard", 31250.0)))
        if self.timeout[0].startswith("cycle") and luck.random() < 0.5:
            self.timeout = ("fixed", luck.choice((13000.0, 20000.0, 30000.0)))
        self.count = int(math.exp(luck.uniform(math.log(50), math.log(400))))
        while self.count > 40 and self.count * (self.format.bits + 10) > 16000:
            self.count = int(self.count * 0.8)
        self.rhythm = luck.choice(("steady", "steady", "ready", "bursts", "loose"))
        self.motion_kinds = Motion.KINDS
        self.flag_kinds = {"nE": "none", "nW": luck.choice(Flag.KINDS) if luck.random() < 0.25 else "none"}
        self.follow = luck.random() < 0.65
        self.extra = luck.choice((0, 0, 0, 1, 2, 5)) if not self.timeout[0].startswith("cycle") else 0
        self.byte_clocks = luck.random() < 0.4
        self.pauses = lambda number: ({}, False)
        self.cut = lambda number: None
        self.hurry = lambda number: None
        self.format_at = lambda number: self.format
        self.short = {}  # number -> clocks of a short or reduced frame
        self.cdm = {}
        self.events, self.encoder_pulses, self.probe_pulses = [], [], []
        self.control = luck.random() < 0.25
        self.distort = lambda number, channel, values: None
        self.samples = luck.choice((None, luck.uniform(5.5, 12), luck.uniform(8, 30), luck.uniform(20, 100)))
        self.invert, self.invert_encoder, self.swap = [False, False], False, False
        self.ends = [luck.random() < 0.35, luck.random() < 0.35]
        self.probe_at_encoder = luck.random() < 0.12
        self.names = luck.choice((["MA", "SLO"], ["MA", "SLO"], ["D0", "D1"], ["D5", "D2"],
                                  ["Channel 1", "Channel 0"], ["ch3", "ch7"]))
        self.columns = luck.choice(([0, 1], [1, 0]))
        # What the causes use.
        self.touched = {}  # cause -> requests in which it acts
        self.counts = set()  # causes that count even if a frame is read well
        self.everywhere = None  # the cause of every damaged request
        self.before, self.start, self.later = [], [], []  # called per request, before, after the run
        self.store = lambda number, values: values
        self.turning = self.timing = self._delay = None
        self.named = False
        self.master_inverted = self.resolution = False

    def draw_ack(self, longest=36000.0):
        """How long the encoder is busy."""
        luck = self.luck
        kind = luck.choice(("fixed", "fixed", "time", "vary"))
        most = max(1, min(60, int(longest / self.period) - 1))
        if kind == "fixed":
            clocks = min(most, luck.choice((1, 1, 2, 3, 4, luck.randint(1, 60))))
            self.ack = lambda: (clocks, None)
            self.ack_most = clocks
        elif kind == "time":
            busy = min(luck.uniform(0, 16000), longest - 2 * self.period, 60 * self.period)
            busy = max(busy, 0.0)
            self.ack = lambda: (None, busy)
            self.ack_most = max(1, math.ceil(busy / self.period))
        else:
            low = luck.randint(1, most)
            high = min(most, low + luck.choice((1, 2, 5, 20)))
            self.ack = lambda: (luck.randint(low, high), None)
            self.ack_most = high
        self.about["ack"] = [kind, self.ack_most]
        self.ack_kind = kind

    def touch(self, cause, number):
        self.touched.setdefault(cause, set()).add(number)

    def moving(self):
        """The axis moves, so that a checksum can be known."""
        self.motion_kinds = ("steady", "sine", "ramp", "stops", "wander")

    def name_lines(self):
        """The lines are named, because their behaviour cannot show which is which."""
        self.named = True

    # ---- running it ----

    def run(self):
        """Simulates; afterwards `waves`, `requests` and the truth are there."""
        luck, master_format = self.luck, self.format
        clocks = self.format.bits + self.ack_most + 5
        answer_time = clocks * self.period + sum(self.delays)
        rest = {"fixed": self.timeout[1], "adaptive": 1.6 * self.period + self.timeout[1],
                "cycle": max(2 * self.period, 31250 - answer_time),
                "cycle_hard": max(2 * self.period, 31250 - answer_time)}[self.timeout[0]]
        least = answer_time + rest + 1500 + 2 * self.period
        interval = least * luck.choice((1.02, 1.1, 1.5, 2, 4)) if self.rhythm != "ready" else least
        self.interval = interval
        self.motions = [Motion(luck, channel.position_bits, interval, luck.choice(self.motion_kinds))
                        for channel in self.format.channels]
        if self.turning:
            single = self.format.channels[0].items[1].bits
            self.motions[0].speed = luck.choice((-1, 1)) * 2.0 ** single / self.turning / interval
        if len(self.motions) == 2 and luck.random() < 0.6:
            self.motions[1] = self.motions[0]
        self.flags = [{kind: Flag(luck, self.count, self.flag_kinds[kind]) for kind in ("nE", "nW")} for _ in self.format.channels]
        self.counter = luck.randrange(64)
        self.counter_low = luck.choice((0, 1))
        ma = Wire(self.delays[0], self.slopes[0], self.thresholds[0])
        slo = Wire(self.delays[1], self.slopes[1], self.thresholds[1])
        shown = Wire()
        drive = shown  # what the master sends, as a probe at the master sees it
        control = Control(luck.randint(0, 3), {a: luck.getrandbits(8) for a in range(128)}) \
            if self.control else None
        encoder = Encoder(self.answer, ma, slo, self.internal, self.ack, self.timeout, control)
        master = Master(encoder, _Both(drive, ma, self.invert_encoder), slo, luck, self.period, self.duty,
                        self.jitter * self.period)
        master.inverted = int(self.master_inverted)
        self.encoder, self.master, self.slo = encoder, master, slo
        self.sample = self.period / 2 + sum(self.delays) + self.internal
        if self.control and not self.cdm:
            self.draw_cdm(control)
        if self.invert_encoder:
            ma.first, ma._target, ma._volts = 0, 0, 0.0
            encoder.level = 0
        for action in self.start:
            action()
        time = interval * luck.uniform(0.6, 1.5) + 50000
        self.begin = time
        for number in range(self.count):
            self.number = number
            for action in self.before:
                action(number, time)
            rises = self.one_request(number, time)
            time = self.next_time(number, time, rises, least)
        self.end = time + interval
        encoder.run(self.end)
        slo.settle(self.end + 1e6)
        ma.settle(self.end + 1e6)
        drive.settle(self.end + 1e6)
        self.requests = master.requests
        for number, request in enumerate(self.requests):
            request.number = number
        drive.add_pulses(self.probe_pulses)
        waves = [drive.changes(), slo.changes()]
        if self.probe_at_encoder:
            shift = -self.delays[1]
            waves = [(ma.first, list(ma.times)), (waves[1][0], [t + shift for t in waves[1][1]])]
        for action in self.later:
            action()
        self.waves = waves
        self.crop()

    def one_request(self, number, time):
        pauses, low = self.pauses(number)
        after = self.format_at(number).bits + 2
        cut = self.cut(number)
        plan = Plan(sample=self.sample, pauses=pauses, pause_low=low, patience=self.patience())
        if self.short.get(number) == 2:
            plan.clocks = 2
        elif self.short.get(number) == 5:
            plan.after_start = 2
        elif cut is not None:
            plan.clocks = cut
        elif self.follow:
            plan.after_start = after + self.extra
        else:
            plan.clocks = self.ack_most + 2 + after + self.extra
            if self.byte_clocks and not self.timeout[0].startswith("cycle"):
                plan.clocks = (plan.clocks + 7) // 8 * 8
        if self.cdm.get(number):
            plan.cdm, plan.hold = 1, self.sample + 1.5 * self.period
        self.ready = self.master.request(time, plan)
        return self.master.requests[-1].rises

    def patience(self):
        return self.ack_most + 40 + int(2000 / self.period)

    def next_time(self, number, time, rises, least):
        luck = self.luck
        hurry = self.hurry(number)
        if hurry is not None:
            return rises[-1] + hurry
        if self.rhythm == "steady":
            wanted = time + self.interval + luck.uniform(0, 0.002) * self.interval
        elif self.rhythm == "ready":
            wanted = self.ready + luck.uniform(0.5, 3) * self.period
        elif self.rhythm == "bursts":
            gap = luck.uniform(3.1, 40) if luck.random() < 0.06 else luck.uniform(1, 1.3)
            wanted = time + gap * self.interval
        else:
            wanted = time + luck.uniform(1, 3) * self.interval
        wanted = max(wanted, self.ready + self.period, rises[-1] + self.sample + self.period)
        # Late enough that the capture shows SLO high before the request.
        return self.master.wait_ready(wanted) + 0.5 * self.period + 30

    def answer(self, time, cds):
        """The encoder latches now."""
        number = self.number
        values = []
        frame_format = self.format_at(number)
        self.counter += 1
        for index, channel in enumerate(frame_format.channels):
            motion, flags = self.motions[index % len(self.motions)], self.flags[index % len(self.flags)]
            position = motion.at(time) >> max(0, motion.bits - channel.position_bits)
            value = {"pos": position, "pad": 0, "lc": self.life()}
            active = {kind: flag.active(number) for kind, flag in flags.items()}
            value["nE"], value["nW"] = 1 - active["nE"], 1 - active["nW"]
            value["E"], value["W"] = active["nE"], active["nW"]
            self.distort(number, index, value)
            for item in channel.items:
                if item.kind == "st":
                    value["st"] = value["pos"] & (1 << item.bits) - 1
                    value.setdefault("mt", value["pos"] >> item.bits)
            values.append(value)
        values = self.store(number, values)
        if number in self.short and self.short[number] == 5:
            return Answer(time, [], cds, values)
        return Answer(time, frame_format.frame(values, cds, self.luck), cds, values)

    def life(self):
        return self.counter % 64 if self.counter_low == 0 else 1 + self.counter % 63

    def draw_cdm(self, control):
        """Register accesses: the CDM bits of the requests."""
        number, luck = self.luck.randint(0, 30), self.luck
        while number + 60 < self.count:
            body = [1, 0, 0, 0] + [int(b) for b in f"{luck.randrange(128):07b}"]
            bits = [1] + body + nibble(body) + [1, 0] + [1] * (control.busy + 1)
            for place, bit in enumerate(bits):
                if bit:
                    self.cdm[number + place] = 1
            number += len(bits) + 14 + 14 + luck.randint(0, 60)

    # ---- the capture ----

    def name(self):
        """The probes are exchanged or inverted; the command gets the names that it cannot find."""
        if self.swap:
            self.names.reverse()
        if (self.named and self.names not in (["MA", "SLO"], ["SLO", "MA"])) or self.luck.random() < 0.2:
            first, second = reversed(self.names) if self.swap else self.names
            self.options = ["--ma", first, "--slo", second]
        for line in (0, 1):
            self.captured[line][0] ^= self.invert[line]

    def crop(self):
        """Cuts the capture out of the waves, in mid-request or at rest; samples it."""
        luck = self.luck
        first, last = self.requests[0], self.requests[-1]
        self.from_time = first.time - luck.uniform(1.5, 20) * self.period - 100
        self.to_time = self.end
        if self.ends[0] and self.count > 30:
            self.from_time = luck.uniform(first.time, self.requests[1].time)
        if self.ends[1] and self.count > 30:
            self.to_time = luck.uniform(last.time, last.rises[-1] + self.period)
        out = []
        step = None
        if self.samples:
            rate = min(RATES, key=lambda r: abs(math.log(r * self.period / 1000 / self.samples)))
            wanted = self.samples
            step = 1000.0 / rate
            if not 0.8 < self.period / step / wanted < 1.25:
                step = self.period / wanted
            if self.period / step < 5.5 and wanted >= 5.5:
                step = self.period / wanted
            self.about["samples_per_period"] = round(self.period / step, 2)
        self.step = step
        phase = luck.uniform(0, step) if step else 0.0
        for first_level, times in self.waves:
            level, kept = first_level, []
            start = None
            for time in times:
                if time <= self.from_time:
                    level ^= 1
                    continue
                if start is None:
                    start = level
                if time > self.to_time:
                    break
                time -= self.from_time
                if step:
                    time = math.ceil((time - phase) / step) * step
                if step and kept and kept[-1] == time:
                    kept.pop()
                else:
                    kept.append(time)
            out.append([level if start is None else start, kept])
        self.captured = out

    def level(self, line, time):
        """The captured level, before probes are exchanged or inverted."""
        first, times = self.captured[line]
        return first ^ bisect.bisect_right(times, time) & 1

    def inside(self):
        """Requests that the capture has whole."""
        return [r for r in self.requests if r.time > self.from_time + self.period
                and max(r.end, r.rises[-1]) + self.period < self.to_time]

    def seen_delay(self):
        """The median from the second rising edge of MA to the fall of SLO, in the capture."""
        if self._delay is None:
            first, times = self.captured[1]
            falls = [t for place, t in enumerate(times) if place & 1 != first]
            after = []
            for request in self.inside():
                edge = request.rises[1] - self.from_time
                at = bisect.bisect_left(falls, edge)
                if at < len(falls) and falls[at] - edge < sum(self.delays) + 2 * self.period:
                    after.append(falls[at] - edge)
            self._delay = sorted(after)[len(after) // 2] if after else sum(self.delays)
        return self._delay

    def read(self, request):
        """The frame of a request as a plain reader sees it: 'good', or what is wrong."""
        answer = request.answer
        shift = self.delays[0] if self.probe_at_encoder else 0.0
        begin = request.time - self.from_time + shift
        end = request.rises[-1] - self.from_time + shift + self.period / 4
        first, times = self.captured[0]
        low, high = bisect.bisect_right(times, begin - self.period / 4), bisect.bisect_right(times, end)
        rises = [times[i] for i in range(low, high) if i & 1 == first]
        if len(rises) != len(request.rises):
            return "clocks"
        if answer is None:
            return "no answer"
        if self.slopes[1] or self.invert_encoder:
            shift = self.period / 2 + self.seen_delay()
        else:
            shift = self.period / 2 + self.internal if self.probe_at_encoder else self.sample
        bits = [self.level(1, rise + shift) for rise in rises]
        if bits[:1] != [1]:
            return "busy"
        try:
            fall = bits.index(0)
            start = bits.index(1, fall)
        except ValueError:
            return "no start"
        if fall != 1:
            return "late"
        want = [1, answer.cds] + answer.bits + [0]
        got = bits[start:start + len(want)]
        if len(got) < len(want) - 1:
            return "short"
        if got != want[:len(got)]:
            return "bits"
        if any(bits[start + len(want):]):
            return "tail"
        return "good"

    # ---- the truth ----

    def judge(self):
        """Whether each cause did something; counts the requests that it damaged."""
        whole = self.inside()
        if len(whole) < 25:
            return False
        verdicts = {request.number: self.read(request) for request in whole}
        self.marks = {}
        for cause in self.causes:
            touched = self.touched.get(cause, set())
            self.marks[cause] = [
                number for number, verdict in verdicts.items()
                if (cause in self.counts and (number in touched or cause == self.everywhere))
                or (verdict != "good" and (number in touched or cause == self.everywhere))]
        bad = {number for number, verdict in verdicts.items() if verdict != "good"}
        self.verdicts = verdicts
        if self.causes == ["healthy"]:
            self.name()
            return not bad
        if len(self.causes) == 2:  # each has its own
            one, two = (set(self.marks[cause]) for cause in self.causes)
            if min(len(one - two), len(two)) < 3 and min(len(two - one), len(one)) < 3:
                return False
        if self.invert_encoder and len(bad) < 3:
            return False
        if self.slopes[1] and len(verdicts) - len(bad) < 3:
            return False
        enough = all(len(marks) >= max(3, 0.01 * len(whole)) for marks in self.marks.values())
        self.name()
        return enough or self.causes == ["sampling_too_slow"]

    def truth(self):
        whole = self.inside()
        first = whole[0].number if whole else 0
        told = self.told or self.format
        options = list(self.options)
        if self.resolution:
            options += ["--resolution", f"{self.step:.3f}ns"]
        with_format = self.with_options or (["-f", told.text()] if told.text() else None)
        if with_format and self.timing and self.luck.random() < 0.5:
            with_format = with_format + self.timing
        damaged = sorted({n for marks in self.marks.values() for n in marks})
        accept = {mode: self.accept.get(mode, [c for c in self.causes]) for mode in ("with", "without")}
        if self.causes == ["sampling_too_slow"] and len(damaged) < max(3, 0.01 * len(whole)):
            accept = {mode: ["sampling_too_slow", "healthy"] for mode in accept}
        kept = self.frames()
        return {
            "causes": self.causes, "format": self.format.text(),
            "without": None if accept["without"] is None else options,
            "with": options + with_format if with_format else None,
            "accept": accept, "requests": len(whole),
            "damaged": [n - first for n in damaged],
            "ill": len(damaged) >= max(3, 0.01 * len(whole)) and self.causes != ["healthy"],
            "marks": {cause: [n - first for n in marks] for cause, marks in self.marks.items()},
            "answered": round(sum(r.answer is not None and r.answer.sent > 0 for r in whole)
                              / max(1, len(whole)), 3),
            **kept,
            "about": {**self.about, "period": round(self.period, 2), "delay": round(sum(self.delays)),
                      "timeout": self.timeout, "rhythm": self.rhythm, "follow": self.follow,
                      "extra": self.extra, "motion": [m.kind for m in self.motions],
                      "flags": self.flag_kinds, "slopes": self.slopes, "ends": self.ends,
                      "at_encoder": self.probe_at_encoder, "cdm": len(self.cdm)}}

    def shows_error(self):
        """Whether a maker's error in the checksum, if there is one, is in the frames."""
        answers = [r.answer for r in self.inside() if r.answer]
        for index, channel in enumerate(self.format.channels):
            if channel.error == "cds" and sum(a.cds for a in answers) < 3:
                return False
            if channel.error == "no-flags" and len({(a.notes[index]["nE"], a.notes[index]["nW"])
                                                    for a in answers}) < 2:
                return False
        return True

    def readable(self):
        """Whether what is unusual in this format shows in the frames: nobody could know it else."""
        kept = self.frames()
        for index, channel in enumerate(self.format.channels):
            moved, rank = kept["moved"][index].count("1"), kept["rank"][index]
            unusual = (channel.polynomial != USUAL.get(channel.width) or channel.start or channel.plain
                       or channel.error)
            if unusual and rank < 6:
                return False
            if any(item.gray or item.lsb for item in channel.items) and (moved < 6 or not kept["smooth"]):
                return False
            kinds = [item.kind for item in channel.items if item.kind in FLAGS]
            if kinds not in (["nE", "nW"], ["nE"]) or channel.items[0].kind in FLAGS:
                for kind, low in kept["low"][index].items():
                    active = low if kind in ("nE", "nW") else 1 - low
                    if not 0 < active < 0.5:
                        return False
            if len(self.format.channels) > 1 and rank < 3:
                return False
        return True

    def frames(self):
        """What the good frames of the encoder show: moved bits, flags, independent frames."""
        answers = [r.answer for r in self.inside() if r.answer and r.answer.sent > len(r.answer.bits)
                   and len(r.answer.bits) == self.format.bits]
        moved, low, rank, at = [], [], [], 0
        counted = False
        for index, channel in enumerate(self.format.channels):
            words = [a.bits[at:at + channel.data_bits] for a in answers]
            at += channel.bits
            moved.append("".join(str(int(len(set(column)) > 1)) for column in zip(*words)))
            kinds = [item.kind for item in channel.items if item.kind in ("nE", "nW", "E", "W")]
            low.append({kind: round(sum(a.notes[index][kind] == 0 for a in answers) / len(answers), 4)
                        for kind in kinds} if answers else {})
            rank.append(independent([int("".join(map(str, w)), 2) for w in words]) if words else 0)
            counted = counted or channel.has("lc")
        return {"moved": moved, "low": low, "rank": rank, "counted": counted,
                "smooth": not any(motion.kind == "fast" for motion in self.motions),
                "frames": [f"{a.cds} " + "".join(map(str, a.bits)) for a in answers[:400]]}


def independent(words):
    """The rank of the differences of these numbers, modulo 2."""
    basis = []
    for word in words[1:]:
        word ^= words[0]
        for other in basis:
            word = min(word, word ^ other)
        if word:
            basis.append(word)
    return len(basis)


class _Both:
    """The master's driver: a probe's wire and the encoder's, whose pair may be exchanged."""

    def __init__(self, shown, sent, inverted):
        self.shown, self.sent, self.inverted, self.delay = shown, sent, inverted, sent.delay

    def put(self, time, level):
        self.shown.put(time, level)
        self.sent.put(time, level ^ self.inverted)
