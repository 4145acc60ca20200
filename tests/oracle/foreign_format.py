"""Frame formats, as text and as bits: a reading of the grammar that uses no code of the project.

    parse("pos26,nE,nW,crc6").frame([{"pos": 5, "nE": 1, "nW": 1}])     -> 34 bits
"""
import re

USUAL = {3: 0xB, 4: 0x13, 5: 0x25, 6: 0x43, 7: 0x89, 8: 0x12F, 16: 0x190D9}
FLAGS = ("nE", "nW", "E", "W")
# What a maker may do wrong, and the suffix of `crc` that reads it; without a suffix nothing reads it.
ERRORS = {"reversed": ":reversed", "no-flags": ":no-flags", "cds": ":cds", "previous": ":previous",
          "zero": None, "constant": None, "random": None, "data-lsb": None}


def reverse(value, bits):
    """The bits in the other order."""
    return int(f"{value:0{bits}b}"[::-1], 2) if bits else 0


def remainder(value, bits, polynomial, start=0):
    """The CRC register after these bits, highest first; `polynomial` has its top bit."""
    width = polynomial.bit_length() - 1
    register = start
    for place in range(bits - 1, -1, -1):
        feedback = (register >> (width - 1)) & 1 ^ (value >> place) & 1
        register = (register << 1) & ((1 << width) - 1)
        if feedback:
            register ^= polynomial & ((1 << width) - 1)
    return register


class Item:
    """Some bits of a channel with one meaning."""

    def __init__(self, kind, bits, gray=False, lsb=False):
        self.kind, self.bits, self.gray, self.lsb = kind, bits, gray, lsb

    def text(self):
        size = "" if self.kind in FLAGS else str(self.bits)
        return f"{self.kind}{size}{':gray' * self.gray}{':lsb' * self.lsb}"

    def on_line(self, value):
        if self.gray:
            value ^= value >> 1
        return reverse(value, self.bits) if self.lsb else value


class Channel:
    """Items in line order, and the checksum over them."""

    def __init__(self, items, width=6, polynomial=None, start=0, plain=False, error=None):
        self.items, self.width, self.start, self.plain, self.error = items, width, start, plain, error
        self.polynomial = polynomial or USUAL.get(width)
        self.data_bits = sum(item.bits for item in items)
        self.position_bits = sum(i.bits for i in items if i.kind in ("pos", "mt", "st"))
        self.last = 0

    @property
    def bits(self):
        return self.data_bits + self.width

    def has(self, kind):
        return any(item.kind == kind for item in self.items)

    def text(self):
        parts = [item.text() for item in self.items]
        if self.width:
            crc = f"crc{self.width}"
            if self.polynomial != USUAL.get(self.width) or self.start:
                crc += f":0x{self.polynomial:X}"
            if self.start:
                crc += f":0x{self.start:X}"
            parts.append(crc + ":plain" * self.plain + (ERRORS.get(self.error) or ""))
        return ",".join(parts)

    def data(self, values):
        """The word on the line of these values: {kind: value}."""
        word = 0
        for item in self.items:
            word = word << item.bits | item.on_line(values[item.kind] & ((1 << item.bits) - 1))
        return word

    def checksum(self, word, cds=0, luck=None):
        """The checksum as sent, with the maker's error; `luck` is a source of random numbers."""
        mask = (1 << self.width) - 1
        value, bits = word, self.data_bits
        if self.error == "no-flags":
            flags = sum(item.bits for item in self.items if item.kind in FLAGS)
            value, bits = word >> flags, bits - flags
        elif self.error == "cds":
            value, bits = word | cds << bits, bits + 1
        elif self.error == "data-lsb":
            value = reverse(word, bits)
        crc = remainder(value, bits, self.polynomial, self.start) ^ (0 if self.plain else mask)
        if self.error == "reversed":
            return reverse(crc, self.width)
        if self.error == "previous":
            crc, self.last = self.last, crc
            return crc
        if self.error == "zero":
            return 0
        if self.error == "constant":
            return 0x15 & mask
        return luck.getrandbits(self.width) if self.error == "random" else crc


class Format:
    """The channels of a frame."""

    def __init__(self, channels, cds0=False):
        self.channels, self.cds0 = channels, cds0

    @property
    def bits(self):
        return sum(channel.bits for channel in self.channels)

    def text(self):
        """As for -f; None if the grammar has no word for the maker's error."""
        if any(c.error and not ERRORS[c.error] for c in self.channels):
            return None
        return "+".join(channel.text() for channel in self.channels) + ";cds0" * self.cds0

    def frame(self, values, cds=0, luck=None):
        """The bits from the first channel's data to the last CRC; `values` has a dict a channel."""
        bits = []
        for channel, value in zip(self.channels, values):
            word = channel.data(value)
            word = word << channel.width | (channel.checksum(word, cds, luck) if channel.width else 0)
            bits += [word >> place & 1 for place in range(channel.bits - 1, -1, -1)]
        return bits


ITEM = re.compile(r"(pos|mt|st|pad|lc)(\d+)((?::gray|:lsb)*)$|(nE|nW|E|W)$")
CRC = re.compile(r"crc(\d+)(?::0x([0-9A-Fa-f]+))?(?::0x([0-9A-Fa-f]+))?"
                 r"((?::plain|:reversed|:no-flags|:cds|:previous)*)$")


def parse(text):
    """The format of this text; ValueError if it is not of the grammar."""
    body, *options = text.split(";")
    channels = []
    for part in body.split("+"):
        items, crc = [], {"width": 0}
        for word in part.split(","):
            if match := CRC.match(word):
                suffixes = match[4].split(":")[1:]
                errors = [s for s in suffixes if s != "plain"]
                crc = {"width": int(match[1]), "polynomial": int(match[2], 16) if match[2] else None,
                       "start": int(match[3] or "0", 16), "plain": "plain" in suffixes,
                       "error": errors[0] if errors else None}
            elif match := ITEM.match(word):
                kind = match[1] or match[4]
                items.append(Item(kind, int(match[2] or 1), ":gray" in (match[3] or ""),
                                  ":lsb" in (match[3] or "")))
            else:
                raise ValueError(f"'{word}' in '{text}'")
        channels.append(Channel(items, **crc))
    return Format(channels, "cds0" in options)
