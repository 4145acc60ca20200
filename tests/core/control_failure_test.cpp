// Every cause, the effect of a retry, and the longest busy time of a slave.
#include "biss/control/session.hpp"
#include "tests/core/control_script.hpp"
#include "tests/core/test.hpp"

namespace biss::control_failure_test {

using test::CdsScript;
using test::Frames;

constexpr std::string_view good_read = "1000000000000000 101 01100010 0100 0";  // 0x42: 0x62
constexpr std::string_view good_echo = "1000000000000000 011 01100010 0100 0";

enum class Ask : std::uint8_t { read, write, command };

// Two bytes from 0x42, or a command to slave 0.
struct Access {
  ControlSession session;
  Frames frames{session};
  std::array<std::uint8_t, 2> bytes{0x62, 0x62};

  explicit Access(const ControlOptions& options = {}) : session(options) {}
  void ask(Ask what) {
    if (what == Ask::read) bytes = {};
    if (what == Ask::read) session.read(0, 0x42, bytes);
    if (what == Ask::write) session.write(0, 0x42, bytes);
    if (what == Ask::command) session.command(1, ControlCommand::user);
  }
  ControlError error() const {
    return session.outcome().error.value_or(static_cast<ControlError>(control_error_count));
  }
};

struct Case {
  Ask ask;
  std::string_view cds;
  ControlError error;
  /// CDM after the 16 bits of the header, up to the end of this text.
  std::string_view cdm;
  unsigned bytes_done;
};

constexpr std::array<Case, 27> cases{{
    {Ask::read, "", ControlError::no_answer, "0", 0},
    {Ask::write, "", ControlError::no_answer, "0", 0},
    {Ask::command, "", ControlError::no_answer, "0", 0},
    {Ask::read, "0100000000000000", ControlError::id_pattern, "0", 0},
    {Ask::read, "1010000000000000", ControlError::id_pattern, "0", 0},
    {Ask::read, "1111111110000001", ControlError::id_pattern, "0", 0},
    {Ask::read, "1111111111000000", ControlError::id_pattern, "0", 0},
    {Ask::read, "1111111111111111", ControlError::id_pattern, "0", 0},
    {Ask::write, "1000000000000001", ControlError::id_pattern, "0", 0},
    {Ask::command, "1000000000100000", ControlError::id_pattern, "0", 0},
    {Ask::read, "1000000000000000 11", ControlError::refused, "100", 0},
    {Ask::read, "1000000000000000 00", ControlError::not_addressed, "100", 0},
    {Ask::read, "1000000000000000 01", ControlError::rw_pattern, "100", 0},
    {Ask::write, "1000000000000000 00", ControlError::refused_or_not_addressed, "010", 0},
    {Ask::write, "1000000000000000 10", ControlError::rw_pattern, "010", 0},
    {Ask::write, "1000000000000000 11", ControlError::rw_pattern, "010", 0},
    {Ask::write, "1000000000000000 010", ControlError::start_missing, "0110", 0},
    {Ask::read, "1000000000000000 101 01100010 0101 0", ControlError::data_crc,
     "101 00000000 0000 0", 0},
    {Ask::read, "1000000000000000 101 01100010 0100 0 1 01100011 0100 0", ControlError::data_crc,
     "101 00000000 0000 0 1 00000000 0000 0", 1},
    {Ask::write, "1000000000000000 011 01100010 0101 0", ControlError::echo, "011 01100010 0100 0",
     0},
    {Ask::write, "1000000000000000 011 01100011 0100 0", ControlError::echo, "011 01100010 0100 0",
     0},
    {Ask::read, "1000000000000000 101 01100010 0100 1", ControlError::next_unavailable,
     "101 00000000 0000 0 0", 1},
    {Ask::write, "1000000000000000 011 01100010 0100 1", ControlError::next_unavailable,
     "011 01100010 0100 0 0", 1},
    {Ask::command, "1000000000000000 00000000", ControlError::not_accepted, "1 0000000 0", 0},
    {Ask::command, "1000000000000000 01000000", ControlError::ida_pattern, "1 0000000 0", 0},
    {Ask::command, "1000000000000000 10000001", ControlError::ida_pattern, "1 0000000 0", 0},
    {Ask::read, "1000000000000000 101 01100010 01?0 0", ControlError::frame_lost,
     "101 00000000 0000", 0},
}};

void expect_recovery(Access& access) {
  const unsigned before = access.frames.zeros;
  access.ask(Ask::read);
  std::array<std::uint8_t, 1> byte{};
  access.session.read(0, 0x42, byte);
  const std::uint32_t frames = access.frames.run(good_read);
  BISS_EXPECT(!access.session.outcome().error);
  BISS_EXPECT_EQ(byte[0], 0x62);
  BISS_EXPECT(frames <= 47);
  BISS_EXPECT(access.frames.zeros_before >= 14) << "zeros before " << before;
}

std::string_view behind_header(const Frames& frames) { return frames.cdm().substr(16); }

bool same_bits(std::string_view bits, std::string_view spaced) {
  CdsScript line;
  line.add(spaced);
  return bits == line.view();
}

BISS_TEST(ControlFailure, EachCause_IsNamedAndTheNextAccessWorks) {
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& c = cases[i];
    Access access;
    access.ask(c.ask);
    access.frames.run(c.cds);
    const ControlOutcome& outcome = access.session.outcome();
    BISS_EXPECT_EQ(access.error(), c.error) << "case " << i;
    BISS_EXPECT_EQ(outcome.bytes_done, c.bytes_done) << "case " << i;
    BISS_EXPECT_EQ(outcome.tries, 1);
    BISS_EXPECT(same_bits(behind_header(access.frames), c.cdm)) << "case " << i;
    expect_recovery(access);
  }
}

