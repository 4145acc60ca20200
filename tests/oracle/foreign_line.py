"""One line: an encoder, its master and the wires, drawn at random, run and captured."""
import math

from foreign_encoder import Flag, Motion, draw_format
from foreign_physics import Answer, Control, Encoder, Master, Plan, Wire, nibble
from foreign_truth import Truth

HEALTHY_PERIOD = (101.0, 4000.0)
RATES = (1, 2, 4, 5, 8, 10, 12, 16, 20, 24, 25, 32, 40, 48, 50, 62.5, 80, 96, 100, 125, 160, 200, 250,
         400, 500, 800, 1000, 1250)  # samples per microsecond


class Line(Truth):
    """All that makes one line: drawn at random, then changed by its causes, then run."""

    def __init__(self, luck, wide=False):
        self.luck, self.wide = luck, wide
        self.causes, self.about, self.options, self.with_options = [], {}, [], []
        self.accept = {}
        self.format = draw_format(luck, wide)
        self.given = None  # another format for -f than the true one
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
        self.probe_pulses = []
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
        self.unknown = None  # a cause that a run without a format need not name
        self.store = lambda number, values: values
        self.turning = self.timing = self._delay = None
        self.named = False
        self.least_damage = 3
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

    def touch(self, cause, number):
        self.touched.setdefault(cause, set()).add(number)

    def moving(self):
        """The axis moves, so that a checksum can be known."""
        self.motion_kinds = ("steady", "sine", "ramp", "stops", "wander")

    def wait_longer(self):
        """A master that keeps its rhythm: SLO may be high in mid-frame, and would seem ready."""
        if self.rhythm == "ready":
            self.rhythm = "steady"

    def name_lines(self):
        """The lines are named, because their behaviour cannot show which is which."""
        self.named = True

    # ---- running it ----

    def run(self):
        """Simulates; afterwards `requests`, `captured` and the truth are there."""
        luck = self.luck
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
        if len(self.motions) == 2 and (luck.random() < 0.6 or self.format.channels[1].has("lc")):
            self.motions[1] = self.motions[0]
        self.flags = [{kind: Flag(luck, self.count, self.flag_kinds[kind]) for kind in ("nE", "nW")}
                      for _ in self.format.channels]
        self.counter = luck.randrange(64)
        self.counter_low = luck.choice((0, 1)) if self.wide else 1
        ma = Wire(self.delays[0], self.slopes[0], self.thresholds[0])
        slo = Wire(self.delays[1], self.slopes[1], self.thresholds[1])
        drive = Wire()  # what the master sends, as a probe at the master sees it
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
        self.crop(waves)

    def one_request(self, number, time):
        pauses, low = self.pauses(number)
        after = self.format_at(number).bits + 2
        cut = self.cut(number)
        plan = Plan(sample=self.sample, pauses=pauses, pause_low=low, start_wait=self.start_wait())
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

    def start_wait(self):
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
        values, places = [], {}
        frame_format = self.format_at(number)
        self.counter += 1
        for index, channel in enumerate(frame_format.channels):
            motion, flags = self.motions[index % len(self.motions)], self.flags[index % len(self.flags)]
            if motion not in places:
                places[motion] = motion.at(time)
            position = places[motion] >> max(0, motion.bits - channel.position_bits)
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

    def crop(self, waves):
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
            if (self.period / step < 5.5) != (wanted < 5.5) or 4.9 < self.period / step < 5.5:
                step = self.period / wanted
            self.about["samples_per_period"] = round(self.period / step, 2)
        self.step = step
        phase = luck.uniform(0, step) if step else 0.0
        for first_level, times in waves:
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


class _Both:
    """The master's driver: the wire of the probe, and that of the encoder, which may be inverted."""

    def __init__(self, shown, sent, inverted):
        self.shown, self.sent, self.inverted, self.delay = shown, sent, inverted, sent.delay

    def put(self, time, level):
        self.shown.put(time, level)
        self.sent.put(time, level ^ self.inverted)
