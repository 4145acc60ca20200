"""Two lines that carry something else than BiSS C. Each function returns [(first level, changes)] * 2.

The first line is the clock, if there is one. Times are nanoseconds.
"""
import math


class Trace:
    """A line that is drawn from left to right."""

    def __init__(self, level=1):
        self.first = self.now = level
        self.times = []

    def set(self, time, level):
        if level != self.now:
            self.now = level
            self.times.append(time)

    def pair(self):
        return self.first, self.times


def word_crc(bits, polynomial, width, start=0):
    register = start
    for bit in bits:
        top = register >> (width - 1) & 1
        register = (register << 1) & ((1 << width) - 1)
        if top ^ bit:
            register ^= polynomial
    return [register >> place & 1 for place in range(width - 1, -1, -1)]


def bits_of(value, count):
    return [value >> place & 1 for place in range(count - 1, -1, -1)]


def ssi(luck):
    """A shift register and a monoflop: the first bit comes with the first rising edge."""
    clock, data = Trace(), Trace()
    period = math.exp(luck.uniform(math.log(500), math.log(8000)))
    bits, gray = luck.randint(10, 32), luck.random() < 0.5
    mono, delay = luck.uniform(10000, 30000), luck.uniform(20, min(600, 0.4 * period))
    parity, extra = luck.random() < 0.3, luck.choice((0, 0, 1, 3))
    position, speed = luck.randrange(1 << bits), luck.uniform(-1, 1) * 2 ** luck.uniform(0, bits / 2)
    time = 50000.0
    for number in range(luck.randint(50, 200)):
        value = int(position + speed * number) % (1 << bits)
        value = value ^ value >> 1 if gray else value
        word = bits_of(value, bits)
        word += [sum(word) & 1] if parity else []
        for index in range(len(word) + 1 + extra):
            clock.set(time, 0)
            clock.set(time + period / 2, 1)
            data.set(time + period / 2 + delay, word[index] if index < len(word) else 0)
            time += period
        end = time - period / 2 + mono
        data.set(end, 1)
        time = end + luck.uniform(0.5, 4) * mono
    return [clock.pair(), data.pair()]


def endat(luck):
    """A mode command of the master, then start bit, alarm, position and five CRC bits."""
    clock, data = Trace(1), Trace(0)
    period = luck.choice((125.0, 250.0, 500.0, 1000.0, 4000.0))
    bits, delay = luck.randint(13, 37), luck.uniform(10, 0.2 * period)
    position, speed, time = luck.randrange(1 << bits), luck.uniform(-500, 500), 40000.0
    mode = luck.choice(([0, 0, 0, 1, 1, 1], [1, 1, 1, 0, 0, 0]))
    for number in range(luck.randint(50, 150)):
        value = int(position + speed * number) % (1 << bits)
        payload = [1] + [0] * (mode[0] + 1) + [value >> place & 1 for place in range(bits)]
        word = payload + word_crc(payload[1:], 0x0B, 5, 31)
        wait = max(1, int(luck.uniform(3000, 5000) / period))
        sent = [0, 0] + mode + [0, 0] + [0] * wait + word
        for index, bit in enumerate(sent):
            clock.set(time, 0)
            clock.set(time + period / 2, 1)
            if index < 10:
                data.set(time + 1, bit)
            else:
                data.set(time + period / 2 + delay, bit)
            time += period
        time += luck.uniform(0, period)
        data.set(time, 1)
        data.set(time + luck.uniform(10000, 30000), 0)
        time += luck.uniform(35000, 80000)
    return [clock.pair(), data.pair()]


def spi(luck):
    """A sensor on SPI: bytes, mode 0 or 3, most significant bit first."""
    mode = luck.choice((0, 3))
    clock, data = Trace(1 if mode else 0), Trace(luck.choice((0, 1)))
    period = luck.choice((100.0, 250.0, 500.0, 1000.0, 2000.0))
    count, gap = luck.choice((1, 2, 2, 3, 4, 6)), luck.choice((0.0, 1.0, 4.0)) * period
    delay = luck.uniform(5, 0.2 * period)
    value, speed, time = luck.randrange(1 << 14), luck.uniform(-40, 40), 30000.0
    command = luck.getrandbits(8)
    for number in range(luck.randint(60, 200)):
        sample = int(value + speed * number + luck.gauss(0, 2)) & 0x3FFF
        word = (bits_of(command, 8) + bits_of(sample << 2 | luck.getrandbits(1), 16) * 3)[:8 * count] \
            if count > 2 else bits_of(sample << 2 | 1, 16)[:8 * count]
        for index, bit in enumerate(word):
            if index and index % 8 == 0:
                time += gap
            if mode:
                clock.set(time, 0)
                data.set(time + delay, bit)
                clock.set(time + period / 2, 1)
            else:
                data.set(time - period / 2 + delay, bit)
                clock.set(time, 1)
                clock.set(time + period / 2, 0)
            time += period
        time += luck.uniform(5000, 8000) + 20 * period
    return [clock.pair(), data.pair()]


def uart_bytes(trace, time, data, bit, parity=None):
    """Sends bytes with a start bit and a stop bit; returns the end."""
    for byte in data:
        word = [0] + [byte >> place & 1 for place in range(8)]
        if parity is not None:
            word.append(bin(byte).count("1") + parity & 1)
        for level in word + [1]:
            trace.set(time, level)
            time += bit
    return time


