"""What may be wrong with a line, and with what else it may happen."""
import math

from foreign_format import Channel, Format, Item
from foreign_encoder import Flag

# ---- what may be wrong: each function changes a line that is whole ----

def healthy(line):
    """Nothing."""
    if line.luck.random() < 0.12:
        as_data_sheet(line)


def as_data_sheet(line):
    """An encoder of the catalogue with all that its data sheet demands."""
    bits = line.luck.choice((18, 26, 32))
    line.format = Format([Channel([Item("pos", bits), Item("nE", 1), Item("nW", 1)])], cds0=True)
    line.with_options = ["-f", f"resolute-{bits}"]
    line.period = line.luck.uniform(101, 3900)
    busy = line.luck.uniform(3400, 15000 - min(line.period, 2000))
    line.ack = lambda: (None, busy)
    line.ack_most = math.ceil(busy / line.period)
    line.timeout, line.control, line.internal = ("cycle", 31250.0), False, line.luck.uniform(5, 40)
    line.duty, line.extra = 0.5, 0
    if line.period < 199:
        line.delays = [d / 2 for d in line.delays]
    line.byte_clocks = False
    line.jitter = min(line.jitter, 0.01)


def noise_on_slo(line):
    luck = line.luck
    line.wait_longer()
    line.probe_at_encoder = False
    rate = math.exp(luck.uniform(math.log(0.03), math.log(0.7)))
    wide = luck.uniform(0.2, 2.5)
    late, often = luck.random() < 0.15, luck.choice((1, 1, 2, 5))

    def strike(number, time):
        if luck.random() > rate:
            return
        line.touch("noise_on_slo", number)
        length = (line.format.bits + line.ack_most + 4) * line.period
        at = time + sum(line.delays)
        spans = []
        for _ in range(luck.randint(1, often)):
            begin = at + length * (luck.uniform(0.75, 1) if late else luck.random())
            spans.append((begin, begin + line.period * wide * luck.uniform(0.1, 1)))
        line.slo.add_pulses(spans)
    line.before.append(strike)


def noise_on_ma(line):
    luck = line.luck
    line.wait_longer()
    rate = math.exp(luck.uniform(math.log(0.04), math.log(0.5)))
    seen = luck.choice(("both", "both", "encoder"))
    wide, filtered = luck.uniform(0.1, 0.45), luck.uniform(2, 20)
    line.least_damage = 3 if seen == "both" else 6
    line.probe_at_encoder = False

    def strike(number, time):
        if luck.random() > rate:
            return
        line.touch("noise_on_ma", number)
        length = (line.format.bits + line.ack_most + 4) * line.period
        for begin in sorted(luck.random() for _ in range(luck.choice((1, 1, 1, 3)))):
            begin, width = time + begin * length, line.period * wide * luck.uniform(0.3, 1)
            if width > filtered:
                line.encoder.pulses += [begin + line.delays[0], begin + line.delays[0] + width]
                line.encoder.pulses.sort()
            if seen == "both":
                line.probe_pulses += [(begin, begin + width)]
    line.before.append(strike)


def clock_too_fast_for_cable(line):
    luck = line.luck
    line.period = luck.uniform(101, 700)
    line.probe_at_encoder, line.rhythm = False, "steady"
    line.duty = 0.5
    line.draw_ack()
    slope = line.period * luck.uniform(0.4, 0.9)
    line.slopes = [slope * luck.choice((0, 0.3)), slope]
    line.thresholds = [0.5, luck.uniform(0.35, 0.65)]
    shake = luck.uniform(0.02, 0.12)
    line.start.append(lambda: setattr(line.slo, "shake", lambda: max(-0.25, min(0.25, luck.gauss(0, shake)))))
    line.everywhere = "clock_too_fast_for_cable"


def ack_longer_than_master_waits(line):
    luck = line.luck
    most = max(3, min(60, int(34000 / line.period) - 2))
    low = luck.randint(1, most - 2)
    high = min(most, low + luck.choice((2, 3, 8, 30)))
    planned = luck.randint(low, max(low, high - 1))
    chance = luck.uniform(0.05, 0.9)
    line.ack = lambda: (luck.randint(planned + 1, high) if luck.random() < chance
                        else luck.randint(low, planned), None)
    line.ack_most = planned
    line.extra, line.byte_clocks, line.short = 0, False, {}
    line.follow = luck.random() < 0.4
    line.wait_longer()
    line.start_wait = lambda: planned + 3 + int(sum(line.delays) / line.period)
    line.about["ack"] = ["vary", high]
    line.everywhere = "ack_longer_than_master_waits"


