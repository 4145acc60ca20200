"""Lines of `biss simulate` with each of its faults, and the causes that may be first.

The truth has the keys of foreign_lines.py that the judge uses.
"""
import csv
import random
import re
import subprocess

from foreign_format import parse
from foreign_truth import independent

# Each fault, and the causes that describe it; some are seen by what they do only.
FAULTS = {
    "flip": ("noise_on_slo",), "burst": ("noise_on_slo",), "glitch_slo": ("noise_on_slo",),
    "glitch_slo_idle": ("noise_on_slo", "healthy"), "masquerade": ("noise_on_slo",),
    "glitch_ma": ("noise_on_ma",), "glitch_ma_idle": ("noise_on_ma",), "double_clock": ("noise_on_ma",),
    "extra_clock": ("noise_on_ma",), "lost_clock": ("noise_on_ma",),
    "ma_low": ("supply_or_intermittent", "noise_on_ma"), "ma_high": ("supply_or_intermittent", "noise_on_ma"),
    "slo_low": ("stuck_low",), "slo_high": ("supply_or_intermittent", "no_encoder"),
    "no_answer": ("supply_or_intermittent", "no_encoder"), "cut": ("supply_or_intermittent",),
    "brown_out": ("supply_or_intermittent",), "exchange": ("supply_or_intermittent", "ma_slo_swapped"),
    "late_start": ("ack_longer_than_master_waits", "limits_exceeded"),
    "swap_ma": ("ma_inverted",), "swap_slo": ("slo_inverted",), "delay_step": ("clock_too_fast_for_cable",),
    "nE": ("encoder_error",), "nW": ("healthy",), "frozen": ("healthy", "position_implausible"),
    "repeat": ("frames_lost_or_repeated",), "loss": ("frames_lost_or_repeated",),
    "reorder": ("frames_lost_or_repeated", "position_implausible"), "delay": ("healthy",),
    "insert": ("frames_lost_or_repeated", "position_implausible"),
    "other_encoder": ("frames_lost_or_repeated", "position_implausible"),
    "lc_restart": ("frames_lost_or_repeated",), "lc_frozen": ("frames_lost_or_repeated",),
    "ma_pause": ("master_pauses_clock",), "late_turns": ("position_implausible",),
    "short_frame": ("healthy", "format_changes"), "reduced_frame": ("healthy", "format_changes"),
}
COUNTER = ("repeat", "loss", "reorder", "insert", "other_encoder", "lc_restart", "lc_frozen", "masquerade")
HARMLESS = ("nW", "frozen", "delay", "glitch_slo_idle", "short_frame", "reduced_frame")


def unknown_faults(biss):
    """Faults of this command that have no cause above."""
    text = subprocess.run([biss, "simulate", "--help"], text=True, stdout=subprocess.PIPE).stdout
    listed = re.search(r"place in it:(.*?)\n\n", text, re.DOTALL)[1]
    return sorted(set(re.findall(r"\w+", listed)) - set(FAULTS))


def draw_format(luck, counter):
    if counter or luck.random() < 0.15:
        return luck.choice(("pos24,nE,nW,crc6+pos24,nE,nW,lc6,crc16", "mt12,st20,nE,nW,lc6,crc16",
                            "pos28,nE,nW,lc6,crc16"))
    bits = luck.randint(12, 36)
    turns = f"mt12,st{bits - 12}" if bits > 22 and luck.random() < 0.3 else f"pos{bits}"
    return f"{turns},nE,nW,crc6"


def run(biss, luck, text, cycles, faults, folder):
    """Simulates; returns the rows of the truth."""
    period = luck.choice((100, 125, 200, 250, 400, 500, 1000, 2000, 4000))
    command = [biss, "simulate", "-f", text, "--clock", f"{1e9 / period:.0f}Hz", "--cycles", str(cycles),
               "--cable", f"{luck.uniform(0, 50 if period < 200 else 100):.1f}m",
               "--motion", luck.choice(("ramp", "sine", "max", "random", "ramp", "sine")),
               "--processing", f"{luck.uniform(0, 12000):.0f}ns", "--seed", str(luck.randrange(1 << 30)),
               "-o", str(folder / "line.csv"), "--truth", str(folder / "truth.csv")]
    for fault in faults:
        command += ["--fault", fault]
    done = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr}")
    return period, list(csv.DictReader(open(folder / "truth.csv", encoding="utf-8")))


