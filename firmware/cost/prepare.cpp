#include "firmware/cost/prepare.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace cost::prepare {
namespace {

constexpr Codec codec{format};

std::uint16_t random_lead(Random& random) {
  return static_cast<std::uint16_t>(2U + random.below(7));
}
std::uint16_t random_ack(Random& random) {
  return static_cast<std::uint16_t>(33U + random.below(128));
}

biss::FrameBits frame_bits(std::uint64_t position, Random& random) {
  biss::Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = random_lead(random);
  frame.ack_clocks = random_ack(random);
  frame.channel_list[0].position = position;
  return biss::encode_frame(frame, codec).value();
}

// The bits, as far as there is room, and zeros.
void put(Sample& sample, const biss::FrameBits& bits) {
  sample.bytes = {};
  std::copy_n(bits.bytes().begin(), std::min(bits.bytes().size(), sample.bytes.size()),
              sample.bytes.begin());
  sample.size_bytes = static_cast<std::uint32_t>(sample.bytes.size());
}

// CDS bit k of the only slave, which accepts every access. It is busy for `late` frames before the
// first byte and for `busy` before the second; its data are 0. Kinds as in control_frame().
bool agreeing_cds(std::uint32_t k, std::uint32_t kind, std::uint32_t late, std::uint32_t busy) {
  if (k == 0) return true;
  if (kind == 2) return k == biss::control_bit::ida;
  if (k < 18) return k == (kind == 0 ? biss::control_bit::read : biss::control_bit::write);
  // S, eight zeros, CRC 1111, P, and S of the second byte.
  if (k < 18 + late) return false;
  const std::uint32_t at = k - 18 - late;
  return at == 0 || (at >= 9 && at <= 12) || at == 14 + busy;
}

}  // namespace

void buffer(Sample& sample, Random& random) {
  sample.expected = random.bits(26);
  put(sample, frame_bits(sample.expected, random));
  sample.size_bytes = static_cast<std::uint32_t>(biss::spi_bytes(format, setup, encoder.timing));
}

void position(Sample& sample, Random& random) {
  sample.value = random.bits(26);
  sample.index = random_ack(random);
  sample.expected = 2U + sample.index + 2U + 34U + 1U;
}

void crc(Sample& sample, Random& random) {
  sample.value = random.bits(28);
  sample.expected = biss::CrcBitwise(biss::crc6)(sample.value, 28);
}

void ack(Sample& sample, Random& random) {
  const std::uint32_t start = 2U + random_ack(random);
  sample.expected = start;
  sample.bytes = {};
  sample.bytes[0] = 0xC0;
  // START is after byte 0, so byte 0 keeps its ones.
  sample.bytes[start / 8U] = static_cast<std::uint8_t>(0x80U >> (start % 8U));
  sample.size_bytes = static_cast<std::uint32_t>(sample.bytes.size());
}

void word(Sample& sample, Random& random) {
  for (auto& byte : sample.bytes) byte = static_cast<std::uint8_t>(random.bits(8));
  sample.size_bytes = static_cast<std::uint32_t>(sample.bytes.size());
  sample.index = random.below(48U * 8U - 28U + 1U);
  sample.expected = 0;
  for (std::uint32_t i = 0; i < 28; ++i) {
    sample.expected = sample.expected * 2U + (sample.bits()[sample.index + i] ? 1U : 0U);
  }
}

void step(Sample& sample, Random& random) {
  constexpr std::uint32_t most = (1U << 25U) - 1U;
  const std::uint32_t last = (1U << 26U) - 1U - random.below(most);
  const std::uint32_t move = random.below(most);
  const bool forward = random.flip();
  sample.counter->restart();
  sample.counter->update(last);
  sample.value = forward ? last + move : last - move;
  sample.expected = (sample.value >> 26U) != 0 ? 1 : 0;
}

void cycle(Sample& sample, Random& random) {
  const bool first = sample.value == 0;
  sample.value += static_cast<std::uint64_t>(axis_setup.cycle.count);
  sample.position += random.below(1U << 20U);
  if (random.flip()) sample.position -= (1 << 20) - 1;
  if (first) sample.position = 1 << 25;
  auto bits = frame_bits(static_cast<std::uint64_t>(sample.position) & biss::low_mask(26), random);
  const bool wrong = !first && random.below(64) == 0;
  if (wrong) bits.flip(bits.size_bits() - 2U - random.below(28));
  sample.expected = result_of(wrong   ? biss::AxisPosition{.cause = biss::AxisCause::crc}
                              : first ? biss::AxisPosition{.cause = biss::AxisCause::first}
                                      : biss::AxisPosition{.position = sample.position,
                                                           .state = biss::AxisState::measured});
  put(sample, bits);
}