def master_stops_early(line):
    luck = line.luck
    clocks = max(1, min(line.ack_most, 60))
    line.wait_longer()
    line.ack = lambda: (clocks, None)
    line.ack_most = clocks
    line.extra, line.byte_clocks = 0, False
    need = line.format.bits + clocks + 4
    if luck.random() < 0.5:
        stop = need - luck.randint(2, line.format.bits - 2)
        line.moving()  # a last bit that is always 0 would be STOP
        line.cut = lambda number: stop
        line.about["cut"] = "always"
        line.everywhere = "master_stops_early"
        return
    rate = math.exp(luck.uniform(math.log(0.04), math.log(0.6)))

    def cut(number):
        if luck.random() < rate:
            line.touch("master_stops_early", number)
            return luck.randint(clocks + 4, need - 2)
        return None
    line.cut = cut


def master_pauses_clock(line):
    luck = line.luck
    line.extra = 0
    line.wait_longer()
    if line.timeout[0].startswith("cycle"):
        line.timeout = ("fixed", 20000.0)
    kind, value = line.timeout
    timeout = value if kind == "fixed" else 1.5 * line.period
    longest = luck.choice((0.8, 0.8, 1.6)) * timeout
    least = 0.7 * line.period
    if longest < 1.2 * least:
        longest = 1.4 * line.period
    pause = math.exp(luck.uniform(math.log(least), math.log(longest)))
    need = line.format.bits + line.ack_most + 4
    low = luck.random() < 0.25
    if luck.random() < 0.5:  # after each byte; if the encoder gave up there, no frame would be left
        pause = min(pause, 0.8 * timeout)
        step = luck.choice((8, 8, 8, 16))
        line.follow, line.byte_clocks = False, True

        def pauses(number):
            line.touch("master_pauses_clock", number)
            return {clock: pause * luck.uniform(0.95, 1.05)
                    for clock in range(step + 1, need + 8, step)}, low
    else:
        rate = luck.choice((0.05, 0.1, 0.3, 0.8))

        def pauses(number):
            if luck.random() > rate:
                return {}, False
            line.touch("master_pauses_clock", number)
            return {luck.randint(3, need - 1): pause * luck.uniform(0.7, 1.3)}, low
    line.pauses = pauses
    line.counts.add("master_pauses_clock")
    line.about["pause"] = [round(pause), kind, round(timeout)]
    line.timing = ["--timeout", f"static:{value:.0f}ns" if kind == "fixed" else "adaptive"]


def requested_too_soon(line):
    luck = line.luck
    if line.timeout[0] == "adaptive":
        line.timeout = ("fixed", luck.uniform(12600, 39000))
    length = (line.format.bits + line.ack_most + 4) * line.period
    if line.timeout[0].startswith("cycle") and length > 25000:
        line.timeout = ("fixed", luck.uniform(12600, 39000))
    if line.timeout[1] < 4 * line.period:
        line.period = line.timeout[1] / 8
        line.draw_ack()
    line.duty = 0.5
    line.probe_at_encoder, line.control, line.cdm = False, False, {}
    rate = luck.choice((0.05, 0.2, 0.5))
    most = line.timeout[1] if line.timeout[0] == "fixed" else 31250 - length

    def hurry(number):
        if luck.random() > rate:
            return None
        line.touch("requested_too_soon", number + 1)
        return luck.uniform(min(2 * line.period, 0.8 * most), 0.95 * most)
    line.hurry = hurry


