#!/usr/bin/env python3
"""Damaged and hostile requests to the server of `biss view`, over 127.0.0.1.

    view_fuzz.py BISS [REQUESTS [SEED]]

Every answer is compared with an independent reading of the request: 200 and 206 only with the token
and the Host of the server, with exactly the bytes of the capture that the request asks for. After
each batch the server must answer a good request, and keep its memory and its number of open files.
Exit with 1 at the first fault, after printing its seed and its requests.
"""
import os
import random
import re
import socket
import struct
import subprocess
import sys
import tempfile
import time

PAGE = b'<body><script type="text/plain" id="biss-core">CORE</script></body>'
CAPTURE = b"time_ns,MA,SLO\n" + b"".join(b"%d,%d,1\n" % (100 * n, n % 2) for n in range(150))
SIZE = len(CAPTURE)
REFUSALS = {400: b"This is not an HTTP request.\n", 404: b"Not here.\n", 405: b"Only GET and HEAD.\n",
            403: b"This server is known by another name.\n"
                 b"This address does not have the token that biss view printed.\n"}
HEAD_OF_ANSWER = re.compile(rb"HTTP/1\.1 (\d{3}) [ -~]+\r\n((?:[A-Za-z-]+: [ -~]*\r\n)+)\r\n")
CONNECTIONS = 8  # at a time; the server keeps 32
BATCH = 2000  # answers
NUMBERS = [b"%02d" % n for n in (0, 1, SIZE // 2, SIZE - 1, SIZE, SIZE + 1, 2**64 - 1, 2**64, 10**40)]
# Separated by '|'.
WORDS = (b"\r\n|\n|\r| |\t|\0|:|,|/|//|../|%2e%2e%2f|%00|\\|?|#|*|@|-|bytes=|-1|\xff\xfe|GET |HEAD | HTTP/1.1|\r\n |"
         b"Host:|Host: evil.example\r\n|\r\n\r\n|Transfer-Encoding: chunked\r\n|Transfer-Encoding: gzip\r\n|0\r\n\r\n|"
         b"If-Range: x\r\n|Content-Length: 7\r\n|PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n").split(b"|")
METHODS = b"get|POST|PUT|TRACE|CONNECT|OPTIONS|BREW|GET\0||G T".split(b"|")
VERSIONS = b"HTTP/1.0|HTTP/2.0|HTTP/0.9|http/1.1|HTTP/1.10||HTTP/1.1 ".split(b"|")
# PATH is /TOKEN/, HOST the right name.
TARGETS = (b"/|*|HOST|http://HOSTPATH|/PATH|PATH../a.csv|PATH%2e%2e%2fsecret|PATH%252e%252e/secret|PATHcapture%00|"
           b"PATHcapture\0|PATH..\\secret|PATHcapture?x|PATHcapture#|/xPATH|PATHPATH|PATH\xc0\xae\xc0\xae/secret|"
           b"PATHsize/|PATH size|/0PATH|/%2fPATH|/.PATHcapture|/../PATHcapture").split(b"|") + [b"PATH" + b"a" * 20000]
HOSTS = (b"|Host:|Host: evil.example|Host: 127.0.0.1|Host: HOST\r\nHost: HOST|Host : HOST|Host: HOST.|hostHOST|X: HOST|"
         b"Host: evil.HOST| Host: HOST|Host: a@HOST|Host: HOST,HOST|Host: HOST\0|Host: HOST0|Host: [HOST]|"
         b"Host: http://HOST|Host: HOST evil|Host: \xc4HOST|Host:\x0bHOST").split(b"|")
HEADERS = (b"Accept: */*|X-A: \xe4\xff|Content-Length: 0|Connection: keep-alive|If-Range: 1|Expect: 100-continue|X:|"
           b"Origin: null|Upgrade: h2c|X: folded\r\n line").split(b"|") + [b"Cookie: " + b"a" * 3000]
WRONG_HEADERS = (
    b"Content-Length: 5|Content-Length: -1|Content-Length: 5\r\nContent-Length: 6|Content-Length: 99999999999999999999|"
    b"Content-Length: 3, 4|Content-Length: 0x5|Transfer-Encoding: gzip|Transfer-Encoding: chunked, x|no colon|: x|"
    b"Transfer-Encoding:\x0bchunked|Transfer-Encoding: chunked\r\nContent-Length: 3|Transfer-Encoding: chunked|X: \0|"
    b"Connection: close, keep-alive|Connection: ,;,\x7f|X: a\rY: b||Connection: close|X: a\nY: b").split(b"|")
WRONG_HEADERS += [b"X" * 20000 + b": 1", b"X: " + b"x" * 20000, b"A: 1\r\n" * 3000 + b"B: 2"]
BODIES = [b"", b"GET /\r\n\r\n", b"5\r\nGET /\r\n0\r\n\r\n", b"-1\r\n\r\n"]


class Requests:
    """Requests to the server at this port with this token, good ones and others."""

    def __init__(self, rng, port, path):
        self.rng, self.port, self.path, self.page, self.sent = rng, port, path, None, None
        self.hosts = [b"127.0.0.1:%d" % port, b"localhost:%d" % port]

    def body_of(self, below):
        with connect(self.port) as link:
            link.sendall(b"GET %b%b HTTP/1.1\r\nHost: %b\r\n\r\n" % (self.path, below, self.hosts[0]))
            link.shutdown(socket.SHUT_WR)
            return link.makefile("rb").read().partition(b"\r\n\r\n")[2]

    def one_of(self, *choices):
        return self.rng.choice(choices)

    def part(self, right, wrong):
        text = right if self.rng.random() < 0.7 else self.rng.choice(wrong)
        return text.replace(b"PATH", self.path).replace(b"HOST", self.rng.choice(self.hosts))

    def range(self):
        first, last = sorted((self.rng.randrange(SIZE + 9), self.rng.randrange(SIZE + 9)))
        if self.rng.random() < 0.6:
            return self.one_of(b"bytes=%d-%d" % (first, last), b"bytes=%d-" % first, b"bytes=-%d" % first)
        part = self.one_of(b"%b-%b", b"%b-%.0b", b"%.0b-%b") % (self.rng.choice(NUMBERS), self.rng.choice(NUMBERS))
        return self.one_of(b"bytes=", b"bytes=", b"bytes= ", b"bytes=-", b"bytes=0-1,", b"lines=", b"") + part

    def good(self):
        """A request that the server must answer by 200, 206 or 416."""
        line = self.one_of(b"GET", b"GET", b"GET", b"HEAD") + b" " + self.path
        line += self.one_of(b"", b"size", b"capture", b"capture", b"capture", b"capture") + b" HTTP/1.1\r\n"
        headers = [self.one_of(b"Host:", b"host: ", b"HOST:\t ", b"Host:\r\n ") + self.rng.choice(self.hosts)]
        if self.rng.random() < 0.7:
            headers.append(b"Range: " + self.range())
        headers += self.rng.choices(HEADERS, k=self.rng.randrange(4))
        self.rng.shuffle(headers)
        return line + b"\r\n".join(headers) + b"\r\n\r\n"

    def made(self):
        """Each part is right or a wrong one."""
        first = self.part(b"GET", METHODS), self.part(b"PATHcapture", TARGETS), self.part(b"HTTP/1.1", VERSIONS)
        lines = [self.part(b"Host: HOST", HOSTS)]
        for _ in range(self.rng.randrange(3)):
            line = self.part(b"Range: " + self.range(), WRONG_HEADERS)
            lines.insert(self.rng.randrange(len(lines) + 1), line)
        end = self.part(b"\r\n", (b"\n", b"\r", b"\r\n\r\n", b"\r\n \r\n", b""))
        return b" ".join(first) + b"\r\n" + end.join(lines) + end + b"\r\n" + self.rng.choice(BODIES)

    def damaged(self):
        text = bytearray(self.one_of(self.good, self.good, self.made)())
        for _ in range(self.rng.choice((1, 1, 1, 2, 4, 8))):
            at = self.rng.randrange(len(text))
            end = at + self.rng.choice((0, 0, 1, 2, 9))
            text[at:end] = self.one_of(b"", bytes([text[at] ^ 1 << self.rng.randrange(8)]), self.rng.choice(WORDS),
                                       self.rng.randbytes(self.rng.randrange(9)),
                                       text[self.rng.randrange(len(text)):][:40]) or b"\n"
        return bytes(text)

    def hostile(self):
        noise = self.rng.randbytes(self.rng.randrange(1, 30000)) if self.rng.random() < 0.02 else b""
        return noise or self.one_of(self.damaged, self.made)()

    def answer_to(self, block):
        """(status, body, Content-Range) for the header of a request; None if it may not get anything."""
        lines = re.sub(rb"\r\n[ \t]+", b" ", block).split(b"\r\n")
        first = re.fullmatch(rb"(GET|HEAD) (\S+) HTTP/1\.[01]", lines[0])
        headers = [line.partition(b":")[::2] for line in lines[1:]]
        values = lambda name: [value.strip(b" \t") for key, value in headers if key.lower() == name]
        bodies = {self.path + b"size": b"%d" % SIZE, self.path: self.page, self.path + b"capture": CAPTURE}
        if not first or first[2] not in bodies or values(b"host") not in ([self.hosts[0]], [self.hosts[1]]):
            return None
        ranges = values(b"range") if first[2].endswith(b"capture") and first[1] == b"GET" else []
        asked = re.fullmatch(rb"bytes=(\d*)-(\d*)", ranges[0]) if len(ranges) == 1 and not values(b"if-range") else None
        if not asked or not any(asked.groups()) or any(int(number or 0) >= 2**64 for number in asked.groups()):
            return 200, bodies[first[2]], None
        begin = int(asked[1]) if asked[1] else max(0, SIZE - int(asked[2]))
        last = int(asked[2]) if asked[1] and asked[2] else SIZE - 1
        if asked[1] and asked[2] and begin > last:
            return 200, CAPTURE, None
        if begin >= SIZE:
            return 416, b"The capture ends before.\n", b"bytes */%d" % SIZE
        return 206, CAPTURE[begin:last + 1], b"bytes %d-%d/%d" % (begin, min(last, SIZE - 1), SIZE)


def connect(port):
    link = socket.create_connection(("127.0.0.1", port), 20)
    link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    # No port remains in use after close().
    link.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    return link


def judge(requests, sent, good, received):
    """Checks the answers to the bytes sent, of which the first `good` requests are good. Returns their number."""
    blocks = sent.split(b"\r\n\r\n")
    count, at, closes = 0, 0, False
    while at < len(received):
        assert not closes, "bytes after the last answer"
        head = HEAD_OF_ANSWER.match(received, at)
        assert head, f"no answer of HTTP: {received[at:at + 200]}"
        headers = dict(line.split(b": ", 1) for line in head[2].split(b"\r\n")[:-1])
        status, length, block = int(head[1]), int(headers[b"Content-Length"]), blocks[count]
        closes = headers.get(b"Connection") == b"close"
        # The method in a damaged first line is unknown.
        no_body = block.startswith(b"HEAD ") and (status != 400 or head.end() == len(received))
        body = received[head.end():head.end() + length * (not no_body)]
        assert no_body or len(body) == length, "an answer that ends early"
        at, count = head.end() + len(body), count + 1
        right = requests.answer_to(block)
        if right and status not in (400, 403):
            assert (status, headers.get(b"Content-Range")) == (right[0], right[2]), f"{status}, not {right}"
            assert length == len(right[1]) and no_body or body == right[1], "wrong bytes"
        else:
            assert count > good and body in REFUSALS[status], f"{status} to {block[:200]}"
            assert closes and (not right or status == 400), f"{status} to {block[:200]}"
    whole = [re.match(rb"\S+ \S+ .{8}", block, re.DOTALL) for block in blocks[:-1]]
    assert closes or all(whole[:count]) and not any(whole[count:count + 1]), f"{count} answers to {len(whole)} requests"
    return count


def batch(requests):
    """Requests on several connections at a time. Returns the number of answers."""
    answers, rng = 0, requests.rng
    while answers < BATCH:
        links = []
        for _ in range(rng.randrange(1, CONNECTIONS + 1)):
            good = rng.choice((0, 0, 1, 2, 5, 15))
            text = b"".join([requests.good() for _ in range(good)] + [requests.hostile(), requests.hostile()])
            cuts = sorted(rng.randrange(len(text) + 1) for _ in range(rng.choice((0, 0, 1, 3, 10))))
            pieces = [text[a:b] for a, b in zip([0] + cuts, cuts + [len(text)])]
            links.append((connect(requests.port), text, good, pieces))
        for step in range(max(len(pieces) for _, _, _, pieces in links)):
            for link, _, _, pieces in links:
                link.sendall(b"".join(pieces[step:step + 1]))
        for link, text, good, _ in links:
            with link:
                if rng.random() < 0.02:  # reset, while the server answers
                    continue
                link.shutdown(socket.SHUT_WR)
                requests.sent = text
                answers += judge(requests, text, good, link.makefile("rb").read())
    return answers


def state(process):
    """Memory in KiB, number of open files."""
    with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
        memory = int(re.search(r"VmRSS:\s+(\d+)", status.read())[1])
    return memory, len(os.listdir(f"/proc/{process.pid}/fd"))


def fuzz(process, requests, count):
    files_idle, memory_max, answers = state(process)[1], None, 0
    requests.page = requests.body_of(b"")
    assert b"CORE" in requests.page
    while answers < count:
        for _ in range(5):  # the first batches fill the caches of the allocator
            answers += batch(requests)
            assert requests.body_of(b"capture") == CAPTURE, "a good request has another answer"
            closes_at = time.monotonic() + 5
            while state(process)[1] != files_idle and time.monotonic() < closes_at:
                time.sleep(0.01)
            memory, files = state(process)
            assert files == files_idle, f"{files} open files, {files_idle} at the start"
            assert memory <= (memory_max or memory), f"{memory} KiB, {memory_max} allowed"
        memory_max = memory_max or memory + 4096
    return answers, memory


def main():
    command, count, seed = sys.argv[1], *map(int, (sys.argv[2:] + ["20000", "1"][len(sys.argv) - 2:]))
    with tempfile.TemporaryDirectory() as folder:
        for name, content in (("a.csv", CAPTURE), ("secret", b"secret"), ("page.html", PAGE)):
            with open(f"{folder}/{name}", "wb") as file:
                file.write(content)
        os.environ["ASAN_OPTIONS"] = "quarantine_size_mb=1"  # its memory would grow
        words = [command, "view", f"{folder}/a.csv", "--no-open", "--page", f"{folder}/page.html"]
        with subprocess.Popen(words, stdout=subprocess.PIPE) as process:
            address = re.fullmatch(rb"http://127\.0\.0\.1:(\d+)(/[0-9a-f]{32}/)\n", process.stdout.readline())
            began = time.monotonic()
            requests = Requests(random.Random(seed), int(address[1]), address[2])
            try:
                answers, memory = fuzz(process, requests, count)
                process.terminate()
                assert process.wait(20) == 0, f"status {process.returncode}"
            except (AssertionError, OSError) as fault:
                print(f"seed {seed}: {fault}; status of the server: {process.poll()}; sent: {requests.sent}")
                process.kill()
                return 1
    rate = answers / (time.monotonic() - began)
    print(f"seed {seed}: {answers} requests answered, {rate:.0f} a second; {memory} KiB at the end")
    return 0


if __name__ == "__main__":
    sys.exit(main())
