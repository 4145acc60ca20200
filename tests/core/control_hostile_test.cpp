// Flipped bits, exhaustively, and encoders with random answers.
#include "biss/control/control_frame.hpp"
#include "biss/control/session.hpp"
#include "tests/core/control_script.hpp"
#include "tests/core/test.hpp"

namespace biss {

using test::CdsScript;
using test::Frames;

namespace control_hostile_test {

// Calls `flip` with every mask of `weight` bits among the lowest `bits`.
template <class Flip>
void each_mask(unsigned bits, unsigned weight, Flip flip) {
  for (std::uint32_t mask = 1; mask < 1U << bits; ++mask) {
    if (static_cast<unsigned>(std::popcount(mask)) == weight) flip(mask);
  }
}

BISS_TEST(ControlHostile, FlippedBitsOfAHeader_PassAsOftenAsCalculated) {
  constexpr std::array<unsigned, 5> passing{1, 0, 0, 35, 105};
  for (const unsigned covered : {0x000U, 0x442U, 0x47EU, 0x7FFU, 0x203U}) {
    const std::uint32_t word = covered << 4U | header_crc(static_cast<std::uint16_t>(covered));
    for (unsigned weight = 1; weight <= 4; ++weight) {
      unsigned passed = 0;
      each_mask(15, weight, [&](std::uint32_t mask) {
        if (parse_header(word ^ mask)) ++passed;
      });
      BISS_EXPECT_EQ(passed, passing[weight]) << "weight " << weight;
    }
  }
}

BISS_TEST(ControlHostile, FlippedBitsOfAByte_PassAsOftenAsCalculated) {
  constexpr std::array<unsigned, 5> passing{1, 0, 0, 17, 38};
  for (const std::uint32_t data : {0x00U, 0x62U, 0xFFU}) {
    for (unsigned weight = 1; weight <= 4; ++weight) {
      unsigned read = 0;
      unsigned written = 0;
      each_mask(12, weight, [&](std::uint32_t mask) {
        const std::uint32_t word = (data << 4U | test::plain_crc4(data, 8)) ^ mask;
        for (const bool write : {false, true}) {
          CdsScript cds;
          cds.add(write ? test::write_accepted : test::read_accepted);
          cds.number(word, 12);
          cds.add('0');
          std::array<std::uint8_t, 1> byte{static_cast<std::uint8_t>(data)};
          ControlSession session;
          Frames frames(session);
          write ? session.write(0, 0, byte) : session.read(0, 0, byte);
          frames.run(cds.view());
          if (session.outcome().error) continue;
          write ? ++written : ++read;
          BISS_EXPECT(write || byte[0] == word >> 4U);
        }
      });
      BISS_EXPECT_EQ(read, passing[weight]) << "weight " << weight;
      BISS_EXPECT_EQ(written, 0) << "weight " << weight;
    }
  }
}

constexpr std::uint32_t most_busy_frames = 82;  // 20 ms at 250 us, the first and the last one

// One try: lost frames and zeros before the start bit, the header, and each byte with the longest
// delay.
std::uint32_t most_frames(unsigned bytes, unsigned tries) {
  return tries * (13 + 14 + 19 + bytes * (14 + most_busy_frames) + 1);
}

// An encoder with random answers. Shares in thousandths: how often CDS is 1, how often it is
// missing, how often it is right, and from which bit of the control frame on it stays 0.
struct Character {
  std::uint32_t ones;
  std::uint32_t missing;
  std::uint32_t good;
  std::uint32_t dies;
};

CdsBit hostile_cds(test::Random& random, const Character& character, std::size_t at, char good) {
  if (at > character.dies) return CdsBit::zero;
  if (random.below(1000) < character.missing) return CdsBit::missing;
  if (random.below(1000) < character.good) return good == '1' ? CdsBit::one : CdsBit::zero;
  return random.below(1000) < character.ones ? CdsBit::one : CdsBit::zero;
}

BISS_TEST(ControlHostile, WhateverCdsDoes_EachAccessEndsAndTheNextOneWorks) {
  BISS_RANDOM(random, 0xB155'0057);
  std::array<std::uint32_t, control_error_count + 1> seen{};
  const std::uint64_t rounds = test::rounds(60'000, 3'000);
  for (std::uint64_t round = 0; round < rounds; ++round) {
    const Character character{random.below(1001), random.flip() ? 0 : random.below(30),
                              random.flip() ? random.below(1001) : 990 + random.below(11),
                              random.flip() ? 2000 : random.below(60)};
    const auto retries = static_cast<std::uint8_t>(random.below(3));
    ControlSession session({.retries = retries});
    Frames frames(session);
    std::array<std::uint8_t, 64> bytes{};
    const unsigned size = 1 + random.below(random.flip() ? 64 : 3);
    const unsigned kind = random.below(3);
    CdsScript good;
    good.add(kind == 0   ? test::read_accepted
             : kind == 1 ? test::write_accepted
                         : "1000000000000000 10000000");
    for (unsigned i = 0; i < size && kind < 2; ++i) {
      if (i != 0) good.add('1');
      test::add_byte(good, 0);
      good.add('0');
    }
    const auto span = std::span(bytes).first(size);
    if (kind == 0) session.read(0, 0x10, span);
    if (kind == 1) session.write(0, 0x10, span);
    if (kind == 2) session.command(1, ControlCommand::user);
    const std::uint32_t most = most_frames(size, 1U + retries);
    std::uint32_t count = 0;
    unsigned last_tries = 1;
    frames.answer("");
    while (!session.done() && count <= most) {
      const std::size_t at = frames.cdm().size();
      const char next = at != 0 && at <= good.size ? good.text[at - 1] : '0';
      frames.step(hostile_cds(random, character, at, next));
      ++count;
      if (session.outcome().tries != last_tries) {
        last_tries = session.outcome().tries;
        frames.answer("");
      }
    }
    BISS_ASSERT(session.done()) << "round " << round;
    BISS_EXPECT_EQ(session.outcome().frames, count);
    BISS_EXPECT(session.outcome().tries <= 1U + retries);
    BISS_EXPECT(session.outcome().bytes_done <= size);
    BISS_EXPECT(session.outcome().longest_busy <= milliseconds(20) + frames.cycle);
    for (unsigned i = kind == 0 ? session.outcome().bytes_done : 0; i < bytes.size(); ++i) {
      BISS_EXPECT_EQ(bytes[i], 0);
    }
    const auto error = session.outcome().error;
    ++seen[error ? static_cast<std::size_t>(*error) : control_error_count];

    session.read(0, 0x42, std::span(bytes).first(1));
    BISS_EXPECT(frames.run("1000000000000000 101 01100010 0100 0") <= 47);
    BISS_EXPECT(!session.outcome().error && bytes[0] == 0x62) << "round " << round;
    BISS_EXPECT(frames.zeros_before >= 14);
  }
  if (rounds < 60'000) return;
  // Every error occurs, except those that depend on the request alone.
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto error = static_cast<ControlError>(i);
    const bool asked = error != ControlError::bad_request && error != ControlError::cancelled &&
                       error != ControlError::no_such_slave;
    BISS_EXPECT_EQ(seen[i] != 0, asked) << "error " << i;
  }
}

}  // namespace control_hostile_test
}  // namespace biss