def make(biss, verb, seed, folder):
    """Writes the capture of a seed; returns its truth."""
    for attempt in range(50):
        luck = random.Random(f"simulate {verb} {seed} {attempt}")
        truth = (explain if verb == "explain" else identify)(biss, luck, folder)
        if truth:
            return {"seed": seed, "file": "line.csv", **truth}
    raise RuntimeError(f"simulate {verb} {seed}: nothing happens")


def explain(biss, luck, folder):
    fault = random.Random(luck.random()).choice(list(FAULTS) + ["none"] * 8)
    text = "mt12,st12,nE,nW,crc6" if fault == "late_turns" else draw_format(luck, fault in COUNTER)
    share = luck.choice((0.03, 0.1, 0.3))
    faults = [] if fault == "none" else [f"{fault}:{share}"]
    cycles = luck.randint(100, 400)
    period, rows = run(biss, luck, text, cycles, faults, folder)
    damaged = [int(row["cycle"]) for row in rows if row["faults"]]
    if fault != "none" and len(damaged) < max(5, 0.02 * cycles):
        return None
    causes = list(FAULTS.get(fault, ("healthy",)))
    return {"causes": causes[:1], "format": text, "without": [], "with": ["-f", text],
            "accept": {"with": causes, "without": causes}, "requests": cycles, "damaged": damaged,
            "ill": bool(faults) and fault not in HARMLESS, "marks": {}, "answered": 1.0, "parts": [],
            "about": {"fault": fault, "share": share, "period": period}}


def identify(biss, luck, folder):
    text = draw_format(luck, False)
    faults = []
    for flag in ("nE", "nW"):
        if luck.random() < 0.4:
            faults.append(f"{flag}:{luck.choice((0.01, 0.1, 0.3, 0.6, 0.9))}")
    if luck.random() < 0.4:
        faults.append(f"{luck.choice(('flip', 'glitch_ma', 'burst', 'lost_clock', 'cut'))}:0.03")
    cycles = luck.randint(50, 400)
    period, rows = run(biss, luck, text, cycles, faults, folder)
    frame_format = parse(text)
    lows, frames = [], []
    for row in rows:
        if row["position"] == "" or set(row["faults"].split(";")) - {"", "nE", "nW"}:
            continue
        values = []
        for number, channel in enumerate(frame_format.channels):
            end = "" if number == 0 else str(number + 1)
            position = int(row["position" + end])
            value = {"pos": position, "nE": int(row["nE" + end]), "nW": int(row["nW" + end]),
                     "lc": int(row.get("lc" + end) or row.get("lc") or 0)}
            for item in channel.items:
                if item.kind == "st":
                    value["mt"], value["st"] = position >> item.bits, position
            values.append(value)
        lows.append(values)
        frames.append(frame_format.frame(values))
    if len(frames) < 20:
        return None
    moved, rank, low, at = [], [], [], 0
    for number, channel in enumerate(frame_format.channels):
        words = [frame[at:at + channel.data_bits] for frame in frames]
        at += channel.bits
        moved.append("".join(str(int(len(set(column)) > 1)) for column in zip(*words)))
        rank.append(independent([int("".join(map(str, word)), 2) for word in words]))
        low.append({flag: sum(v[number][flag] == 0 for v in lows) / len(lows) for flag in ("nE", "nW")})
    part = {"format": text, "from": 0, "to": cycles - 1, "moved": moved, "rank": rank, "low": low,
            "smooth": True, "frames": ["0 " + "".join(map(str, frame)) for frame in frames]}
    return {"causes": ["healthy"], "format": text, "without": [], "parts": [part],
            "about": {"motion": [""], "period": period, "flags": {}, "faults": faults}}
