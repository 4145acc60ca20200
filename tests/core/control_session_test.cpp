// Every published control frame, bit by bit, and the duration of accesses.
#include "biss/control/session.hpp"

#include "biss/control/control_frame.hpp"
#include "tests/core/control_script.hpp"
#include "tests/core/test.hpp"

namespace biss::control_session_test {

using test::CdsScript;
using test::Frames;

using Bytes = std::array<std::uint8_t, 64>;

// A session in a constant expression: read 0x62 from 0x42.
constexpr std::uint32_t compiled = [] {
  ControlSession session;
  std::array<std::uint8_t, 1> byte{};
  session.read(0, 0x42, byte);
  Frames frames(session);
  const std::uint32_t count = frames.run("10000000000000001010110001001000");
  return count * 256U + byte[0];
}();
static_assert(compiled == 47 * 256 + 0x62);

struct Vector {
  bool write;
  unsigned slave;
  unsigned address;
  std::uint8_t data;
  std::string_view cdm;
  std::string_view cds;
};

// Computed from the protocol's rules; the write of 0x55 to 0x02 and the headers of 0x00 and 0x20
// are in captures of AN22 too.
constexpr std::array<Vector, 6> vectors{{
    {false, 0, 0x42, 0x62, "11000100001001111010000000000000", "10000000000000001010110001001000"},
    {false, 0, 0x43, 0x1E, "11000100001101001010000000000000", "10000000000000001010001111010110"},
    {false, 0, 0x7E, 0x69, "11000111111011111010000000000000", "10000000000000001010110100110100"},
    {false, 1, 0x41, 0x02, "11001100000111001010000000000000", "11000000000000001010000001010010"},
    {true, 0, 0x40, 0x02, "11000100000000010110000001010010", "10000000000000000110000001010010"},
    {true, 0, 0x02, 0x55, "11000000001000000110101010100100", "10000000000000000110101010100100"},
}};

// Texas Instruments, motor-control-sdk: CDM without the start bit, registers read.
constexpr std::array<std::uint32_t, 13> ti_reads{
    0x889B4000, 0x88BD4000, 0x88D74000, 0x88F14000, 0x8C174000, 0x8CE54000, 0x8D014000,
    0x8F0B4000, 0x8F2D4000, 0x8F474000, 0x8F614000, 0x8F934000, 0x8FB54000};
constexpr std::array<std::uint8_t, 13> ti_addresses{0x44, 0x45, 0x46, 0x47, 0x60, 0x67, 0x68,
                                                    0x78, 0x79, 0x7A, 0x7B, 0x7C, 0x7D};

void expect_command(std::uint8_t slaves, ControlCommand command, std::string_view cdm,
                    std::string_view cds) {
  ControlSession session;
  if (slaves == 0) {
    session.broadcast(command);
  } else {
    session.command(slaves, command);
  }
  Frames frames(session);
  const std::uint32_t count = frames.run(cds);
  BISS_EXPECT_EQ(count, slaves == 0 ? 32U : 39U);
  BISS_EXPECT(frames.cdm() == cdm);
  BISS_EXPECT(session.done() && !session.outcome().error);
  BISS_EXPECT_EQ(session.outcome().frames, count);
  BISS_EXPECT_EQ(session.outcome().accepted, slaves);
}

BISS_TEST(ControlSession, SingleAccesses_SayAndHearTheVectors) {
  for (const Vector& vector : vectors) {
    ControlSession session;
    std::array<std::uint8_t, 1> byte{vector.write ? vector.data : std::uint8_t{0}};
    if (vector.write) {
      session.write(vector.slave, vector.address, byte);
    } else {
      session.read(vector.slave, vector.address, byte);
    }
    BISS_EXPECT(!session.done());
    Frames frames(session);
    const std::uint32_t count = frames.run(vector.cds);
    BISS_EXPECT_EQ(count, 47) << "address " << vector.address;
    BISS_EXPECT_EQ(frames.zeros_before, 14);
    BISS_EXPECT(frames.cdm().substr(0, 32) == vector.cdm) << "address " << vector.address;
    BISS_EXPECT(frames.cdm().substr(32) == "0");
    const ControlOutcome& outcome = session.outcome();
    BISS_EXPECT(!outcome.error && !outcome.retried);
    BISS_EXPECT_EQ(byte[0], vector.data);
    BISS_EXPECT_EQ(outcome.frames, 47);
    BISS_EXPECT_EQ(outcome.bytes_done, 1);
    BISS_EXPECT_EQ(outcome.slaves_present, vector.slave == 1 ? 3 : 1);
    BISS_EXPECT_EQ(outcome.tries, 1);
    BISS_EXPECT_EQ(outcome.longest_busy.count, 0);
  }
}

BISS_TEST(ControlSession, Commands_SayTheVectors) {
  expect_command(0, ControlCommand::channels, "100000000000111111", "");
  expect_command(0, ControlCommand::control, "100000000001110011", "");
  expect_command(1, ControlCommand::channels, "1010000000000010100000001",
                 "1000000000000000 10000000");
  expect_command(2, ControlCommand::control, "1001000000010011100000001",
                 "1100000000000000 01000000");
}

BISS_TEST(ControlSession, ReadsOfTi_AreSaidBitByBit) {
  for (std::size_t i = 0; i < ti_reads.size(); ++i) {
    ControlSession session;
    std::array<std::uint8_t, 1> byte{};
    session.read(0, ti_addresses[i], byte);
    Frames frames(session);
    frames.run("1000000000000000 101 00000000 1111 0");
    CdsScript word;
    word.number(ti_reads[i], 32);
    BISS_EXPECT(frames.cdm().substr(1) == word.view()) << "address " << ti_addresses[i];
    const auto header = parse_header(ti_reads[i] >> 17U);
    BISS_ASSERT(header.has_value());
    BISS_EXPECT(*header == (ControlHeader{.register_access = true, .address = ti_addresses[i]}));
  }
}

BISS_TEST(ControlSession, WriteOfTi_IsRefusedAsPrintedAndSaidAsCorrected) {
  BISS_EXPECT(!parse_header(0x8C13C194U >> 17U).has_value());
  BISS_EXPECT(parse_header(0x8C16C194U >> 17U).has_value());
  ControlSession session;
  const std::array<std::uint8_t, 1> byte{0x06};
  session.write(0, 0x60, byte);
  Frames frames(session);
  frames.run("1000000000000000 011 00000110 0101 0");
  CdsScript word;
  word.number(0x8C16C194U, 32);
  BISS_EXPECT(frames.cdm().substr(1) == word.view());
  BISS_EXPECT(!session.outcome().error);
}

BISS_TEST(ControlSession, SequentialAccesses_TakeFourteenFramesAByte) {
  BISS_RANDOM(random, 0x5E9);
  for (unsigned size = 1; size <= 64; ++size) {
    for (const bool write : {false, true}) {
      Bytes sent{};
      for (auto& byte : sent) byte = static_cast<std::uint8_t>(random.bits(8));
      const unsigned address = random.below(128 - size + 1);
      CdsScript cds;
      CdsScript cdm;
      cds.add(write ? test::write_accepted : test::read_accepted);
      cdm.add('1');
      cdm.number(register_header(0, address), 11);
      cdm.number(test::plain_crc4(register_header(0, address), 11), 4);
      cdm.add(write ? "011" : "101");
      for (unsigned i = 0; i < size; ++i) {
        if (i != 0) cds.add('1');
        test::add_byte(cds, sent[i]);
        cds.add(i + 1 == size && random.flip() ? '1' : '0');
        if (i != 0) cdm.add('1');
        write ? test::add_byte(cdm, sent[i]) : cdm.number(0, 12);
        cdm.add('0');
      }
      cdm.add('0');
      ControlSession session;
      Bytes got{};
      write ? session.write(0, address, std::span(std::as_const(sent)).first(size))
            : session.read(0, address, std::span(got).first(size));
      Frames frames(session);
      const std::uint32_t count = frames.run(cds.view());
      BISS_EXPECT_EQ(count, register_access_frames(size));
      BISS_EXPECT_EQ(count, 33 + 14 * size);
      BISS_EXPECT(frames.cdm() == cdm.view()) << size << " bytes";
      BISS_EXPECT(!session.outcome().error);
      BISS_EXPECT_EQ(session.outcome().bytes_done, size);
      for (unsigned i = 0; !write && i < size; ++i) BISS_EXPECT_EQ(got[i], sent[i]);
    }
  }
}

BISS_TEST(ControlSession, ReadBehindARead_NeedsNoFurtherZeros) {
  ControlSession session;
  std::array<std::uint8_t, 1> byte{};
  Frames frames(session);
  for (unsigned round = 0; round < 3; ++round) {
    session.read(0, 0x42, byte);
    BISS_EXPECT_EQ(frames.run(vectors[0].cds), round == 0 ? 47U : 33U);
    BISS_EXPECT(!session.outcome().error);
    BISS_EXPECT_EQ(frames.zeros_before, 14);
  }
  // The zeros that the master sends meanwhile count.
  for (unsigned i = 0; i < 20; ++i) BISS_EXPECT(!frames.step(CdsBit::zero));
  session.read(0, 0x42, byte);
  BISS_EXPECT_EQ(frames.run(vectors[0].cds), 33);
}

BISS_TEST(ControlSession, AccessBehindAWriteOrCommand_SendsTheZerosThatLack) {
  ControlSession session;
  std::array<std::uint8_t, 1> byte{0x02};
  Frames frames(session);
  session.write(0, 0x40, byte);
  frames.run(vectors[4].cds);
  // The CRC of 0x02 ends in 1001, P and the 33rd frame are 0.
  session.read(0, 0x42, byte);
  BISS_EXPECT_EQ(frames.run(vectors[0].cds), 47 - 2);
  session.broadcast(ControlCommand::channels);
  BISS_EXPECT_EQ(frames.run(""), 18);
  session.read(0, 0x42, byte);
  BISS_EXPECT_EQ(frames.run(vectors[0].cds), 47);
  BISS_EXPECT_EQ(frames.zeros_before, 14);
}

BISS_TEST(ControlSession, LostFrames_AreNoZeros) {
  ControlSession session;
  std::array<std::uint8_t, 1> byte{};
  Frames frames(session);
  for (unsigned i = 0; i < 30; ++i) frames.step(CdsBit::missing);
  session.read(0, 0x42, byte);
  for (unsigned i = 0; i < 13; ++i) {
    BISS_EXPECT(!frames.step(CdsBit::missing));
    BISS_EXPECT(!frames.step(CdsBit::zero));
  }
  BISS_EXPECT_EQ(frames.run(vectors[0].cds), 47 - 13);
  BISS_EXPECT(!session.outcome().error);
  BISS_EXPECT_EQ(frames.zeros_before, 14);
  BISS_EXPECT_EQ(session.outcome().frames, 47 + 13);
}

BISS_TEST(ControlSession, Broadcast_NeedsNoCds) {
  ControlSession session;
  session.broadcast(ControlCommand::control);
  Frames frames(session);
  frames.answer("");
  for (unsigned i = 0; i < 31; ++i) {
    frames.step(CdsBit::missing);
    BISS_EXPECT(!session.done());
  }
  frames.step(CdsBit::missing);
  BISS_EXPECT(session.done() && !session.outcome().error);
  BISS_EXPECT(frames.cdm() == "100000000001110011");
  // CDS does not matter either.
  session.broadcast(ControlCommand::channels);
  frames.answer("");
  for (unsigned i = 0; i < 32; ++i) frames.step(CdsBit::one);
  BISS_EXPECT(session.done() && !session.outcome().error);
  BISS_EXPECT(frames.cdm() == "100000000000111111");
}

BISS_TEST(ControlSession, ImpossibleRequests_EndAtOnceAndSendNothing) {
  Bytes bytes{};
  std::array<std::uint8_t, 65> many{};
  const auto span = std::span<std::uint8_t>(bytes);
  const auto refused = [](auto request) {
    ControlSession session;
    Frames frames(session);
    for (unsigned i = 0; i < 14; ++i) frames.step(CdsBit::zero);
    request(session);
    BISS_EXPECT(session.done() && session.outcome().error == ControlError::bad_request);
    BISS_EXPECT(!frames.step(CdsBit::zero));
    std::array<std::uint8_t, 1> byte{};
    session.read(0, 0x42, byte);
    BISS_EXPECT_EQ(frames.run(vectors[0].cds), 33);
  };
  refused([&](ControlSession& s) { s.read(0, 0, span.first(0)); });
  refused([&](ControlSession& s) { s.read(0, 0, many); });
  refused([&](ControlSession& s) { s.read(8, 0, span); });
  refused([&](ControlSession& s) { s.read(0, 65, span); });
  refused([&](ControlSession& s) { s.read(0, 128, span.first(1)); });
  refused([&](ControlSession& s) { s.read(0, 0xFFFFFFFFU, span.first(2)); });
  refused([&](ControlSession& s) { s.write(0, 64, std::span<const std::uint8_t>(many)); });
  refused([&](ControlSession& s) { s.command(0, ControlCommand::user); });
}

BISS_TEST(ControlHeader, EveryHeader_IsReadAsItWasMade) {
  for (unsigned covered = 0; covered < 0x800; ++covered) {
    const auto crc = test::plain_crc4(covered, 11);
    BISS_EXPECT_EQ(header_crc(static_cast<std::uint16_t>(covered)), crc);
    const auto header = parse_header(covered << 4U | crc);
    BISS_ASSERT(header.has_value());
    BISS_EXPECT_EQ(header->register_access ? register_header(header->slave, header->address)
                                           : command_header(header->slaves, header->command),
                   covered);
    unsigned wrong = 0;
    for (unsigned other = 0; other < 16; ++other) {
      if (!parse_header(covered << 4U | other)) ++wrong;
    }
    BISS_EXPECT_EQ(wrong, 15);
  }
  for (unsigned data = 0; data < 256; ++data) {
    BISS_EXPECT_EQ(byte_crc(static_cast<std::uint8_t>(data)), test::plain_crc4(data, 8));
  }
}

}  // namespace biss::control_session_test