BISS_TEST(ControlFailure, ErrorNames_AreTheEnumerators) {
  for (std::size_t i = 0; i < control_error_count; ++i) {
    const auto name = name_of(static_cast<ControlError>(i));
    BISS_EXPECT(!name.empty());
    for (std::size_t k = 0; k < i; ++k) BISS_EXPECT(name != name_of(static_cast<ControlError>(k)));
  }
  BISS_EXPECT(name_of(ControlError::ida_pattern) == "ida_pattern");
  BISS_EXPECT(name_of(ControlError::cancelled) == "cancelled");
}

BISS_TEST(ControlFailure, SlavesPresent_AreCounted) {
  for (unsigned count = 1; count <= 9; ++count) {
    for (unsigned slave = 0; slave < 8; ++slave) {
      CdsScript cds;
      for (unsigned i = 0; i < 16; ++i) cds.add(i < count ? '1' : '0');
      cds.add("101 01100010 0100 0");
      Access access;
      access.session.read(slave, 0x42, std::span(access.bytes).first(1));
      access.frames.run(cds.view());
      const ControlOutcome& outcome = access.session.outcome();
      BISS_EXPECT_EQ(outcome.slaves_present, count >= 8 ? 0xFFU : (1U << count) - 1U);
      BISS_EXPECT_EQ(outcome.more_slaves, count == 9);
      if (slave < count) {
        BISS_EXPECT(!outcome.error);
      } else {
        BISS_EXPECT_EQ(access.error(), ControlError::no_such_slave);
        BISS_EXPECT_EQ(access.frames.cdm().size(), 17);
      }
    }
  }
}

BISS_TEST(ControlFailure, Commands_AreExecutedIfEnoughAccept) {
  // Slaves 0 and 7 are addressed; the last word is the one of IDA7, in the frame that EX ends.
  const auto run = [](ExecuteIf execute_if, std::string_view ids, std::string_view ida) {
    CdsScript cds;
    cds.add(ids);
    cds.add(ida);
    ControlSession session;
    Frames frames(session);
    session.command(0x81, ControlCommand::channels, execute_if);
    frames.run(cds.view());
    const bool executed = frames.cdm().size() == 25 && frames.cdm()[24] == '1';
    BISS_EXPECT(executed == !session.outcome().error);
    return executed;
  };
  constexpr std::string_view all = "1111111100000000";
  constexpr std::string_view four = "1111000000000000";
  using enum ExecuteIf;
  BISS_EXPECT(run(all_accept, all, "10000001"));
  BISS_EXPECT(!run(all_accept, all, "10000000") && !run(all_accept, all, "00000001"));
  BISS_EXPECT(!run(all_accept, all, "10000011") && !run(all_accept, all, "11111111"));
  BISS_EXPECT(!run(all_accept, four, "10000000"));
  BISS_EXPECT(run(any_accepts, all, "10000001") && run(any_accepts, all, "00000001"));
  BISS_EXPECT(run(any_accepts, four, "10000000"));
  BISS_EXPECT(!run(any_accepts, all, "00000000") && !run(any_accepts, all, "00010001"));
  BISS_EXPECT(run(always, all, "00000000") && run(always, all, "11111111"));
  BISS_EXPECT(run(always, four, "00000000") && !run(always, "0000000000000000", ""));
}

