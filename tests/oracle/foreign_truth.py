"""What is true of a line that has run: its frames as a plain reader sees them, and what they show."""
import bisect

from foreign_format import FLAGS, USUAL


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


class Truth:
    """The part of a line that looks back; see Line for what it has."""

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

    def smear(self):
        """Share of SLO's changes that are visibly beside their usual place in a bit."""
        delay = self.seen_delay()
        rises = [rise - self.from_time for request in self.inside() for rise in request.rises]
        limit = 0.12 * self.period + (self.step or 0)
        beside = []
        for time in self.captured[1][1]:
            at = bisect.bisect_right(rises, time - delay + self.period / 2) - 1
            distance = abs(time - delay - rises[at]) if at >= 0 else self.period
            if distance <= self.period / 2:
                beside.append(distance > limit)
        return sum(beside) / len(beside) if beside else 0.0

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
        if self.slopes[1] or self.invert_encoder or (self.samples or 9) < 5.5:
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
        if self.slopes[1] and (len(verdicts) - len(bad) < 3 or self.smear() < 0.15):
            return False
        least = max(self.least_damage, 0.01 * len(whole))
        enough = all(len(marks) >= least for marks in self.marks.values())
        self.name()
        return enough or self.causes == ["sampling_too_slow"]

    def truth(self):
        whole = self.inside()
        first = whole[0].number if whole else 0
        given = self.given or self.format
        options = list(self.options)
        if self.resolution:
            options += ["--resolution", f"{self.step:.3f}ns"]
        with_format = self.with_options or (["-f", given.text()] if given.text() else None)
        if with_format and self.timing and self.luck.random() < 0.5:
            with_format = with_format + self.timing
        damaged = sorted({n for marks in self.marks.values() for n in marks})
        accept = {mode: self.accept.get(mode, list(self.causes)) for mode in ("with", "without")}
        if "encoder_error" in self.causes and min(self.frames(self.format)["rank"]) < 4:
            # Nothing shows which bit is nE.
            self.unknown = "encoder_error"
            accept["without"] = ["encoder_error", "healthy"]
        if len(self.causes) == 2:
            accept = {"with": list(self.causes),
                      "without": [cause for cause in self.causes if cause != self.unknown]}
        if self.causes == ["sampling_too_slow"] and len(damaged) < max(3, 0.01 * len(whole)):
            accept = {mode: ["sampling_too_slow", "healthy"] for mode in accept}
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
            "parts": self.parts(),
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
            flags = {(a.notes[index]["nE"], a.notes[index]["nW"])
                     for a in answers if index < len(a.notes)}
            if channel.error == "no-flags" and len(flags) < 2:
                return False
        return True

    def readable(self):
        """Whether what is unusual in this format shows in the frames: it cannot be known otherwise."""
        kept = self.frames(self.format)
        for index, channel in enumerate(self.format.channels):
            moved, rank = kept["moved"][index].count("1"), kept["rank"][index]
            unusual = (channel.polynomial != USUAL.get(channel.width) or channel.start or channel.plain
                       or channel.error)
            if unusual and rank < 6 or channel.error and len(self.format.channels) > 1:
                return False
            if any(item.gray or item.lsb for item in channel.items) and (moved < 6 or not kept["smooth"]):
                return False
            kinds = [item.kind for item in channel.items if item.kind in FLAGS]
            odd = kinds != ["nE", "nW"] or channel.items[0].kind in FLAGS
            if odd and (rank < 6 or any(item.kind == "pad" and item.bits > 1 for item in channel.items)):
                return False
            if odd and (kinds != ["nE"] or channel.items[0].kind in FLAGS):
                for kind, low in kept["low"][index].items():
                    active = low if kind in ("nE", "nW") else 1 - low
                    if not 0 < active < 0.5:
                        return False
            if len(self.format.channels) > 1 and rank < 3:
                return False
        return True

    def parts(self):
        """What the frames show, a dict for each format that the encoder has sent."""
        whole = self.inside()
        result = []
        for frame_format in dict.fromkeys(self.format_at(request.number) for request in whole):
            mine = [place for place, request in enumerate(whole)
                    if self.format_at(request.number) is frame_format]
            result.append({"format": frame_format.text(), "from": mine[0], "to": mine[-1],
                           **self.frames(frame_format)})
        return result

    def frames(self, frame_format):
        """What the good frames of this format show: moved bits, flags, independent frames."""
        answers = [r.answer for r in self.inside() if r.answer and r.answer.sent > len(r.answer.bits)
                   and len(r.answer.bits) == frame_format.bits]
        moved, low, rank, at = [], [], [], 0
        counted = False
        for index, channel in enumerate(frame_format.channels):
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