def supply_or_intermittent(line):
    luck = line.luck
    line.wait_longer()
    line.probe_at_encoder = False
    kind = luck.choice(("supply", "supply", "slo", "slo", "ma"))
    rate = luck.choice((0.01, 0.03, 0.08))
    longest = luck.choice((0.5, 3, 12))
    line.about["contact"] = kind
    busy = [0.0]

    def strike(number, time):
        if time < busy[0]:
            line.touch("supply_or_intermittent", number)
            line.touch("supply_or_intermittent", number + 1)
            return
        if luck.random() > rate:
            return
        begin = time + luck.random() * (line.format.bits + line.ack_most + 4) * line.period
        # A contact that opens for a few bits only would look like noise.
        end = begin + line.interval * (luck.uniform(0.1, longest) if kind == "supply"
                                       else luck.uniform(0.6, max(1.2, longest)))
        busy[0] = end
        line.touch("supply_or_intermittent", number)
        line.touch("supply_or_intermittent", number + 1)
        if kind == "slo":
            line.slo.forced.append((begin, end, 1))
        else:
            line.encoder.events += [(begin, "off" if kind == "supply" else "ma_off"),
                                    (end, "on" if kind == "supply" else "ma_on")]
    line.before.append(strike)


def no_encoder(line):
    line.start.append(lambda: line.encoder.events.append((-1e15, "off")))
    line.everywhere = "no_encoder"
    line.name_lines()


def stuck_low(line):
    luck = line.luck
    line.wait_longer()
    whole = luck.random() < 0.6
    line.name_lines()
    line.probe_at_encoder = False
    begin, length = luck.uniform(0.1, 0.6) * line.count, luck.uniform(0.2, 1) * line.count
    state = {}

    def strike(number, time):
        if whole and number == 0:
            line.slo.forced.append((-1e18, 1e18, 0))
        if not whole and number >= begin and "end" not in state:
            state["end"] = time + length * line.interval
            line.slo.forced.append((time + luck.random() * line.interval, state["end"], 0))
        if whole or ("end" in state and time < state["end"]):
            line.touch("stuck_low", number)
    line.before.append(strike)


def encoder_error(line):
    luck = line.luck
    if not all(channel.has("nE") for channel in line.format.channels):
        line.format = Format([Channel([Item("pos", luck.randint(12, 36)), Item("nE", 1), Item("nW", 1)])])
    line.flag_kinds["nE"] = luck.choice([kind for kind in Flag.KINDS if kind != "none"])
    if line.flag_kinds["nE"] in ("all", "often"):
        line.moving()
    line.about["nE"] = line.flag_kinds["nE"]
    line.counts.add("encoder_error")
    line.later.append(lambda: [line.touch("encoder_error", r.number) for r in line.requests
                               if r.answer and any(v["nE"] == 0 for v in r.answer.notes)])
    if line.flag_kinds["nE"] == "all":
        line.accept["without"] = ["encoder_error", "healthy"]
        line.unknown = "encoder_error"


def frames_lost_or_repeated(line):
    luck = line.luck
    if not any(channel.has("lc") for channel in line.format.channels):
        bits = luck.randint(14, 36)
        line.format = Format([Channel([Item("pos", bits), Item("nE", 1), Item("nW", 1), Item("lc", 6)], 16)])
    line.short, line.control, line.cdm = {}, False, {}
    line.moving()
    rate, repeat = luck.choice((0.03, 0.1, 0.3)), luck.random() < 0.5
    last = []

    def store(number, values):
        if luck.random() < rate and last:
            line.touch("frames_lost_or_repeated", number)
            if repeat:
                line.touch("frames_lost_or_repeated", number + 1)
                return last[0]
            line.counter += luck.randint(1, 3)
        last[:] = [values]
        return values
    line.store = store
    line.counts.add("frames_lost_or_repeated")


def position_implausible(line):
    luck = line.luck
    line.short = {}
    line.motion_kinds = ("slow", "steady", "sine", "ramp", "stops")
    line.counts.add("position_implausible")
    if luck.random() < 0.5:
        turns, single = luck.choice((8, 12, 16)), luck.randint(10, 14)
        line.format = Format([Channel([Item("mt", turns), Item("st", single), Item("nE", 1), Item("nW", 1)])])
        line.motion_kinds = ("steady",)
        line.turning = luck.uniform(12, 40)
        late = luck.choice((1, 2, 4))
        history = []

        def distort(number, index, value):
            position = value["pos"]
            history.append(position >> single)
            wanted = history[max(0, len(history) - 1 - late)]
            if wanted != position >> single:
                line.touch("position_implausible", number)
            value["mt"] = wanted
        line.about["turns"] = late
    else:
        rate = luck.choice((0.02, 0.05, 0.15))

        def distort(number, index, value):
            if luck.random() < rate:
                line.touch("position_implausible", number)
                size = line.format.channels[index].position_bits
                value["pos"] ^= luck.randrange(1 << (size - 1), 1 << size)
        line.about["turns"] = "jumps"
    line.distort = distort