def uart(luck):
    """Request and answer, each on its line, at one bit time."""
    one, two = Trace(), Trace()
    bit = 1e9 / luck.choice((9600, 19200, 115200, 230400, 460800, 921600, 1000000, 2000000))
    parity, time = luck.choice((None, None, 0, 1)), 20 * bit
    text = luck.random() < 0.5
    for number in range(luck.randint(30, 120)):
        question = [luck.randrange(32, 127) if text else luck.getrandbits(8)
                    for _ in range(luck.randint(1, 8))]
        time = uart_bytes(one, time, question, bit, parity) + luck.uniform(2, 40) * bit
        answer = [luck.randrange(32, 127) if text else luck.getrandbits(8)
                  for _ in range(luck.randint(1, 12))]
        time = uart_bytes(two, time, answer, bit, parity) + luck.uniform(5, 100) * bit
    return [one.pair(), two.pair()]


def i2c(luck):
    """A master that reads registers."""
    clock, data = Trace(), Trace()
    period = luck.choice((10000.0, 2500.0, 1000.0))
    time, address = 5 * period, luck.randrange(8, 120)

    def send(time, byte, ack):
        for bit in bits_of(byte, 8) + [ack]:
            data.set(time + 0.1 * period, bit)
            clock.set(time + 0.5 * period, 1)
            clock.set(time + period, 0)
            time += period
        return time

    for number in range(luck.randint(25, 80)):
        data.set(time, 0)
        clock.set(time + period / 2, 0)
        time = send(time + period / 2, address << 1, 0)
        time = send(time, luck.randrange(4), 0)
        data.set(time + 0.1 * period, 1)
        clock.set(time + 0.4 * period, 1)
        data.set(time + 0.7 * period, 0)
        clock.set(time + period, 0)
        time = send(time + period, address << 1 | 1, 0)
        count = luck.choice((1, 2, 6))
        for index in range(count):
            time = send(time, luck.getrandbits(8), int(index == count - 1))
        data.set(time + 0.1 * period, 0)
        clock.set(time + 0.5 * period, 1)
        data.set(time + period, 1)
        time += luck.uniform(3, 30) * period
    return [clock.pair(), data.pair()]


def tamagawa(luck):
    """Half duplex at 2.5 or 4 Mbit/s: a control field, then status, position and CRC; and its driver."""
    data, enable = Trace(), Trace(0)
    bit = luck.choice((400.0, 250.0))
    bits = luck.choice((17, 20, 23))
    position, speed, time = luck.randrange(1 << bits), luck.uniform(-900, 900), 20000.0
    for number in range(luck.randint(50, 150)):
        enable.set(time - bit, 1)
        end = uart_bytes(data, time, [0x02], bit)
        enable.set(end, 0)
        value = int(position + speed * number) % (1 << bits)
        body = [0x02, 0x00, value & 255, value >> 8 & 255, value >> 16 & 255]
        check = 0
        for byte in body:
            check ^= byte
            for _ in range(8):
                check = (check << 1 ^ 1) & 255 if check & 128 else check << 1
        time = uart_bytes(data, end + luck.uniform(2500, 3500), body + [check], bit)
        time += luck.uniform(20000, 60000)
    return [data.pair(), enable.pair()]


def hiperface_dsl(luck):
    """A scrambled stream at 9.375 Mbit/s, never more than five equal bits; and a trigger."""
    data, trigger = Trace(), Trace(0)
    bit, time = 1e3 / 9.375, 1000.0
    equal, level = 0, 1
    for number in range(luck.randint(20, 60)):
        trigger.set(time, 1)
        trigger.set(time + 20 * bit, 0)
        for _ in range(luck.choice((108, 108, 116))):
            bit_value = luck.getrandbits(1)
            if equal >= 5:
                bit_value = 1 - level
            equal = equal + 1 if bit_value == level else 1
            level = bit_value
            data.set(time, level)
            time += bit
    return [data.pair(), trigger.pair()]


def quadrature(luck):
    """A and B of an incremental encoder that speeds up, slows down and turns around."""
    one, two = Trace(0), Trace(0)
    step = math.exp(luck.uniform(math.log(300), math.log(30000)))
    time, place, direction = 10000.0, 0, luck.choice((-1, 1))
    for number in range(luck.randint(1000, 5000)):
        place += direction
        one.set(time, int(place % 4 in (1, 2)))
        two.set(time, int(place % 4 in (2, 3)))
        time += step * (1 + 0.8 * math.sin(number / 300)) * luck.uniform(0.9, 1.1)
        if luck.random() < 0.002:
            direction = -direction
    return [one.pair(), two.pair()]


def noise(luck):
    """Two open inputs."""
    traces = []
    for _ in range(2):
        trace, time = Trace(), 0.0
        mean = math.exp(luck.uniform(math.log(50), math.log(5000)))
        for _ in range(luck.randint(800, 4000)):
            time += luck.expovariate(1 / mean) * (1 if luck.random() < 0.97 else 30) + 3
            trace.set(time, 1 - trace.now)
        traces.append(trace.pair())
    return traces


PROTOCOLS = {"ssi": ssi, "endat": endat, "spi": spi, "uart": uart, "i2c": i2c, "tamagawa": tamagawa,
             "hiperface_dsl": hiperface_dsl, "quadrature": quadrature, "noise": noise}
