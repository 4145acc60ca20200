// One fault in a sequence of bytes or in a command: the reported error, and the errors that a retry
// repairs.
#include "tests/core/control_link.hpp"
#include "tests/core/test.hpp"

namespace biss::test::control_sequence_test {

using Bytes = std::array<std::uint8_t, 2>;

constexpr std::array<Bytes, 3> values{{{0xA5, 0x3C}, {0x00, 0xFF}, {0xFF, 0x00}}};
constexpr unsigned damages = 4;

Damage damage_of(unsigned kind, std::uint32_t frame) {
  if (kind == 0) return {.flip_cdm = frame};
  if (kind == 1) return {.flip_cds = frame};
  return {.cut = frame, .cut_frames = 1, .deaf = kind == 2};
}

// Two bytes of the middle one of three slaves.
struct Sequence {
  ControlLink<3> link;
  Bytes bytes{};
  bool good = false;
  bool right = false;

  explicit Sequence(const ControlOptions& options) : link({}, options) {}

  void run(bool write, const Bytes& truth, const Damage& damage) {
    auto& registers = link.registers[1];
    for (unsigned i = 0; i < 2; ++i) {
      registers.value[0x42 + i] = static_cast<std::uint8_t>(write ? ~truth[i] : truth[i]);
    }
    bytes = write ? truth : Bytes{};
    link.damage(damage);
    good = write ? link.write(1, 0x42, bytes) : link.read(1, 0x42, bytes);
    BISS_ASSERT(link.session.done());
    const bool kept = registers.value[0x42] == truth[0] && registers.value[0x43] == truth[1];
    right = bytes == truth && kept;
  }

  bool delayed() const { return link.session.outcome().longest_busy != Picoseconds{}; }
};

void expect_told(bool write, const Bytes& truth, unsigned kind, std::uint32_t frame,
                 std::uint8_t retries) {
  Sequence sequence({.retries = retries});
  sequence.run(write, truth, damage_of(kind, frame));
  // A lost S of a byte that is written after another one shows only as a delay, see below.
  const bool late = write && sequence.delayed();
  BISS_EXPECT(!sequence.good || sequence.right || late) << "kind " << kind << " frame " << frame;
  BISS_EXPECT_EQ(sequence.link.registers[0].writes + sequence.link.registers[2].writes, 0);
  // A refusal by the slave may also be an effect of the fault, but is not retried.
  const ControlError error = sequence.link.error();
  const bool no = error == ControlError::refused || error == ControlError::next_unavailable;
  BISS_EXPECT(sequence.good || no || retries == 0) << "kind " << kind << " frame " << frame;
  // A slave that read a don't-care bit as 1 counts fewer zeros than the master has sent.
  sequence.link.damage({});
  const bool next = sequence.link.read(1, 0x42, sequence.bytes);
  BISS_EXPECT(next || sequence.link.read(1, 0x42, sequence.bytes)) << "frame " << frame;
}

BISS_TEST(ControlSequence, OneDamagedFrameAnywhere_IsToldAndRepairedByARetry) {
  for (const Bytes& truth : values) {
    for (unsigned kind = 0; kind < damages; ++kind) {
      for (std::uint32_t frame = 0; frame < register_access_frames(2); ++frame) {
        for (const std::uint8_t retries : {std::uint8_t{0}, std::uint8_t{1}}) {
          expect_told(false, truth, kind, frame, retries);
          expect_told(true, truth, kind, frame, retries);
        }
      }
    }
  }
}

BISS_TEST(ControlSequence, LostSOfALaterByte_ShowsAsADelayIfAnyIsAllowed) {
  unsigned wrong = 0;
  for (unsigned value = 0; value < 256; ++value) {
    const auto data = static_cast<std::uint8_t>(value);
    const std::uint32_t late_start =
        control_reset_zeros + control_bit::byte_start + control_byte_bits + 1;
    for (const bool write : {false, true}) {
      Sequence sequence({});
      sequence.run(write, {data, data}, {.flip_cds = late_start});
      BISS_EXPECT(!sequence.good || (write && sequence.delayed())) << value;
      if (sequence.good && !sequence.right) ++wrong;
      Sequence strict({.busy_max = {}});
      strict.run(write, {data, data}, {.flip_cds = late_start});
      BISS_EXPECT_EQ(strict.link.error(), ControlError::busy_too_long) << value;
      BISS_EXPECT_EQ(strict.link.session.outcome().bytes_done, 1);
    }
  }
  BISS_EXPECT_EQ(wrong, 128);
}

BISS_TEST(ControlSequence, OneDamagedFrameOfACommand_NeverMakesItRunTwiceOrElsewhere) {
  for (unsigned kind = 0; kind < damages; ++kind) {
    for (std::uint32_t frame = 0; frame < addressed_command_frames; ++frame) {
      ControlLink<3> link({}, {.retries = 1});
      link.damage(damage_of(kind, frame));
      link.session.command(0b010, ControlCommand::user);
      BISS_EXPECT(link.run() && !link.session.outcome().error) << "kind " << kind;
      const auto executed = [&](unsigned slave) {
        return link.registers[slave].addressed[static_cast<std::size_t>(ControlCommand::user)];
      };
      // No error is reported when the slave does not understand the bits after its IDA.
      const bool untold = kind == 0 && frame >= control_reset_zeros + control_bit::ida + 2;
      BISS_EXPECT_EQ(executed(1), untold ? 0 : 1) << "kind " << kind << " frame " << frame;
      BISS_EXPECT_EQ(executed(0) + executed(2), 0);
    }
  }
}

}  // namespace biss::test::control_sequence_test
