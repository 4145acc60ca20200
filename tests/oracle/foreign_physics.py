"""Encoder, wires and master as they are in the world: each has its own timers and delays.

Times are nanoseconds, as floating point. What goes wrong on a line follows from what is done to
these parts; no damage is painted into the bits.
"""
import bisect
import math


class Wire:
    """A cable: a delay, a slope (RC) and a threshold; then pulses, and times of a forced level."""

    def __init__(self, delay=0.0, slope=0.0, threshold=0.5, level=1):
        self.delay, self.slope, self.threshold = delay, slope, threshold
        self.first = level
        self.times, self.levels = [], []
        self.pulses, self.forced = [], []
        self.shake = None  # deviation of the threshold at a change
        self._volts, self._since, self._target, self._crossing = float(level), -1e18, level, None

    def put(self, time, level):
        """The driver changes to this level."""
        if level == self._target:
            return
        time += self.delay
        self.settle(time)
        if self.slope:
            decay = math.exp(max(-700.0, -(time - self._since) / self.slope))
            self._volts = self._target + (self._volts - self._target) * decay
        else:
            self._volts = float(self._target)
        self._since, self._target = time, level
        threshold = self.threshold + (self.shake() if self.shake else 0.0)
        if (self._volts > threshold) == bool(level):
            self._crossing = None
        elif self.slope:
            self._crossing = time + self.slope * math.log((self._volts - level) / (threshold - level))
        else:
            self._crossing = time

    def settle(self, time):
        """Changes up to this time are final."""
        if self._crossing is not None and self._crossing <= time:
            if self._target != (self.levels[-1] if self.levels else self.first):
                self.times.append(self._crossing)
                self.levels.append(self._target)
            self._crossing = None

    def next_change(self):
        return math.inf if self._crossing is None else self._crossing

    def level(self, time):
        """What a receiver sees at this time."""
        for begin, end, level in self.forced:
            if begin <= time < end:
                return level
        at = bisect.bisect_right(self.times, time)
        level = self.levels[at - 1] if at else self.first
        if self.pulses:
            level ^= bisect.bisect_right(self.pulses, time) & 1
        return level

    def add_pulses(self, spans):
        """Inverts the line in these spans of time."""
        self.pulses = sorted(self.pulses + [edge for span in spans for edge in span])

    def changes(self):
        """(first level, times of changes), as the receiver sees them."""
        if not self.pulses and not self.forced:
            return self.first, list(self.times)
        moments = set(self.times) | set(self.pulses)
        for begin, end, _ in self.forced:
            moments |= {begin, end}
        first = level = self.level(-1e17)
        out = []
        for time in sorted(moments):
            if self.level(time) != level:
                level ^= 1
                out.append(time)
        return first, out


class Control:
    """The encoder's side of the control communication: one register access at a time."""

    def __init__(self, busy=0, memory=None):
        self.busy, self.memory = busy, memory or {}
        self.zeros, self.bits, self.answer = 14, None, []

    def put(self, cdm):
        """Takes a CDM bit; returns the CDS bit of the next frame."""
        self.zeros = 0 if cdm else self.zeros + 1
        if self.bits is None:
            if cdm:
                self.bits, self.answer = [1], [1] + [0] * 15
                return self.answer.pop(0)
            return 0
        if self.zeros >= 14:
            self.bits, self.answer = None, []
            return 0
        self.bits.append(cdm)
        if len(self.bits) == 17 and self.bits[1] == 1 and self.bits[2:5] == [0, 0, 0]:
            address = int("".join(map(str, self.bits[5:12])), 2)
            data = self.memory.get(address, 0)
            word = [data >> place & 1 for place in range(7, -1, -1)]
            check = nibble(word)
            self.answer = [1, 0] + [0] * self.busy + [1] + word + check + [0]
        return self.answer.pop(0) if self.answer else 0