BISS_TEST(ControlFailure, ARetry_FollowsWhereDamageCanBeTheCause) {
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& c = cases[i];
    Access access({.retries = 2});
    access.ask(c.ask);
    access.frames.answer(c.cds);
    std::uint32_t count = 0;
    while (!access.session.done() && access.session.outcome().tries < 2) {
      access.frames.step();
      BISS_ASSERT(++count < 200);
    }
    const bool again = !access.session.done();
    BISS_EXPECT_EQ(again, worth_retrying(c.error)) << "case " << i;
    if (!again) continue;
    CdsScript cds;
    cds.add(c.ask == Ask::command ? "1000000000000000 10000000"
            : c.ask == Ask::read  ? good_read
                                  : good_echo);
    if (c.bytes_done == 0 && c.ask != Ask::command) cds.add("1 01100010 0100 0");
    access.frames.run(cds.view());
    const ControlOutcome& outcome = access.session.outcome();
    BISS_EXPECT(!outcome.error && outcome.retried == c.error) << "case " << i;
    BISS_EXPECT_EQ(outcome.tries, 2);
    // The frame that failed is the first of the 14, if it was not lost.
    const unsigned zeros = c.error == ControlError::frame_lost ? 14 : 13;
    BISS_EXPECT(access.frames.zeros_before >= 14) << "case " << i;
    BISS_EXPECT_EQ(outcome.frames, count + zeros + access.frames.cdm().size()) << "case " << i;
    if (c.ask == Ask::command) continue;
    BISS_EXPECT(access.bytes[0] == 0x62 && access.bytes[1] == 0x62);
    // The retry continues with the first byte that is not done.
    CdsScript bits;
    bits.number(register_header(0, 0x42 + c.bytes_done), 11);
    BISS_EXPECT(access.frames.cdm().substr(1, 11) == bits.view()) << "case " << i;
  }
}

