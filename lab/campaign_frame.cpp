#include "lab/campaign_frame.hpp"

#include <algorithm>

#include "biss/base/bit_buffer.hpp"
#include "sim/random.hpp"

namespace biss::lab {
namespace {

std::vector<std::uint32_t> columns_of(const ChannelFormat& word) {
  std::vector<std::uint32_t> columns;
  std::uint32_t power = 1;
  for (unsigned bit = 0; bit < word.total_bits(); ++bit) {
    columns.push_back(power);
    power <<= 1U;
    if ((power >> word.crc.width_bits) != 0) power ^= word.crc.polynomial;
  }
  return columns;
}

using LineBits = BitBuffer<2048>;

// Clocks of ACK before the first bit that may be START.
std::size_t ack_clocks(const CampaignFrame& frame) {
  return std::max<std::size_t>(1, frame.plan().setup().bounds.ack_min_clocks);
}

LineBits line_of(const CampaignFrame& frame, const WordPair& words) {
  LineBits bits;
  bits.append_run(true, std::max<std::size_t>(1, frame.plan().setup().bounds.lead_min_clocks));
  bits.append_run(false, ack_clocks(frame));
  if (words.early_clocks != 0) {
    bits.append(true);
    bits.append_run(false, words.early_clocks - 1U);
  }
  bits.append(words.start);
  bits.append(words.cds);
  bits.append(words.cpw, frame.cpw_bits());
  bits.append(words.spw, frame.spw_bits());
  bits.append(words.stop);
  // The reader counts from the START that it finds, and sends as many clocks.
  if (!words.start) bits.append_run(false, frame.bits() + 2U);
  return bits;
}

}  // namespace

std::optional<CampaignFrame> CampaignFrame::make(const FrameFormat& format, SafetySetup setup) {
  if (format.channel_count != 2 || setup.cpw != 0 || setup.spw != 1) return std::nullopt;
  if (setup.counter.mode == CounterMode::learned) setup.counter.mode = CounterMode::count_1_63;
  if (check_safety(format, UnratedSafetySetup(setup))) return std::nullopt;
  if (format.channel_list[0].total_bits() > 64 || format.channel_list[1].total_bits() > 64 ||
      format.payload_bits() > 126) {
    return std::nullopt;
  }
  CampaignFrame frame(format, setup);
  if (!frame.prepare()) return std::nullopt;
  return frame;
}

CampaignFrame::CampaignFrame(const FrameFormat& format, const SafetySetup& setup)
    : plan_(std::make_shared<const Plan>(format, UnratedSafetySetup(setup))),
      cpw_columns_(columns_of(cpw_format())),
      spw_columns_(columns_of(spw_format())) {}

bool CampaignFrame::prepare() {
  const SafetySetup& setup = plan_->setup();
  const Picoseconds cycle = std::clamp(setup.cycle_min, setup.frame_gap_min, setup.frame_gap_max);
  Monitor tested(*plan_);
  if (!tested.self_test()) return false;
  ready_.assign(64, tested);
  due_ = cycle * setup.start_frames;
  const unsigned first = first_counter();
  const unsigned period = 64U - first;
  for (unsigned due = first; due < ready_.size(); ++due) {
    for (unsigned before = setup.start_frames; before > 0; --before) {
      SafetyFinding good;
      const unsigned turned = due - first + period * 5U - before;
      good.life_counter = static_cast<std::uint8_t>(first + turned % period);
      good.cause = SafetyVerdict::safe;
      ready_[due].step(OneClock{due_ - cycle * before}, good, good);
    }
  }
  return true;
}

SentFrame CampaignFrame::draw(std::uint64_t seed, std::uint64_t index) const {
  sim::Random random(seed ^ sim::scrambled(index));
  const std::uint64_t position = random.next() & low_mask(cpw_format().position_bits());
  const unsigned first = first_counter();
  return {position, static_cast<std::uint8_t>(first + random.below(64U - first))};
}

WordPair CampaignFrame::encode(const SentFrame& sent) const {
  const auto word = [this](std::size_t k, const Channel& values) {
    const ChannelFormat& format = plan_->format().channel_list[k];
    const std::uint64_t data = pack(format, values);
    return (data << format.crc.width_bits) | plan_->codec().crc(k, data, false);
  };
  Channel cpw{.position = sent.position};
  Channel spw{.position = spw_position(cpw_format(), spw_format(), sent.position),
              .life_counter = sent.life_counter};
  return {word(0, cpw), word(1, spw), false};
}

WordPair CampaignFrame::damage(const WordPair& words, const FaultChoice& fault, std::uint64_t seed,
                               std::uint64_t index) const {
  sim::Random random(~seed ^ sim::scrambled(index));
  const unsigned places = places_of(fault, bits());
  const auto drawn = static_cast<unsigned>(random.below(places));
  const unsigned place = fault.place.value_or(drawn);
  const LineWord line = (LineWord{words.cpw} << spw_bits() | words.spw) << 1U;
  const LineWord received = damaged(line, bits() + 1U, fault, place, random.next());
  const LineWord payload = received >> 1U;
  WordPair damaged_words{static_cast<std::uint64_t>(payload >> spw_bits()),
                         static_cast<std::uint64_t>(payload) & low_mask(spw_bits()),
                         (received & 1U) != 0};
  damaged_words.cds = fault.kind == FaultKind::cds_high;
  damaged_words.start = fault.kind != FaultKind::lost_start;
  if (fault.kind == FaultKind::false_start) {
    damaged_words.early_clocks = static_cast<std::uint8_t>(place + 1U);
  }
  return damaged_words;
}

std::optional<WordPair> CampaignFrame::read(const WordPair& received) const {
  if (received.start && received.early_clocks == 0) return received;
  const LineBits line = line_of(*this, received);
  const BitView view = line.view();
  const auto start = find_start(view, plan_->setup().bounds);
  if (!start.ok()) return std::nullopt;
  const std::size_t at = start->start_bit + 2U;
  return WordPair{.cpw = view.word(at, cpw_bits()),
                  .spw = view.word(at + cpw_bits(), spw_bits()),
                  .stop = view[at + bits()],
                  .cds = view[at - 1U]};
}

FrameOutcome CampaignFrame::judge(const SentFrame& sent, const WordPair& received) const {
  const WordPair words = encode(sent);
  const auto good = [this](std::size_t k, std::uint64_t word) {
    const CrcSpec& crc = format().channel_list[k].crc;
    return plan_->codec().crc(k, word >> crc.width_bits, false) == (word & crc.mask());
  };
  FrameOutcome outcome;
  const auto seen = read(received);
  if (!seen || received == words) return outcome;
  const bool cpw_good = good(0, seen->cpw);
  const bool spw_good = good(1, seen->spw);
  outcome.cpw = seen->cpw != words.cpw && cpw_good;
  outcome.spw = seen->spw != words.spw && spw_good;
  outcome.both = (outcome.cpw || outcome.spw) && cpw_good && spw_good;
  if (!cpw_good || !spw_good) return outcome;
  const SafetyJudgement judgement = monitor(sent, received);
  outcome.monitor = judgement.verdict == SafetyVerdict::safe;
  outcome.wrong = outcome.monitor && control_position(*plan_, *judgement.position) != sent.position;
  return outcome;
}

SafetyJudgement CampaignFrame::monitor(const SentFrame& sent, const WordPair& received) const {
  Monitor running = ready_[sent.life_counter];
  const LineBits bits = line_of(*this, received);
  return running.step(OneClock{due_}, bits.view());
}

}  // namespace biss::lab