def nibble(bits):
    """CRC of control communication: x^4 + x + 1, inverted."""
    register = 0
    for bit in bits:
        feedback = register >> 3 ^ bit
        register = register << 1 & 15 ^ (3 if feedback else 0)
    return [(register ^ 15) >> place & 1 for place in (3, 2, 1, 0)]


class Answer:
    """What the encoder sent for one request: data bits, and how far it came."""

    def __init__(self, time, bits, cds, notes):
        self.time, self.bits, self.cds, self.notes = time, bits, cds, notes
        self.sent = -1  # bits after START; CDS is the first
        self.ack_clocks = 0


class Encoder:
    """Counts the clocks that it sees, answers, and is ready again when its timeout is over."""

    def __init__(self, source, ma, slo, internal, ack, timeout, control=None):
        # source(time, cds) -> Answer; ack() -> (clocks or None, time or None) of the next answer;
        # timeout: ("fixed", ns) | ("adaptive", ns more) | ("cycle", ns) | ("cycle_hard", ns)
        self.source, self.ma, self.slo = source, ma, slo
        self.internal, self.ack, self.timeout, self.control = internal, ack, timeout, control
        self.now, self.level, self.taken = -1e18, 1, 0
        self.pulses, self.pulse_at = [], 0
        self.events = []  # (time, "off" | "on" | "ma_off" | "ma_on"), sorted
        self.alive, self.ma_open, self.pulse_level = True, False, 0
        self.answers = []
        self.cds = 0
        self._idle()

    def _idle(self):
        self.count, self.fell, self.answer, self.deadline, self.started = 0, None, None, math.inf, False
        self.reference = None

    def _drive(self, time, level):
        self.slo.put(time + self.internal, level)

    def run(self, until):
        """Everything that happens at the encoder up to this time."""
        while True:
            self.ma.settle(until)
            edge = self.ma.times[self.taken] if self.taken < len(self.ma.times) else math.inf
            pulse = self.pulses[self.pulse_at] if self.pulse_at < len(self.pulses) else math.inf
            event = self.events[0][0] if self.events else math.inf
            time = min(edge, pulse, event, self.deadline)
            if time > until:
                return
            if time == self.deadline:
                self._time_out(time)
            elif time == event:
                self._event(*self.events.pop(0))
            elif time == pulse:
                self.pulse_at += 1
                self.pulse_level ^= 1
                self._see(time)
            else:
                self.taken += 1
                self._see(time)

    def _see(self, time):
        wire = self.ma.levels[self.taken - 1] if self.taken else self.ma.first
        level = 1 if self.ma_open else wire ^ self.pulse_level
        if level == self.level:
            return
        self.level = level
        if self.alive:
            self._edge(time, level)

    def _event(self, time, what):
        if what == "off":
            self.alive = False
            self._idle()
            self._drive(time, 1)
        elif what == "on":
            self.alive = True
            self.fell = None
        else:
            self.ma_open = what == "ma_off"
            self._see(time)

    def _edge(self, time, level):
        if not level:
            if self.count == 0:
                self.fell = time
        elif self.count or self.fell is not None:
            self._clock(time)
        if self.count:
            self.deadline = self._deadline(time)

    def _clock(self, time):
        self.count += 1
        if self.count == 1:
            self.answer = self.source(time, self.cds)
            self.answers.append(self.answer)
            self.wait_clocks, self.wait_time = self.ack()
            return
        answer = self.answer
        if self.count == 2:
            self.reference = time - self.fell
            self._drive(time, 0)
            answer.ack_clocks = 1
        elif not self.started:
            ready = (answer.ack_clocks >= self.wait_clocks if self.wait_clocks
                     else time - answer.time >= self.wait_time)
            if ready:
                self.started = True
                answer.sent = 0
                self._drive(time, 1)
            else:
                answer.ack_clocks += 1
        else:
            tail = [answer.cds] + answer.bits
            self._drive(time, tail[answer.sent] if answer.sent < len(tail) else 0)
            answer.sent += 1

    def _deadline(self, time):
        kind, value = self.timeout
        if kind == "fixed":
            return time + value
        if kind == "adaptive":
            return time + (20000.0 if self.reference is None else self.reference + value)
        begin = self.fell
        after = 1.5 * (self.reference / 1.5 if self.reference else 4000.0)
        done = self.answer is not None and self.answer.sent > len(self.answer.bits)
        if kind == "cycle_hard" and done and begin + value > time:
            return begin + value
        return max(begin + value, time + after)

    def _time_out(self, time):
        if self.control and self.count >= 2:
            self.cds = self.control.put(1 - self.level)
        self._idle()
        self._drive(time, 1)


