#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "biss/frame/encode.hpp"
#include "biss/safety/configurations.hpp"
#include "firmware/cross_compare/processor.hpp"
#include "tests/core/test.hpp"

namespace cross_compare {
namespace cross_compare_test {

using biss::SafetyState;
using biss::SafetyVerdict;

constexpr auto type = biss::safety_configuration("fs-36-28");
using Plan = biss::FixedSafetyPlan<type.frame_format(), type.setup>;
constexpr biss::Picoseconds cycle = biss::nanoseconds(31'250);
constexpr std::uint16_t connection = 7;

template <class AnyPlan = Plan>
using Field = Processor<AnyPlan, biss::FieldEvaluation<AnyPlan>>;
template <class AnyPlan = Plan>
using Line = Processor<AnyPlan, biss::LineEvaluation<AnyPlan>>;

// The answer to a request, with the encoder's counter.
biss::FrameBits answer(std::uint32_t request, std::uint64_t position, std::uint32_t lead = 3,
                       std::uint32_t ack = 40) {
  Plan::Frame frame;
  frame.channel_count = 2;
  frame.lead_clocks = static_cast<std::uint16_t>(lead);
  frame.ack_clocks = static_cast<std::uint16_t>(ack);
  frame.channel_list[0] = {position, 0, true, true};
  frame.channel_list[1] = {position >> 8U, request % 63U + 1U, true, true};
  return biss::encode_frame(frame, Plan::codec()).value();
}

biss::TwoClocks time_of(std::uint32_t request, biss::Picoseconds started = {}) {
  const biss::Picoseconds now = cycle * request + started;
  return {now, now + biss::milliseconds(3)};
}

// Two processors of a connection, and the messages of their last request.
template <class First = Field<>, class Second = Line<>>
struct Pair {
  First a;
  Second b;
  Message of_a{};
  Message of_b{};
  std::uint32_t request = 0;

  explicit Pair(std::uint16_t number = connection) : a(number), b(number) {
    BISS_EXPECT(a.power_up() && b.power_up());
  }
  void evaluate(std::uint64_t position, std::uint64_t position_of_b) {
    ++request;
    of_a = a.evaluate(request, answer(request, position).view());
    of_b = b.evaluate(request, answer(request, position_of_b).view());
  }
  void evaluate(std::uint64_t position = 0x4'0000) { evaluate(position, position); }
  bool good(std::uint64_t position = 0x4'0000) {
    evaluate(position);
    const auto at_a = a.compare(time_of(request), of_b);
    const auto at_b = b.compare(time_of(request), of_a);
    return at_a && at_b && *at_a == *at_b;
  }
  void until_safe() {
    for (int i = 0; i < 3; ++i) good();
    BISS_EXPECT(is_safe());
  }
  bool is_safe() { return a.is_safe(time_of(request)) && b.is_safe(time_of(request)); }
};

BISS_TEST(CrossCompare, MessagesOfEachOther_AreSafeFromTheThirdRequestOn) {
  Pair pair;
  for (std::uint32_t i = 1; i <= 200; ++i) BISS_EXPECT_EQ(pair.good(i * 1000U), i >= 3) << i;
  BISS_EXPECT(pair.is_safe());
}

// TX shorted to RX, or an echo on a half-duplex line.
BISS_TEST(CrossCompare, OwnMessageForTheOthers_IsNeverSafe) {
  for (const std::uint64_t apart : {0U, 0x1'0000U}) {
    Pair pair;
    for (int i = 0; i < 100; ++i) {
      pair.evaluate(0x4'0000, 0x4'0000 + apart);
      BISS_EXPECT(!pair.a.compare(time_of(pair.request), pair.of_a));
      BISS_EXPECT(!pair.b.compare(time_of(pair.request), pair.of_b));
      BISS_EXPECT(pair.a.state() == SafetyState::starting);
      BISS_EXPECT(pair.b.state() == SafetyState::starting);
    }
  }
}

BISS_TEST(CrossCompare, EchoBeforeTheOthersMessage_IsOverlooked) {
  Pair pair;
  pair.until_safe();
  pair.evaluate();
  BISS_EXPECT(!pair.a.compare(time_of(pair.request), pair.of_a));
  BISS_EXPECT(!pair.b.compare(time_of(pair.request), pair.of_b));
  BISS_EXPECT(pair.a.compare(time_of(pair.request), pair.of_b).has_value());
  BISS_EXPECT(pair.b.compare(time_of(pair.request), pair.of_a).has_value());
}

template <class Either>
void refuses_its_like() {
  Pair<Either, Either> pair;
  for (int i = 0; i < 100; ++i) BISS_EXPECT(!pair.good());
  BISS_EXPECT(pair.a.state() == SafetyState::starting);
  BISS_EXPECT(pair.b.state() == SafetyState::starting);
}
BISS_TEST(CrossCompare, TwoProcessorsWithTheSameIdentity_AreNeverSafe) {
  refuses_its_like<Field<>>();
  refuses_its_like<Line<>>();
}

BISS_TEST(CrossCompare, TwoCrossedAxes_AreNeverSafe) {
  Pair one(1);
  Pair two(2);
  for (int i = 0; i < 100; ++i) {
    one.evaluate();
    two.evaluate();
    BISS_EXPECT(!one.a.compare(time_of(one.request), two.of_b));
    BISS_EXPECT(!one.b.compare(time_of(one.request), two.of_a));
    BISS_EXPECT(!two.a.compare(time_of(two.request), one.of_b));
    BISS_EXPECT(!two.b.compare(time_of(two.request), one.of_a));
  }
  BISS_EXPECT(one.a.state() == SafetyState::starting && one.b.state() == SafetyState::starting);
  BISS_EXPECT(two.a.state() == SafetyState::starting && two.b.state() == SafetyState::starting);
}

BISS_TEST(CrossCompare, AnyOtherConnectionOrRequest_IsRefused) {
  const biss::SafetyFinding finding{.cause = SafetyVerdict::safe};
  const Address address{0x1234'5678, 0x9ABC, Sender::line};
  for (unsigned bit = 0; bit < 32; ++bit) {
    Address other = address;
    other.request ^= 1U << bit;
    BISS_EXPECT(!decode(address, encode(other, finding))) << bit;
    BISS_EXPECT(!decode(other, encode(address, finding))) << bit;
    other = address;
    other.connection = static_cast<std::uint16_t>(other.connection ^ (1U << (bit % 16U)));
    BISS_EXPECT(!decode(address, encode(other, finding))) << bit;
    BISS_EXPECT(!decode(other, encode(address, finding))) << bit;
    other = address;
    other.sender = static_cast<Sender>(static_cast<unsigned>(other.sender) ^ (1U << (bit % 16U)));
    BISS_EXPECT(!decode(address, encode(other, finding))) << bit;
  }
  BISS_EXPECT(decode(address, encode(address, finding)).has_value());
}

BISS_TEST(CrossCompare, MessageOfTheRequestBefore_IsNeverSafe) {
  Pair pair;
  Message of_a{};
  Message of_b{};
  for (int i = 0; i < 100; ++i) {
    pair.evaluate();
    BISS_EXPECT(!pair.a.compare(time_of(pair.request), of_b));
    BISS_EXPECT(!pair.b.compare(time_of(pair.request), of_a));
    of_a = pair.of_a;
    of_b = pair.of_b;
  }
  BISS_EXPECT(pair.a.state() == SafetyState::starting && pair.b.state() == SafetyState::starting);
}

BISS_TEST(CrossCompare, EveryPartOfAFinding_ArrivesAsItWasSent) {
  const Address address{9, connection, Sender::field};
  const biss::SafetyFinding finding{.cpw_position = 0x0123'4567'89AB'CDEF,
                                    .spw_position = 0xFEDC'BA98'7654'3211,
                                    .difference_lsb = -2'000'000'003,
                                    .life_counter = 0x3A,
                                    .nW = 2,
                                    .cause = SafetyVerdict::spw_error};
  const auto received = decode(address, encode(address, finding));
  BISS_ASSERT(received.has_value());
  BISS_EXPECT(*received == finding);
}

BISS_TEST(CrossCompare, MessageWithUpToTwoWrongBits_IsRefused) {
  const Address address{9, connection, Sender::field};
  const Message good = encode(address, {.cpw_position = 12'345, .cause = SafetyVerdict::safe});
  constexpr std::size_t bits = 8U * good.size();
  constexpr std::size_t step = biss::test::rounds(1, 37);
  Message message = good;
  const auto flip = [&](std::size_t bit) {
    message[bit / 8U] = static_cast<std::uint8_t>(message[bit / 8U] ^ (0x80U >> (bit % 8U)));
  };
  for (std::size_t i = 0; i < bits; ++i) {
    flip(i);
    BISS_EXPECT(!decode(address, message)) << i;
    for (std::size_t k = i + 1; k < bits; k += step) {
      flip(k);
      BISS_EXPECT(!decode(address, message)) << i << " " << k;
      flip(k);
    }
    flip(i);
  }
  BISS_EXPECT(!decode(address, Message{}));
}

// The address is changed into the expected one on the way, and nothing else.
BISS_TEST(CrossCompare, AddressMadeTheExpectedOneOnTheWay_IsRefusedByTheChecksum) {
  const Address expected{9, connection, Sender::line};
  const biss::SafetyFinding finding{.cpw_position = 77, .cause = SafetyVerdict::safe};
  const Message wanted = encode(expected, finding);
  for (const Address& other :
       {Address{10, connection, Sender::line}, Address{9, connection + 1, Sender::line},
        Address{9, connection, Sender::field}, Address{9, connection ^ 0x8000, Sender::line},
        Address{0x8000'0009, connection, Sender::line}}) {
    Message message = encode(other, finding);
    for (std::size_t at = 0; at < 8; ++at) message[at] = wanted[at];
    BISS_EXPECT(!decode(expected, message)) << other.request << " " << other.connection;
  }
}

BISS_TEST(CrossCompare, DifferentAnswers_AreADisagreementOnBothProcessors) {
  Pair pair;
  pair.until_safe();
  pair.evaluate(0x4'0000, 0x4'0001);
  BISS_EXPECT(!pair.a.compare(time_of(pair.request), pair.of_b));
  BISS_EXPECT(!pair.b.compare(time_of(pair.request), pair.of_a));
  BISS_EXPECT(pair.a.state() == SafetyState::failed && pair.b.state() == SafetyState::failed);
  BISS_EXPECT_EQ(pair.a.cause(), SafetyVerdict::disagreement);
  BISS_EXPECT_EQ(pair.b.cause(), SafetyVerdict::disagreement);
}

BISS_TEST(CrossCompare, WithoutAMessageInTime_TheWatchdogEndsTheSafeState) {
  Pair pair;
  pair.until_safe();
  pair.evaluate();
  const auto late = time_of(pair.request + 1);
  BISS_EXPECT(!pair.a.compare(late, Message{}));
  BISS_EXPECT(pair.a.state() == SafetyState::latched);
  BISS_EXPECT_EQ(pair.a.cause(), SafetyVerdict::watchdog);
  BISS_EXPECT(!pair.b.is_safe(late));
  BISS_EXPECT_EQ(pair.b.cause(), SafetyVerdict::watchdog);
  BISS_EXPECT(!pair.a.acknowledge(SafetyVerdict::clock));
  BISS_EXPECT(pair.a.acknowledge(SafetyVerdict::watchdog));
  BISS_EXPECT(pair.a.state() == SafetyState::starting);
}

BISS_TEST(CrossCompare, MessageThatArrivesTwice_IsComparedOnce) {
  Pair pair;
  pair.until_safe();
  BISS_EXPECT(pair.good());
  BISS_EXPECT(!pair.a.compare(time_of(pair.request), pair.of_b));
  BISS_EXPECT(!pair.b.compare(time_of(pair.request), pair.of_a));
  BISS_EXPECT(pair.is_safe());
  BISS_EXPECT(pair.good());
}

BISS_TEST(CrossCompare, MessageBeforeAnyEvaluation_IsNotCompared) {
  Pair pair;
  const biss::SafetyFinding finding{};
  pair.a.compare(time_of(0), encode({0, connection, Sender::line}, finding));
  pair.b.compare(time_of(0), encode({0, connection, Sender::field}, finding));
  BISS_EXPECT(pair.a.state() == SafetyState::starting && pair.b.state() == SafetyState::starting);
}

BISS_TEST(CrossCompare, WithoutTheSelfTest_IsNeverSafe) {
  Field<> a(connection);
  Line<> b(connection);
  for (std::uint32_t request = 1; request < 10; ++request) {
    const Message of_a = a.evaluate(request, answer(request, 0).view());
    const Message of_b = b.evaluate(request, answer(request, 0).view());
    BISS_EXPECT(!a.compare(time_of(request), of_b) && !b.compare(time_of(request), of_a));
    BISS_EXPECT(!a.is_safe(time_of(request)) && !b.is_safe(time_of(request)));
  }
}

BISS_TEST(CrossCompare, PositionOutsideAStimulus_IsAFaultOnBothProcessors) {
  Pair pair;
  pair.until_safe();
  pair.a.expect_position(0x500, 0x600);
  pair.b.expect_position(0x500, 0x600);
  BISS_EXPECT(!pair.good(0x4'0000));
  BISS_EXPECT_EQ(pair.a.cause(), SafetyVerdict::stimulus);
  BISS_EXPECT_EQ(pair.b.cause(), SafetyVerdict::stimulus);
}

// With the counter's first value from the encoder's maker.
constexpr biss::SafetySetup first_known() {
  biss::SafetySetup setup = type.setup;
  setup.counter.first = 2;
  return setup;
}
using FirstPlan = biss::FixedSafetyPlan<type.frame_format(), first_known()>;

BISS_TEST(CrossCompare, RestartOfTheEncoder_AwaitsTheFirstValueAndDropsTheAnswerBefore) {
  Pair<Field<FirstPlan>, Line<FirstPlan>> pair;
  // Its first answer is missing.
  pair.request = 1;
  for (int i = 0; i < 5; ++i) BISS_EXPECT(!pair.good());
  BISS_EXPECT(pair.a.state() == SafetyState::starting);
  pair.evaluate();
  pair.a.encoder_restarted();
  pair.b.encoder_restarted();
  BISS_EXPECT(!pair.a.compare(time_of(pair.request), pair.of_b));
  BISS_EXPECT(!pair.b.compare(time_of(pair.request), pair.of_a));
  // The counter of answer() has the value 2 again.
  pair.request = 63;
  pair.until_safe();
}

constexpr biss::SafetySetup transfers_timed() {
  biss::SafetySetup setup = type.setup;
  setup.clocks.bit_period = biss::nanoseconds(100);
  return setup;
}
using TimedPlan = biss::FixedSafetyPlan<type.frame_format(), transfers_timed()>;

BISS_TEST(CrossCompare, TransferOfTheRightTime_IsSafeAndOfAWrongOneIsAClockFault) {
  Pair<Field<TimedPlan>, Line<TimedPlan>> pair;
  for (const bool right : {true, false}) {
    for (int i = 0; i < 5; ++i) {
      pair.evaluate();
      biss::TwoClocks now = time_of(pair.request);
      const auto clocks = static_cast<std::int64_t>(answer(pair.request, 0).size_bits());
      now.transfer.time = biss::nanoseconds(right ? 100 : 110) * clocks;
      pair.a.compare(now, pair.of_b);
      pair.b.compare(now, pair.of_a);
    }
    BISS_EXPECT_EQ(pair.is_safe(), right);
  }
  BISS_EXPECT_EQ(pair.a.cause(), SafetyVerdict::clock);
  BISS_EXPECT_EQ(pair.b.cause(), SafetyVerdict::clock);
}

enum class Fault : std::uint8_t {
  message_lost,     // to B
  message_damaged,  // to A
  message_old,      // to B: the message of the previous request
  buffer_of_a,      // a bit of A's copy of the answer
  finding_of_b,     // B calculates another position
  line,             // a bit of the answer, in both copies
  echo,             // to B: its own message
  other_pair,       // to A: the message of the processor B of another pair
};
// The verdict that holds, and its cause.
struct Held {
  SafetyState state;
  SafetyVerdict cause;
};
constexpr Held nothing{SafetyState::safe, SafetyVerdict::self_test};
constexpr Held late{SafetyState::latched, SafetyVerdict::watchdog};
constexpr Held differ{SafetyState::failed, SafetyVerdict::disagreement};
constexpr Held crc{SafetyState::latched, SafetyVerdict::cpw_crc};
// For processor A and B.
constexpr std::array<std::array<Held, 2>, 8> held_after{{{nothing, late},
                                                         {late, nothing},
                                                         {nothing, late},
                                                         {differ, differ},
                                                         {differ, nothing},
                                                         {crc, crc},
                                                         {nothing, late},
                                                         {late, nothing}}};

void expect_held(auto& processor, const Held& held, std::uint32_t request) {
  BISS_EXPECT(processor.state() == held.state) << request;
  if (held.state == SafetyState::safe) return;
  BISS_EXPECT_EQ(processor.cause(), held.cause) << request;
  BISS_EXPECT_EQ(processor.acknowledge(held.cause), held.state == SafetyState::latched) << request;
}

// Constant-initialised, like everything that lives before firmware_main().
constinit std::optional<Field<>> a_of_cycles{std::in_place, connection};
constinit std::optional<Line<>> b_of_cycles{std::in_place, connection};

BISS_TEST(CrossCompare, CyclesWithFaults_AreSafeOnlyIfBothProcessorsHaveThePosition) {
  BISS_RANDOM(random, 0x5AFE'0040);
  auto& a = a_of_cycles;
  auto& b = b_of_cycles;
  BISS_EXPECT(a->state() == SafetyState::untested && b->state() == SafetyState::untested);
  BISS_EXPECT(a->power_up() && b->power_up());
  // All four clocks started at other times.
  const biss::Picoseconds start_of_b = biss::microseconds(700);
  std::uint64_t position = 0;
  std::uint32_t good_in_a_row = 0;
  Message last_of_a{};
  for (std::uint32_t n = 0; n < 1200; ++n) {
    const bool faulty = n % 20 == 19;
    const std::size_t fault = n / 20 % held_after.size();
    const auto is = [&](Fault one) { return faulty && static_cast<Fault>(fault) == one; };
    position = (position + 123'456'789) & biss::low_mask(36);
    biss::FrameBits bits = answer(n, position, 2U + random.below(5), 32U + random.below(60));
    // A bit of the CPW, before its CRC.
    const std::size_t bit = bits.size_bits() - 1U - Plan::payload_bits() + random.below(36);
    if (is(Fault::line)) bits.flip(bit);
    Message of_b = b->evaluate(n, bits.view());
    if (is(Fault::buffer_of_a)) bits.flip(bit);
    Message of_a = a->evaluate(n, bits.view());
    const Message fresh = of_a;
    if (is(Fault::message_lost)) of_a = {};
    if (is(Fault::message_old)) of_a = last_of_a;
    if (is(Fault::message_damaged)) of_b[random.below(of_b.size())] ^= 0x10;
    if (is(Fault::echo)) of_a = of_b;
    if (is(Fault::finding_of_b) || is(Fault::other_pair)) {
      Address address{n, connection, Sender::line};
      auto finding = *decode(address, of_b);
      if (is(Fault::finding_of_b)) finding.spw_position ^= 1U;
      if (is(Fault::other_pair)) ++address.connection;
      of_b = encode(address, finding);
    }
    last_of_a = fresh;
    const auto at_a = a->compare(time_of(n), of_b);
    const auto at_b = b->compare(time_of(n, start_of_b), of_a);
    const bool torque = at_a && at_b && *at_a == *at_b;
    good_in_a_row = faulty ? 0 : good_in_a_row + 1;
    BISS_EXPECT_EQ(torque, good_in_a_row >= type.setup.start_frames) << n;
    if (torque) BISS_EXPECT_EQ(biss::control_position(Plan(), *at_a), position) << n;
    if (!faulty) continue;
    // A processor that did not get its message notices in the next period at the latest.
    a->is_safe(time_of(n + 1));
    b->is_safe(time_of(n + 1, start_of_b));
    expect_held(*a, held_after[fault][0], n);
    expect_held(*b, held_after[fault][1], n);
    if (held_after[fault][0].state != SafetyState::failed) continue;
    // Only a power-up of both ends a fault of a processor.
    a.emplace(connection);
    b.emplace(connection);
    BISS_EXPECT(a->power_up() && b->power_up());
  }
}

}  // namespace cross_compare_test
}  // namespace cross_compare