def limits_exceeded(line):
    luck = line.luck
    kind = luck.choice(("clock", "ack", "sheet_clock", "sheet_slow", "sheet_duty", "sheet_ack"))
    if kind.startswith("sheet"):
        as_data_sheet(line)
        if kind != "sheet_clock":
            line.accept["without"] = ["healthy"]
            line.unknown = "limits_exceeded"
    line.about["limit"] = kind
    line.jitter = 0.0
    if kind in ("clock", "sheet_clock"):
        line.period = luck.uniform(62.5, 97)
        line.delays = [luck.uniform(0, 200), luck.uniform(0, 200)]
        line.duty = 0.5
    elif kind == "sheet_slow":
        line.period = luck.uniform(4100, 8000)
    elif kind == "sheet_duty":
        line.period = luck.uniform(250, 3900)
        line.duty = luck.choice((0.28, 0.34, 0.66, 0.72))
    if kind.endswith("ack"):
        line.period = min(line.period, 2500)
        busy = luck.uniform(43000, 80000) if kind == "ack" else luck.uniform(18500, 34000)
        busy += 2 * line.period  # the encoder counts from LAT
        line.ack = lambda: (None, busy)
        line.ack_most = math.ceil(busy / line.period)
    elif not kind.startswith("sheet"):
        line.draw_ack()
    elif line.with_options:
        busy = luck.uniform(3400, 12000 - min(line.period, 4000) / 2)
        line.ack = lambda: (None, busy)
        line.ack_most = math.ceil(busy / line.period)
    line.start_wait = lambda: line.ack_most + 60 + int(2000 / line.period)
    line.count = min(line.count, max(40, 14000 // (line.format.bits + line.ack_most + 5)))
    line.everywhere = "limits_exceeded"
    line.counts.add("limits_exceeded")


def sampling_too_slow(line):
    line.samples = line.luck.choice((line.luck.uniform(2.4, 4.8), line.luck.uniform(2.4, 2.9)))
    if line.luck.random() < 0.5:  # an unsteady clock, so that edges fall together
        line.jitter, line.duty = 0.08, line.luck.uniform(0.42, 0.58)
    line.everywhere = "sampling_too_slow"
    if line.luck.random() < 0.5:
        line.resolution = True


def wrong_checksum(line):
    luck = line.luck
    kind = luck.choice(("reversed", "no-flags", "previous", "zero", "constant", "random", "data-lsb",
                        "start", "plain"))
    items = lambda: [Item("pos", line_bits), Item("nE", 1), Item("nW", 1)]
    line_bits = luck.randint(12, 36)
    if kind == "start":
        line.format = Format([Channel(items(), start=luck.randint(1, 63))])
    elif kind == "plain":
        line.format = Format([Channel(items(), plain=True)])
    else:
        line.format = Format([Channel(items(), error=kind)])
    if kind in ("start", "plain", "zero", "constant", "random"):  # without a format all is in order
        line.accept["without"] = ["wrong_checksum", "healthy"]
        line.unknown = "wrong_checksum"
    if kind == "no-flags":  # with nE = nW = 1 in all frames it is one remainder off
        line.flag_kinds["nW"] = luck.choice(("tenth", "third", "block"))
    line.given = Format([Channel(items())])
    line.about["checksum"] = kind
    line.moving()
    line.everywhere = "wrong_checksum"
    line.counts.add("wrong_checksum")


def wrong_format(line):
    luck = line.luck
    bits = luck.randint(12, 36)
    items = lambda n: [Item("pos", n), Item("nE", 1), Item("nW", 1)]
    line.format = Format([Channel(items(bits))])
    kind = luck.choice(("width", "width", "crc", "channels"))
    if kind == "width":
        other = bits + luck.choice((-8, -4, -2, -1, 1, 2, 4, 8))
        line.given = Format([Channel(items(max(8, other)))])
    elif kind == "crc":
        line.given = Format([Channel(items(bits), luck.choice((5, 8, 16)))])
    else:
        line.given = line.format
        line.format = Format([Channel(items(bits)), Channel(items(luck.randint(10, 20)))])
    line.short, line.about["given"] = {}, kind
    line.moving()
    line.accept["without"] = None
    line.everywhere = "wrong_format"
    line.counts.add("wrong_format")


def change_length(line):
    """From some request on, the encoder and the master have another format; returns that request."""
    luck, first = line.luck, line.format
    bits = luck.choice([n for n in range(10, 37) if n + 8 != first.bits])
    other = Format([Channel([Item("pos", bits), Item("nE", 1), Item("nW", 1)])])
    when = int(luck.uniform(0.25, 0.75) * line.count)
    line.format_at = lambda number: first if number < when else other
    line.about["second"] = other.text()
    line.follow, line.short = True, {}
    return when


def format_changes(line):
    luck = line.luck
    if luck.random() < 0.6:
        when = change_length(line)
        line.later.append(lambda: [line.touch("format_changes", r.number) for r in line.requests
                                   if r.number >= when])
    else:
        line.follow, line.control = True, True
        line.extra = 0
        kind = luck.choice(("short", "reduced"))
        at = luck.randint(5, 30)
        while at < line.count:
            length = luck.randint(20, 80)
            for number in range(at, min(line.count, at + length)):
                line.short[number] = 2 if kind == "reduced" else 5
                line.touch("format_changes", number)
            at += length + luck.randint(10, 60)
        line.about["second"] = kind
        line.accept = {"with": ["format_changes", "healthy"], "without": ["format_changes", "healthy"]}
    line.counts.add("format_changes")


def ma_slo_swapped(line):
    line.swap, line.everywhere = True, "ma_slo_swapped"
    line.name_lines()
    line.counts.add("ma_slo_swapped")


def slo_inverted(line):
    line.invert[1], line.everywhere = True, "slo_inverted"
    line.name_lines()
    if line.luck.random() < 0.3:  # the wires, so that the master sees it too
        line.follow = True
        line.master_inverted = True
        line.start_wait = lambda: line.ack_most + line.luck.randint(20, 60)
    line.counts.add("slo_inverted")


def ma_inverted(line):
    line.everywhere = "ma_inverted"
    line.name_lines()
    line.counts.add("ma_inverted")
    line.control, line.cdm = False, {}
    if line.luck.random() < 0.6:
        line.invert[0] = True
        line.probe_at_encoder = False
        return
    line.invert_encoder = True  # nearly all that shows it is STOP, so that the format must show
    line.moving()
    line.wait_longer()
    line.probe_at_encoder = False
    line.follow, line.extra, line.byte_clocks = False, 0, False
    clocks = line.ack_most
    line.ack = lambda: (clocks, None)
    line.about["wires"] = True


CAUSES = {f.__name__: f for f in (
    healthy, wrong_format, wrong_checksum, format_changes, ma_slo_swapped, slo_inverted, ma_inverted,
    clock_too_fast_for_cable, ack_longer_than_master_waits, master_stops_early, master_pauses_clock,
    requested_too_soon, noise_on_slo, noise_on_ma, supply_or_intermittent, no_encoder, stuck_low,
    encoder_error, frames_lost_or_repeated, position_implausible, limits_exceeded, sampling_too_slow)}
WEIGHTS = {"healthy": 5, "noise_on_slo": 1.5, "noise_on_ma": 1.5}
PAIRS = (("noise_on_slo", "encoder_error"), ("noise_on_slo", "requested_too_soon"),
         ("noise_on_slo", "master_pauses_clock"), ("noise_on_slo", "supply_or_intermittent"),
         ("encoder_error", "requested_too_soon"), ("encoder_error", "master_pauses_clock"),
         ("encoder_error", "noise_on_ma"), ("wrong_checksum", "supply_or_intermittent"),
         ("position_implausible", "noise_on_slo"), ("encoder_error", "supply_or_intermittent"),
         ("encoder_error", "master_stops_early"), ("frames_lost_or_repeated", "noise_on_slo"),
         ("encoder_error", "ack_longer_than_master_waits"), ("slo_inverted", "noise_on_slo"),
         ("ma_slo_swapped", "encoder_error"), ("limits_exceeded", "noise_on_slo"),
         ("master_stops_early", "noise_on_slo"), ("position_implausible", "requested_too_soon"))
