"""Frames, SPI buffers and checksums against the command and against each other."""

import copy
import ctypes
import pickle
import random

import numpy as np
import pytest

import biss


def test_PublishedFrame_HasItsChecksum():
    format = biss.Format("pos26,nE,nW,crc6")
    for position in (0, 1, 0x1234567, (1 << 26) - 1):
        data = position << 2 | 3
        assert biss.crc(data, 28) == format.crc(data)
        [frame] = biss.records("crc", str(position), format="pos26,nE,nW,crc6")
        assert frame["crc"] == biss.crc(data, 28)
        # From START on, without STOP.
        assert frame["bits"] == str(format.encode(position))[3:-1]
    # A frame of the testbench of Hello-FPGA's BISS-C IP.
    assert biss.crc(0xE5DF5C3E << 2 | 3, 34) == 0x3A


def test_EncodedFrame_IsDecodedAgain():
    random.seed(3)
    for text in ("pos26,nE,nW,crc6", "mt12,st18,E,W,crc16", "fs-36-28", "resolute-32"):
        format = biss.Format(text)
        for _ in range(100):
            channels = [biss.Channel(random.getrandbits(about["position_bits"]),
                                     random.getrandbits(about["life_counter_bits"] or 1)
                                     if about["life_counter_bits"] else 0,
                                     random.random() < 0.5 or not about["error"],
                                     random.random() < 0.5 or not about["warning"])
                        for about in format.channels]
            bits = format.encode(*channels, ack_clocks=random.randint(1, 30))
            frame = format.decode(bits)
            assert frame.channels == tuple(channels)
            assert frame.trusted == all(each.nE for each in channels)
            wrong = bytearray(bits.data)
            place = bits.count - 2 - random.randrange(6)
            wrong[place // 8] ^= 0x80 >> place % 8
            with pytest.raises(biss.FrameError) as error:
                format.decode(bytes(wrong), bits=bits.count)
            assert error.value.cause == "crc"


def test_FrameWithoutErrorFlagOrChecksum_SaysSoAndIsNotTrusted():
    for text, no_error_flag, unchecked in (
            ("pos24,nE,nW,crc6", False, False), ("pos24,crc6", True, False),
            ("pos24,nE,nW", False, True), ("pos24", True, True), ("pos24,nE,crc6+pad8", False, True)):
        format = biss.Format(text)
        frame = format.decode(format.encode(*[1234] + [0] * (len(format.channels) - 1)))
        assert (frame.no_error_flag, frame.unchecked) == (no_error_flag, unchecked), text
        assert frame.trusted == (not no_error_flag and not unchecked), text
    reader = biss.SpiReader("pos24", 5_000_000, no_error_flag=True, unchecked=True)
    bits = reader.format.encode(1234, lead_clocks=2)
    assert reader.read(bits.data + bytes(reader.transfer_bytes)).trusted


def test_SpiBuffers_AreReadOneByOneAndAllAtOnce():
    format = biss.Format("resolute-26")
    reader = biss.SpiReader(format, 5_000_000, line_delay_max_ps=1_000_000)
    buffers = np.zeros((200, reader.transfer_bytes), np.uint8)
    positions = [i * 331_777 % (1 << 26) for i in range(200)]
    for i, position in enumerate(positions):
        bits = format.encode(position, ack_clocks=5 + i % 7)
        buffers[i, :len(bits.data)] = np.frombuffer(bits.data, np.uint8)
    buffers[17, 3] ^= 0x10
    buffers[18] = 0xFF
    buffers[19] = 0
    columns = reader.read_all(buffers)
    for i, position in enumerate(positions):
        try:
            frame = reader.read(buffers[i])
        except biss.FrameError as error:
            assert columns["status"][i] == error.cause and columns["position"].mask[i]
            continue
        assert columns["status"][i] == "ok"
        assert columns["position"][i] == frame.position == position
    assert list(columns["status"][18:20]) == ["no_response", "not_ready"]
    assert columns["status"][17] != "ok"
    assert np.array_equal(reader.read_all(buffers[::2])["status"], columns["status"][::2])


def test_BuffersOfEveryKind_AreRead():
    format = biss.Format("pos26,nE,nW,crc6")
    reader = biss.SpiReader(format, 5_000_000, line_delay_max_ps=1_000_000)
    sent = format.encode(1234, ack_clocks=8)
    data = sent.data.ljust(reader.transfer_bytes, b"\0")
    array = np.frombuffer(data, np.uint8)
    kinds = [data, bytearray(data), memoryview(data), array, array.astype(np.int8), list(data),
             tuple(data), [np.int64(each) for each in data],
             (ctypes.c_uint8 * len(data)).from_buffer_copy(data)]
    for buffer in kinds:
        assert reader.read(buffer).position == 1234
        assert format.decode(buffer).position == 1234
    for read in (reader.read, format.decode):
        for wrong in (array.astype(np.int64), array.astype(np.uint16), array != 0, "text", 5, None,
                      [1.5], ["a"]):
            with pytest.raises(TypeError, match="bytes are needed"):
                read(wrong)
        for wrong in ([256], [-1]):
            with pytest.raises(biss.UsageError, match="from 0 to 255"):
                read(wrong)


def test_FormatsAndErrors_ArePickled():
    format = biss.Format("resolute-26", ack_max="12us", ack_clocks=None)
    for copied in (pickle.loads(pickle.dumps(format)), copy.deepcopy(format)):
        assert copied.text == format.text
        assert str(copied.encode(5)) == str(format.encode(5))
        assert biss.SpiReader(copied, 10**7).clocks == biss.SpiReader(format, 10**7).clocks
    error = biss.FrameError("crc of channel 2", "crc", 1)
    copied = pickle.loads(pickle.dumps(error))
    assert (str(copied), copied.cause, copied.channel) == ("crc of channel 2", "crc", 1)
    assert copied.messages == error.messages
    error = biss.UsageError("last", ["first", "last"])
    assert pickle.loads(pickle.dumps(error)).messages == ["first", "last"]


def test_WrongValues_AreNamed():
    with pytest.raises(biss.UsageError, match="pos99"):
        biss.Format("pos99")
    format = biss.Format("pos26,nE,nW,crc6")
    for wrong in (1 << 26, -1, 1 << 64):
        with pytest.raises(biss.UsageError):
            format.encode(wrong)
    for wrong in ({"ack_clocks": 0}, {"ack_clocks": 401}, {"lead_clocks": 500}):
        with pytest.raises(biss.UsageError):
            format.encode(1, **wrong)
    with pytest.raises(biss.UsageError):
        format.encode(1, 2)
    with pytest.raises(biss.UsageError):
        format.encode(*range(9))
    with pytest.raises(biss.UsageError):
        format.decode(b"\x00" * 10, bits=81)
    with pytest.raises(biss.UsageError):
        format.decode(b"\x00" * 70_000)
    with pytest.raises(biss.FrameError):
        format.decode(b"")
    for wrong in ({"first_bit": 1000}, {"first_bit": -1}, {"bits": -1}):
        with pytest.raises(biss.UsageError):
            format.decode(format.encode(1), **wrong)
    for data, channel in ((1 << 40, 0), (1, 3), (1, -1)):
        with pytest.raises(biss.UsageError):
            format.crc(data, channel)
    with pytest.raises(TypeError, match="position: a whole number is needed"):
        format.encode(1.5)
    for data, bits, options in ((1 << 10, 4, {}), (1, 4, {"width": 2}), (1, 65, {}), (4, 2, {}), (1, 0, {}), (1, 8, {"width": 17}),
                                (1, 8, {"width": 6, "polynomial": 3}), (1, 8, {"start": 64})):
        with pytest.raises(biss.UsageError):
            biss.crc(data, bits, **options)
    for options in ({"clock_hz": 0}, {"clock_hz": 10, "line_delay_min_ps": 5, "line_delay_max_ps": 4},
                    {"clock_hz": 10**6, "phase": "mode 3"}, {"clock_hz": 10**6, "first_bit": 1 << 16}):
        with pytest.raises(biss.UsageError):
            biss.SpiReader(format, **options)
    reader = biss.SpiReader(format, 10**6)
    for read in (reader.read, reader.read_all):
        with pytest.raises(biss.UsageError, match="clocks: -1"):
            read(np.zeros((1, 20), np.uint8), clocks=-1)
    for array in (np.zeros(5, np.uint8), np.zeros((5, 5), np.int8), np.zeros((5, 6), np.uint8).T):
        with pytest.raises((ValueError, TypeError)):
            reader.read_all(array)
    assert reader.read_all(np.zeros((0, 5), np.uint8))["status"].size == 0
    with pytest.raises(biss.FrameError):
        reader.read(b"")


def test_SpiReaderOfAFormatWithoutNeOrCrc_NeedsTheWord():
    for text, words, message in (("pos24,crc6", {"unchecked": True}, "no nE"),
                                 ("pos24,nE,nW", {"no_error_flag": True}, "no CRC")):
        with pytest.raises(biss.UsageError, match=message):
            biss.SpiReader(text, 10**6, **words)
    assert biss.SpiReader("pos24", 10**6, no_error_flag=True, unchecked=True).clocks > 24
    with pytest.raises(biss.UsageError, match="above the limit of the encoder"):
        biss.SpiReader("resolute-26", 40_000_000)
    assert biss.SpiReader(biss.Format("pos24,nE,nW,crc6", clock_max="20MHz"), 20_000_000).clocks > 24


def test_RandomBuffers_AreFramesOrACause():
    random.seed(4)
    format = biss.Format("pos12,nE,nW,crc6")
    reader = biss.SpiReader(format, 10_000_000)
    for _ in range(2000):
        data = random.randbytes(random.randrange(40))
        for read in (format.decode, reader.read):
            try:
                assert len(read(data).channels) == 1
            except biss.FrameError as error:
                assert error.cause