BISS_TEST(ControlFailure, Retries_AreBounded) {
  for (const unsigned retries : {0U, 1U, 5U, 255U}) {
    Access access({.retries = static_cast<std::uint8_t>(retries)});
    access.ask(Ask::read);
    const std::uint32_t frames = access.frames.run("", 20'000);
    BISS_EXPECT_EQ(access.error(), ControlError::no_answer);
    // 14 zeros and 17 bits; the 0 in place of R is the first of the next 14.
    BISS_EXPECT_EQ(frames, 31 + 30 * retries);
    BISS_EXPECT_EQ(access.session.outcome().tries, 1 + retries);
    expect_recovery(access);
  }
}

BISS_TEST(ControlFailure, BusySlaves_AreWaitedFor) {
  for (const bool write : {false, true}) {
    for (unsigned at = write ? 1 : 0; at < 2; ++at) {
      for (unsigned busy = 0; busy < 120; ++busy) {
        CdsScript cds;
        cds.add(write ? test::write_accepted : test::read_accepted);
        --cds.size;
        for (unsigned i = 0; i < 2; ++i) {
          for (unsigned k = 0; i == at && k < busy; ++k) cds.add('0');
          cds.add("1 01100010 0100 0");
        }
        Access access;
        access.ask(write ? Ask::write : Ask::read);
        const std::uint32_t frames = access.frames.run(cds.view());
        // 20 ms are 80 frames: the 81st comes 20 ms after the one in which S was first due.
        const auto& outcome = access.session.outcome();
        if (busy <= 81) {
          BISS_EXPECT(!outcome.error) << busy << " frames";
          BISS_EXPECT_EQ(frames, 61 + busy);
          BISS_EXPECT_EQ(outcome.longest_busy.count, microseconds(250).count * busy);
          BISS_EXPECT(access.bytes[0] == 0x62 && access.bytes[1] == 0x62);
        } else {
          BISS_EXPECT_EQ(access.error(), ControlError::busy_too_long) << busy << " frames";
          BISS_EXPECT_EQ(outcome.bytes_done, at);
          expect_recovery(access);
        }
      }
    }
  }
}

BISS_TEST(ControlFailure, TheLongestWaitOfAnAccess_IsTold) {
  for (const bool first_is_longer : {false, true}) {
    CdsScript cds;
    cds.add(test::read_accepted);
    --cds.size;
    cds.add(first_is_longer ? "00000" : "00");
    cds.add("1 01100010 0100 0");
    cds.add(first_is_longer ? "00" : "00000");
    cds.add("1 01100010 0100 0");
    Access access;
    access.ask(Ask::read);
    access.frames.run(cds.view());
    BISS_EXPECT(!access.session.outcome().error);
    BISS_EXPECT(access.session.outcome().longest_busy == microseconds(5 * 250));
    // The next access has another limit and reports its own delays.
    access.session.set_options({.busy_max = microseconds(250)});
    access.ask(Ask::read);
    access.frames.run(cds.view());
    BISS_EXPECT_EQ(access.error(), ControlError::busy_too_long);
    BISS_EXPECT_EQ(access.session.outcome().bytes_done, first_is_longer ? 0 : 1);
    BISS_EXPECT_EQ(access.session.outcome().longest_busy.count,
                   first_is_longer ? 0 : microseconds(500).count);
  }
}

// The longest busy time of a read whose slave is busy for five frames; the clock wraps around so
// many frames after the first one. 0 where the read failed.
constexpr Picoseconds busy_across_the_wrap(std::int64_t frames_before) {
  ControlSession session;
  std::array<std::uint8_t, 1> byte{};
  session.read(0, 0x42, byte);
  Frames frames(session);
  const Picoseconds end_of_time{std::numeric_limits<std::int64_t>::max()};
  frames.now = end_of_time - frames.cycle * frames_before;
  frames.run("1000000000000000 10 00000 1 01100010 0100 0");
  return session.outcome().error || byte[0] != 0x62 ? Picoseconds{}
                                                    : session.outcome().longest_busy;
}
static_assert(busy_across_the_wrap(14 + 18 + 3) == microseconds(5 * 250));

BISS_TEST(ControlFailure, BusySlaveWhileTheClockWrapsAround_IsWaitedFor) {
  for (std::int64_t before = 0; before < 60; ++before) {
    BISS_EXPECT_EQ(busy_across_the_wrap(before).count, microseconds(5 * 250).count) << before;
  }
}

BISS_TEST(ControlFailure, SlavesOfAnEarlierTry_AreForgotten) {
  Access access({.retries = 1});
  access.ask(Ask::read);
  access.frames.answer("1111111110000000 01");
  while (access.session.outcome().tries < 2) access.frames.step();
  access.frames.run("");
  BISS_EXPECT_EQ(access.error(), ControlError::no_answer);
  BISS_EXPECT(access.session.outcome().retried == ControlError::rw_pattern);
  BISS_EXPECT_EQ(access.session.outcome().slaves_present, 0);
  BISS_EXPECT(!access.session.outcome().more_slaves);
}

BISS_TEST(ControlFailure, AFrameLostAnywhere_IsNamedUnlessAllIsDone) {
  for (const Ask ask : {Ask::read, Ask::write, Ask::command}) {
    const unsigned bits = ask == Ask::command ? 24 : 46;
    for (unsigned lost = 0; lost < bits; ++lost) {
      CdsScript cds;
      cds.add(ask == Ask::command ? "1000000000000000 10000000"
              : ask == Ask::read  ? good_read
                                  : good_echo);
      if (ask != Ask::command) cds.add("1 01100010 0100 0");
      BISS_ASSERT(cds.size == bits);
      cds.text[lost] = '?';
      Access access;
      access.ask(ask);
      access.frames.run(cds.view());
      if (ask != Ask::command && lost == bits - 1) {
        BISS_EXPECT(!access.session.outcome().error);
      } else {
        BISS_EXPECT_EQ(access.error(), ControlError::frame_lost) << "bit " << lost;
        BISS_EXPECT_EQ(access.frames.cdm().size(), lost + 2);
        BISS_EXPECT(access.frames.cdm().back() == '0');
      }
      expect_recovery(access);
    }
  }
  Access access;
  access.ask(Ask::read);
  for (unsigned i = 0; i < 13; ++i) BISS_EXPECT(!access.frames.step(CdsBit::missing));
  BISS_EXPECT(!access.session.done());
  access.frames.step(CdsBit::missing);
  BISS_EXPECT_EQ(access.error(), ControlError::frame_lost);
}

BISS_TEST(ControlFailure, CancelledAnywhere_IsFollowedBy14Zeros) {
  for (const Ask ask : {Ask::read, Ask::write, Ask::command}) {
    for (unsigned at = 0; at < 39; ++at) {
      Access access;
      access.ask(ask);
      access.frames.answer(ask == Ask::command ? "1000000000000000 10000000"
                           : ask == Ask::read  ? good_read
                                               : good_echo);
      for (unsigned i = 0; i < at; ++i) access.frames.step();
      BISS_ASSERT(!access.session.done());
      access.session.cancel();
      BISS_EXPECT(access.session.done());
      BISS_EXPECT_EQ(access.error(), ControlError::cancelled);
      std::array<std::uint8_t, 1> byte{};
      access.session.read(0, 0x42, byte);
      BISS_EXPECT_EQ(access.frames.run(good_read), 47);
      BISS_EXPECT(byte[0] == 0x62 && access.frames.zeros_before >= 14);
      access.session.cancel();
      BISS_EXPECT(!access.session.outcome().error);
    }
  }
}

}  // namespace biss::control_failure_test
