"""Compares the format that the command gives with the one that the encoder sent.

A difference is *shown* if the frames contradict the answer: a bit that moved, a flag that was used,
the checksum of an axis that moved. It is *hidden* if no frame of this capture could tell: a bit that
never moved, polarity of a flag that is mostly 0, Gray code of few bits, scale, the checksum of an
axis at rest.
"""
from foreign_format import FLAGS, parse

MOVED_ENOUGH = 4  # independent frames that make a checksum known


def bits_of(frame_format):
    """What each bit of a frame is: (kind, channel, weight, gray field)."""
    places = []
    for number, channel in enumerate(frame_format.channels):
        below = {"mt": sum(i.bits for i in channel.items if i.kind == "st")}
        for index, item in enumerate(channel.items):
            for place in range(item.bits):
                weight = place if item.lsb else item.bits - 1 - place
                kind = "pos" if item.kind in ("pos", "mt", "st") else item.kind
                weight += below.get(item.kind, 0)
                places.append((kind, number, weight, (number, index) if item.gray else None))
        places += [("crc", number, channel.width - 1 - place, None) for place in range(channel.width)]
    return places


def spans(frame_format):
    """(begin, begin of the checksum, end, channel) of each channel."""
    at, result = 0, []
    for channel in frame_format.channels:
        result.append((at, at + channel.data_bits, at + channel.bits, channel))
        at += channel.bits
    return result


def fits(begin, middle, end, channel, frames):
    """Share of the frames whose checksum is right; None if the frames alone do not tell."""
    if not channel.width:
        return None
    if channel.error == "previous" or not frames:
        return None
    good = 0
    for cds, bits in frames:
        word = int(bits[begin:middle] or "0", 2)
        good += channel.checksum(word, cds) == int(bits[middle:end] or "0", 2)
    return good / len(frames)


def positions(truth, moved, answer, smooth, shown, hidden):
    """Compares the bits of the positions that moved; returns those that a Gray code leaves open."""
    for number in {place[1] for place, move in zip(truth, moved) if place[0] == "pos"}:
        mine = [i for i, (p, m) in enumerate(zip(truth, moved)) if p[0] == "pos" and p[1] == number and m]
        if not mine:
            continue
        lost = [i for i in mine if i >= len(answer) or answer[i][0] != "pos"]
        if lost:
            shown.append(f"moving position bits {lost[:4]} are {[answer[i][0] for i in lost[:4] if i < len(answer)]}")
            continue
        if len({answer[i][1] for i in mine}) > 1:
            shown.append("a position lies in two channels")
            continue
        low = min(mine, key=lambda i: truth[i][2])
        steps = [(truth[i][2] - truth[low][2], answer[i][2] - answer[low][2]) for i in mine]
        if any(a != b for a, b in steps):
            (shown if smooth and len(mine) > 2 else hidden).append("order of the position's bits")
        elif truth[low][2] != answer[low][2]:
            hidden.append("scale")
        if [truth[i][3] == truth[low][3] for i in mine if truth[i][3]] != [
                answer[i][3] == answer[low][3] for i in mine if answer[i][3]]:
            (shown if smooth and len(mine) > 3 else hidden).append("Gray code")


def leads(places, moved, index):
    """Whether only padding and still position bits are between this bit and a position."""
    channel = places[index][1]
    for place, move in zip(places[index:], moved[index:]):
        if place[1] != channel or place[0] not in ("pad", "pos"):
            return False
        if place[0] == "pos":
            return True
    return False


def compare(text, truth, record):
    """(right, shown, hidden): differences between an answered format and the true one."""
    shown, hidden = [], []
    answer = parse(text)
    frames = [(int(frame[0]), frame[2:]) for frame in record["frames"]]
    moved = []
    for channel, pattern in zip(truth.channels, record["moved"]):
        moved += [bit == "1" for bit in pattern or "0" * channel.data_bits] + [False] * channel.width
    one, two = bits_of(truth), bits_of(answer)
    smooth = record["smooth"]
    # Checksums.
    theirs = {(middle, end): (begin, channel) for begin, middle, end, channel in spans(answer)}
    for number, (begin, middle, end, channel) in enumerate(spans(truth)):
        where = shown if record["rank"][number] >= MOVED_ENOUGH else hidden
        if not channel.width:
            continue
        if (middle, end) not in theirs:
            where.append(f"checksum of channel {number + 1}")
            continue
        other_begin, other = theirs.pop((middle, end))
        if other.polynomial != channel.polynomial:
            where.append("polynomial")
        elif other.error != channel.error:
            where.append("kind of checksum")
        elif other_begin != begin:
            low, high = sorted((begin, other_begin))
            (shown if any(moved[low:high]) else hidden).append("begin of the checksum")
        else:
            share = fits(other_begin, middle, end, other, frames)
            if share is not None and share < 0.9:
                where.append("start value")
    for (middle, end), (begin, channel) in theirs.items():
        if channel.width:
            (shown if any(record["rank"][n] >= MOVED_ENOUGH for n in range(len(truth.channels)))
             else hidden).append("a checksum where none is")
    if len(two) > len(one):
        (shown if max(record["rank"]) >= MOVED_ENOUGH else hidden).append("too long")
    positions(one, moved, two, smooth, shown, hidden)
    # Flags, signs of life, and bits that never moved.
    lows = [{**low} for low in record["low"]]
    for index, (place, move) in enumerate(zip(one, moved)):
        if place[0] in ("pos", "crc"):
            continue
        got = two[index][0] if index < len(two) else "nothing"
        if place[0] in FLAGS and move:
            low = lows[place[1]].get(place[0], 0)
            active_low = place[0] in ("nE", "nW")
            if got not in FLAGS:
                shown.append(f"{place[0]} is {got}")
            elif got != place[0]:
                mostly = low if active_low else 1 - low
                (hidden if mostly >= 0.3 or (got in ("nE", "nW")) == active_low
                 else shown).append(f"{place[0]} is {got}")
        elif place[0] == "lc" and move:
            if got != "lc" or two[index][2] != place[2]:
                shown.append(f"sign of life is {got}")
        elif got != place[0] and not (place[0] == "pad" and got == "pos" and not move
                                      and one[index + 1][0] in ("pad", "pos")
                                      and leads(one, moved, index)):
            hidden.append(f"{place[0]}, which never moved, is {got}")
    # Bits of the position that never moved: leading ones may be turns, singleturn or padding.
    for number in {place[1] for place in one}:
        mine = [i for i, p in enumerate(one) if p[0] == "pos" and p[1] == number]
        top = max((one[i][2] for i in mine if moved[i]), default=-1)
        for i in mine:
            got = two[i][0] if i < len(two) else "nothing"
            if not moved[i] and got != "pos" and not (one[i][2] > top and got == "pad"):
                hidden.append(f"a still position bit is {got}")
                break
    return not shown and not hidden, shown, hidden