void data_bit(Sample& sample, Random& random) {
  const biss::Picoseconds half = setup.period / 2;
  const std::uint64_t position = random.bits(26);
  // The adaptive timeout costs the most, because each edge moves its end.
  *sample.slave = EncoderSlave({}, {.timeout = {biss::TimeoutRule::adaptive, {}}}, {position});
  biss::Picoseconds now = biss::microseconds(1 + random.below(1000));
  const auto clock = [&] {
    sample.slave->step(now, false, false);
    const biss::StepOutput out = sample.slave->step(now + half, true, false);
    now += 2 * half;
    return out;
  };
  while (sample.slave->state() != biss::SlaveState::data) clock();
  // The first clock of data fetches the data.
  const std::uint32_t bit = random.below(25);
  for (std::uint32_t i = 0; i <= bit; ++i) clock();
  sample.value = static_cast<std::uint64_t>(now.count);
  const EncoderSlave here = *sample.slave;
  const biss::StepOutput out = clock();
  *sample.slave = here;
  const bool level = ((position >> (24U - bit)) & 1U) != 0;
  sample.expected = static_cast<std::uint64_t>(out.deadline.count) ^ (level ? 1U : 0U);
}

void data_sample(Sample& sample, Random& random) {
  constexpr biss::Picoseconds half = setup.period / 2;
  constexpr std::uint32_t start = 42;
  EncoderMaster& master = *sample.master;
  master = EncoderMaster({}, master_setup);
  biss::Picoseconds rise = biss::microseconds(1 + random.below(1000));
  bool slo = true;
  master.begin(rise - half, slo);
  // Each data bit differs from the previous one.
  const std::uint32_t clocks = start + 2U + random.below(30);
  for (std::uint32_t clock = 1; clock <= clocks; ++clock, rise += setup.period) {
    master.step(rise, slo);
    slo = clock == 1 || (clock >= start && !slo);
    master.step(rise + master_line_delay, slo);
    master.step(rise + half, slo);
    master.step(rise + half + master_line_delay, slo);
  }
  sample.value = static_cast<std::uint64_t>(rise.count);
  sample.index = slo ? 1 : 0;
  // MA is low again, and rises next.
  sample.expected = static_cast<std::uint64_t>((rise + setup.period).count);
}

void pins_byte(Sample& sample, Random& random) {
  while (!sample.polled->done()) sample.polled->step();
  const auto buffer = std::span(sample.bytes);
  sample.polled->start(buffer.first(3));
  // SLO is read before each edge, and the one before a rising edge counts.
  const std::uint32_t byte = random.below(256);
  std::uint32_t levels = 0;
  for (unsigned bit = 8; bit-- > 0;) levels = levels << 2U | (byte >> bit & 1U);
  sample.pins->value = levels << 16U;
  sample.expected = byte;
}

void control_frame(Sample& sample, Random& random) {
  biss::ControlSession& control = *sample.control;
  control = biss::ControlSession({.retries = static_cast<std::uint8_t>(random.below(2))});
  const auto bytes = std::span(sample.bytes).first<2>();
  const std::uint32_t kind = random.below(4);
  if (kind == 0) control.read(0, random.below(126), bytes);
  if (kind == 1) control.write(0, random.below(126), bytes);
  if (kind == 2) control.command(1, biss::ControlCommand::channels);
  if (kind == 3) control.broadcast(biss::ControlCommand::channels);
  const std::uint32_t busy = random.below(2);
  const std::uint32_t late = kind == 0 ? busy : 0;
  // Every other frame contains a checked bit: IDL, IDA, the CRC, P.
  constexpr std::array<std::array<std::uint32_t, 2>, 4> judged{{{16, 31}, {16, 32}, {16, 24}, {}}};
  const std::uint32_t k = random.flip() ? judged[kind][random.below(2)] : random.below(36);
  constexpr std::uint32_t zeros = biss::control_reset_zeros;
  const std::uint32_t frames = zeros + k + late;
  biss::Picoseconds now = biss::microseconds(1 + random.below(1000));
  const auto cds = [&](std::uint32_t frame) {
    return frame > zeros && agreeing_cds(frame - zeros - 1U, kind, late, busy);
  };
  sample.bytes = {};
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    control.step(now, cds(frame) ? biss::CdsBit::one : biss::CdsBit::zero);
    now += biss::microseconds(31);
  }
  sample.index = random.flip() ? (cds(frames) ? 1U : 0U) : random.below(3);
  sample.value = static_cast<std::uint64_t>(now.count);
  const biss::ControlSession here = control;
  const bool cdm = control.step(now, static_cast<biss::CdsBit>(sample.index));
  sample.expected = (control.done() ? 2U : 0U) | (cdm ? 1U : 0U);
  control = here;
}

