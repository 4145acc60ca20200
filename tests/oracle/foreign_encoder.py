"""What an encoder sends: how its position moves, when its flags are active, and its frame format."""
import math

from foreign_format import Channel, Format, Item


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
        pads = [Item("pad", luck.randint(1, 6))] if wide and luck.random() < 0.04 else []
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
        second = luck.choice((first, max(12, first - 8)))
        if not wide:  # a word length that no data sheet has is a fault of its own
            first, second = luck.choice(((32, 32), (28, 24), (36, 28)))
            one, two = ([Item("pos", bits), Item("nE", 1), Item("nW", 1)] for bits in (first, second))
            return Format([Channel(one), Channel(two + [Item("lc", 6)], 16)])
        return Format([channel(first, False, 6), channel(second, True, 16)])
    if dice < 0.18:
        return Format([channel(position(10, 30), False, 6) for _ in range(luck.choice((2, 2, 3)))])
    width = luck.choice((5, 8, 16, 16, 7, 4)) if luck.random() < 0.15 else 6
    return Format([channel(position(), width == 16 and luck.random() < 0.5, width)])