class Request:
    """One request as the master sent it."""

    def __init__(self, time):
        self.time, self.rises, self.end = time, [], time
        self.answer = None
        self.notes = set()


class Master:
    """Sends clocks on MA; waits for START, or counts."""

    def __init__(self, encoder, ma, slo, random, period, duty=0.5, jitter=0.0):
        self.encoder, self.ma, self.slo, self.random = encoder, ma, slo, random
        self.inverted = 0  # the master sees the inverse of SLO
        self.period, self.duty, self.jitter = period, duty, jitter
        self.requests = []

    def _edge(self, time, level):
        wobble = self.random.uniform(-self.jitter, self.jitter) if self.jitter else 0.0
        self.ma.put(time + wobble, level)
        return time + wobble

    def look(self, time):
        """The level of SLO, now or before."""
        self.encoder.run(time)
        self.slo.settle(time)
        return self.slo.level(time) ^ self.inverted

    def request(self, time, plan):
        """Sends a request that begins at this time; plan is a Plan. Returns when MA is at rest."""
        request = Request(time)
        self.requests.append(request)
        answers = len(self.encoder.answers)
        start = None
        looked, fell, clock = 0, False, 0
        while True:
            clock += 1
            pause = plan.pauses.get(clock, 0.0)
            if pause and not plan.pause_low:
                time += pause
            self._edge(time, 0)
            rise = time + self.period * (1 - self.duty)
            if pause and plan.pause_low:
                rise += pause
                time += pause
            request.rises.append(self._edge(rise, 1))
            time += self.period
            if plan.clocks is not None:
                if clock >= plan.clocks:
                    break
                continue
            while start is None and looked < len(request.rises):
                sample = request.rises[looked] + plan.sample
                if sample > time:
                    break
                level = self.look(sample)
                looked += 1
                if not fell:
                    fell = looked >= 2 and level == 0
                elif level:
                    start = looked
            if start is not None and clock >= start + plan.after_start:
                break
            if start is None and clock >= plan.start_wait:
                request.notes.add("gave_up")
                break
        end = time
        if plan.cdm:
            self._edge(time, 0)
            hold = time + plan.hold
            limit = hold + 60000.0
            while hold < limit and not self.look(hold):
                hold = max(hold + self.period, min(self.encoder.deadline + plan.sample, limit))
            end = hold + self.period
            self._edge(end, 1)
        request.end = end
        self.encoder.run(request.rises[-1] + self.ma.delay)
        fresh = self.encoder.answers[answers:]
        request.answer = fresh[0] if fresh else None
        return end

    def wait_ready(self, time, longest=70000.0):
        """When SLO is high again, from this time on."""
        limit = time + longest
        while time < limit:
            if self.look(time):
                return time
            step = self.encoder.deadline + self.encoder.internal + self.slo.delay + 4 * self.slo.slope + 1
            time = max(time + self.period, step) if step < limit else time + self.period
        return limit


class Plan:
    """How the master sends one request."""

    def __init__(self, clocks=None, after_start=0, start_wait=100, sample=0.0, pauses=None,
                 pause_low=False, cdm=0, hold=0.0):
        self.clocks, self.after_start, self.start_wait, self.sample = clocks, after_start, start_wait, sample
        self.pauses, self.pause_low, self.cdm, self.hold = pauses or {}, pause_low, cdm, hold