void server_frame(Sample& sample, Random& random) {
  biss::BankedRegisters<2> registers;
  for (const unsigned bank : {0U, 1U}) {
    for (unsigned i = 0; i < biss::bank_bytes; ++i) {
      registers.bank(bank).protect(i, biss::RegisterProtection::read_write);
    }
  }
  EncoderServer& server = *sample.server;
  server = EncoderServer(registers);
  biss::ControlSession session;
  const auto bytes = std::span(sample.bytes).first<2>();
  const std::uint32_t kind = random.below(3);
  if (kind == 0) session.read(0, random.below(63), bytes);
  if (kind == 1) session.write(0, random.below(63), bytes);
  if (kind == 2) session.command(1, biss::ControlCommand::channels, biss::ExecuteIf::always);
  // Every other frame does more than pass a bit on: the header's end, W, S, the last bit of a byte,
  // P.
  constexpr std::array<std::uint32_t, 5> busiest{15, 17, 18, 30, 31};
  const std::uint32_t k = random.flip() ? busiest[random.below(5)] : random.below(45);
  for (std::uint32_t frame = 0; frame < biss::control_reset_zeros + k; ++frame) {
    const bool cds = server.cds(false);
    server.cdm(session.step({}, cds ? biss::CdsBit::one : biss::CdsBit::zero));
  }
  EncoderServer ahead = server;
  const bool cds = ahead.cds(false);
  sample.index = session.step({}, cds ? biss::CdsBit::one : biss::CdsBit::zero) ? 1 : 0;
  ahead.cdm(sample.index != 0);
  sample.expected = (cds ? 2U : 0U) | (ahead.idle() ? 1U : 0U);
}

// ---- Frames for the safety monitor: good frames, damaged frames, and frames that no encoder sends

namespace {

using Plan = biss::FixedSafetyPlan<safety_format, safety_setup>;

struct Sent {
  std::uint64_t position = 0;
  std::uint64_t safety_position = 0;
  std::uint32_t life_counter = 0;
  bool cpw_nE = true;
  bool spw_nE = true;
  std::uint16_t ack = 33;
};

void put(Sample& sample, const Sent& sent, Random& random) {
  biss::BasicFrame<2> frame;
  frame.channel_count = 2;
  frame.lead_clocks = random_lead(random);
  frame.ack_clocks = sent.ack;
  frame.channel_list[0] = {sent.position, 0, sent.cpw_nE, random.flip()};
  frame.channel_list[1] = {sent.safety_position, sent.life_counter, sent.spw_nE, random.flip()};
  put(sample, biss::encode_frame(frame, Plan::codec()).value());
}

// Faults of an encoder, chosen at random.
void change(Sent& sent, Random& random) {
  switch (random.below(5)) {
    case 0:
      sent.life_counter = random.below(64);
      break;
    case 1:
      sent.safety_position = random.bits(28);
      break;
    case 2:
      sent.cpw_nE = random.flip();
      sent.spw_nE = random.flip();
      break;
    case 3:
      // The whole buffer is ACK, or nearly so.
      sent.ack = static_cast<std::uint16_t>(200U + random.below(170));
      break;
    default:
      sent.ack = static_cast<std::uint16_t>(1U + random.below(40));
  }
}

void damage(Sample& sample, Random& random) {
  const std::uint32_t bits = sample.size_bytes * 8U;
  switch (random.below(4)) {
    case 0:
      for (std::uint32_t flips = 1U + random.below(8); flips != 0; --flips) {
        const std::uint32_t at = random.below(bits);
        sample.bytes[at / 8U] =
            static_cast<std::uint8_t>(sample.bytes[at / 8U] ^ (0x80U >> at % 8U));
      }
      break;
    case 1:
      for (auto& byte : sample.bytes) byte = static_cast<std::uint8_t>(random.bits(8));
      break;
    case 2:
      sample.bytes.fill(random.flip() ? 0xFF : 0x00);
      break;
    default:
      sample.size_bytes = random.below(sample.size_bytes + 1U);
  }
}

// In the safe state, the last counter `last` at the time 0.
void make_safe(SafetyMonitor& monitor, std::uint32_t last) {
  biss::SafetyFinding finding;
  finding.cause = biss::SafetyVerdict::safe;
  for (std::uint32_t left = safety_setup.start_frames; left-- != 0;) {
    const std::uint32_t value = (last + 62U - left) % 63U + 1U;
    finding.life_counter = static_cast<std::uint8_t>(value);
    monitor.step(clocks_at(biss::nanoseconds(31'250).count * -std::int64_t{left}), finding,
                 finding);
  }
}

}  // namespace

void safety_frame(Sample& sample, Random& random) {
  const std::uint32_t last = 1U + random.below(63);
  sample.tested->put_into(*sample.safety);
  make_safe(*sample.safety, last);
  Sent sent;
  sent.position = random.bits(36);
  sent.safety_position = sent.position >> 8U;
  sent.life_counter = last % 63U + 1U;
  sent.ack = random_ack(random);
  const std::uint32_t kind = random.below(4);
  if (kind == 1) change(sent, random);
  put(sample, sent, random);
  if (kind == 2) damage(sample, random);
  const biss::Picoseconds now = biss::nanoseconds(random.below(8) == 0 ? 61'250 : 31'250);
  sample.value = static_cast<std::uint64_t>(now.count);
  const MonitorBytes here(*sample.safety);
  const biss::SafetyJudgement judgement = sample.safety->step(clocks_at(now.count), sample.bits());
  here.put_into(*sample.safety);
  sample.expected = result_of(judgement);
  const bool good = kind == 0 && now <= safety_setup.frame_gap_max;
  if (good && control_position(Plan(), *judgement.position) != sent.position)
    sample.expected = ~sample.expected;
}

}  // namespace cost::prepare
