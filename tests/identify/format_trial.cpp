#include "tests/identify/format_trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>

#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"
#include "decode/decoder.hpp"
#include "identify/collector.hpp"
#include "sim/line.hpp"
#include "sim/random.hpp"

namespace biss::trial {

namespace {

using identify::Sample;
using sim::FaultKind;

// The text of a random format.
class RandomFormat {
 public:
  explicit RandomFormat(sim::Random& random) : random_(random) {}

  std::string text() {
    std::string all = channel();
    if (one_of(6)) all += "+" + channel();
    return all;
  }

 private:
  bool one_of(std::uint64_t count) { return random_.below(count) == 0; }
  unsigned from(unsigned least, unsigned most) {
    return least + static_cast<unsigned>(random_.below(most - least + 1));
  }
  void add(const std::string& item, unsigned bits) {
    text_ += (text_.empty() ? "" : ",") + item;
    room_ -= bits;
  }

  std::string channel() {
    text_.clear();
    room_ = max_data_bits;
    const bool flags_first = one_of(8);
    if (flags_first) add_flags(0);
    if (one_of(8)) add_padding();
    const bool counter = one_of(4);
    const bool counter_first = counter && one_of(4);
    if (counter_first) add_counter();
    add_position();
    if (one_of(10)) add_padding();
    if (!flags_first) add_flags(from(0, 9));
    if (counter && !counter_first) add_counter();
    add(checksum(), 0);
    return text_;
  }

  void add_padding() {
    const unsigned bits = from(1, 4);
    add(fmt::format("pad{}", bits), bits);
  }
  void add_counter() {
    const unsigned bits = one_of(2) ? safety_counter_bits : from(3, 10);
    add(fmt::format("lc{}", bits), bits);
  }
  void add_flags(unsigned kind) {
    if (kind == 9) return;
    add(kind == 8 ? "E" : "nE", 1);
    if (kind != 7) add(kind == 8 ? "W" : "nW", 1);
  }

  // At least 8 bits, and room for padding, flags and a counter after it.
  void add_position() {
    const unsigned most = room_ - 18;
    if (one_of(3)) {
      const unsigned turns = from(1, 16);
      const unsigned turn = from(8, std::min(27U, most - turns));
      add(fmt::format("mt{},st{}{}", turns, turn, one_of(6) ? ":gray" : ""), turns + turn);
    } else if (one_of(5)) {
      const unsigned turn = from(8, 32);
      add(fmt::format("st{}{}", turn, one_of(2) ? ":gray" : ""), turn);
    } else {
      const unsigned bits = from(8, most);
      add(fmt::format("pos{}", bits), bits);
    }
  }

  std::string checksum() {
    constexpr std::array<unsigned, 7> usual{3, 4, 5, 6, 7, 8, 16};
    if (one_of(3)) return fmt::format("crc{}", one_of(2) ? 6 : usual[random_.below(usual.size())]);
    const unsigned width = from(min_crc_bits, max_crc_bits);
    const std::uint32_t top = 1U << width;
    const std::uint32_t polynomial =
        top | 1U | (static_cast<std::uint32_t>(random_.next()) & (top - 1));
    const std::string start =
        one_of(3) ? fmt::format(":0x{:X}", static_cast<std::uint32_t>(random_.next()) & (top - 1))
                  : "";
    return fmt::format("crc{}:0x{:X}{}{}", width, polynomial, start, one_of(4) ? ":plain" : "");
  }

  sim::Random& random_;
  std::string text_;
  unsigned room_ = 0;
};

sim::LineSetup line_of(const FrameFormat& format, sim::Random& random) {
  sim::LineSetup setup;
  setup.format = format;
  setup.clock = kilohertz(500 + static_cast<std::uint32_t>(random.below(9'500)));
  setup.ma_delay = nanoseconds(static_cast<std::int64_t>(random.below(300)));
  setup.slo_delay = nanoseconds(static_cast<std::int64_t>(random.below(300)));
  setup.processing = nanoseconds(static_cast<std::int64_t>(random.below(5'000)));
  setup.timing.timeout = {TimeoutRule::adaptive, {}};
  setup.life.first = random.below(2) == 0 ? 0 : 1;
  setup.life.starts.fill(static_cast<std::uint8_t>(1 + random.below(63)));
  setup.seed = random.next();
  return setup;
}

// Each fault of the line, and flags.
void add_faults(sim::LineSetup& setup, double damage) {
  constexpr std::array kinds{FaultKind::flip,       FaultKind::flip,       FaultKind::burst,
                             FaultKind::glitch_slo, FaultKind::lost_clock, FaultKind::extra_clock,
                             FaultKind::no_answer,  FaultKind::nE,         FaultKind::nW,
                             FaultKind::slo_high,   FaultKind::brown_out};
  const double each = damage / static_cast<double>(kinds.size()) * 4294967296.0;
  for (const FaultKind kind : kinds) {
    const auto same =
        std::find_if(setup.faults.begin(), setup.faults.end(),
                     [kind](const sim::FaultRule& rule) { return rule.kind == kind; });
    if (same != setup.faults.end()) {
      same->share += static_cast<std::uint64_t>(each);
    } else {
      setup.faults.push_back({.kind = kind, .share = static_cast<std::uint64_t>(each)});
    }
  }
}

// ---- The comparison

std::uint64_t mask_of(const Field& field) { return low_mask(field.bits) << field.shift; }
std::uint64_t mask_of(const FlagField& flag) {
  return flag.present ? std::uint64_t{1} << flag.shift : 0;
}
std::uint64_t position_of(const ChannelFormat& channel) {
  return mask_of(channel.position) | mask_of(channel.multiturn) | mask_of(channel.singleturn);
}

// The data of each channel of a frame; nothing where a checksum is wrong or bits are missing.
struct Checked {
  bool whole = false;
  bool right = false;
  std::array<std::uint64_t, max_channels> data{};
};

Checked check(const FrameFormat& format, const FrameCodec<>& codec, const Sample& sample) {
  Checked checked;
  if (sample.bits.size_bits() < format.payload_bits()) return checked;
  checked.whole = true;
  checked.right = true;
  std::size_t at = 0;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    checked.data[k] = sample.bits.view().word(at, channel.data_bits);
    at += channel.data_bits;
    if (channel.crc.present()) {
      checked.right = checked.right && sample.bits.view().word(at, channel.crc.width_bits) ==
                                           codec.crc(k, checked.data[k], false);
    }
    at += channel.crc.width_bits;
  }
  return checked;
}

std::string mistake_in(const ChannelFormat& truth, const ChannelFormat& found,
                       std::uint64_t moved) {
  if ((position_of(truth) & moved) != (position_of(found) & moved)) return "position";
  if ((mask_of(truth.life_counter) & moved) != (mask_of(found.life_counter) & moved)) {
    return "sign of life";
  }
  const auto flag_differs = [moved](const FlagField& a, const FlagField& b) {
    const bool has_moved = ((mask_of(a) | mask_of(b)) & moved) != 0;
    return has_moved && !(a == b);
  };
  if (flag_differs(truth.error, found.error)) return "error flag";
  if (flag_differs(truth.warning, found.warning)) return "warning flag";
  return "";
}

// Which bits of each channel moved in the frames that were sent without a fault.
class Motions {
 public:
  explicit Motions(const FrameFormat& format) : format_(format) {}

  void add(const sim::SimulatedCycle& cycle) {
    constexpr sim::FaultSet harmless = sim::set_of(FaultKind::nE) | sim::set_of(FaultKind::nW);
    if ((cycle.faults & ~harmless) != 0) return;
    for (std::size_t k = 0; k < format_.channel_count; ++k) {
      const std::uint64_t data = pack(format_.channel_list[k], cycle.sent.channel_list[k]);
      if (!seen_) first_[k] = data;
      moved_[k] |= data ^ first_[k];
    }
    seen_ = true;
  }
  std::uint64_t of(std::size_t channel) const { return moved_[channel]; }

 private:
  const FrameFormat& format_;
  bool seen_ = false;
  std::array<std::uint64_t, max_channels> first_{};
  std::array<std::uint64_t, max_channels> moved_{};
};

void compare(const FrameFormat& truth, std::span<const Sample> samples, const Motions& motions,
             TrialResult& result) {
  const FrameFormat& found = result.finding.candidates.front().format;
  if (found.channel_count != truth.channel_count) {
    result.mistake = "channels";
    return;
  }
  for (std::size_t k = 0; k < truth.channel_count; ++k) {
    if (truth.channel_list[k].data_bits != found.channel_list[k].data_bits ||
        truth.channel_list[k].crc.width_bits != found.channel_list[k].crc.width_bits) {
      result.mistake = "checksum place";
      return;
    }
  }
  const FrameCodec<> truth_codec(truth);
  const FrameCodec<> found_codec(found);
  std::array<std::uint64_t, max_channels> moved{};
  std::optional<Checked> first;
  for (const Sample& sample : samples) {
    const Checked right = check(truth, truth_codec, sample);
    if (right.right != check(found, found_codec, sample).right) {
      result.mistake = "verdict of the checksum";
      return;
    }
    if (!right.right) continue;
    if (!first) first = right;
    for (std::size_t k = 0; k < truth.channel_count; ++k) {
      moved[k] |= (right.data[k] ^ first->data[k]) & motions.of(k);
    }
  }
  for (std::size_t k = 0; k < truth.channel_count && result.mistake.empty(); ++k) {
    const ChannelFormat& channel = truth.channel_list[k];
    result.mistake = mistake_in(channel, found.channel_list[k], moved[k]);
    const bool position_moved = (position_of(channel) & moved[k]) != 0;
    result.other_coding =
        result.other_coding || (position_moved && channel.coded() != found.channel_list[k].coded());
  }
  result.moved =
      static_cast<unsigned>(std::popcount(position_of(truth.channel_list[0]) & moved[0]));
}

}  // namespace

FormatTrial random_trial(std::uint64_t number) {
  sim::Random random(number);
  FormatTrial trial;
  trial.text = RandomFormat(random).text();
  trial.setup = line_of(parse_format(trial.text).value(), random);
  trial.cycles = 20 + static_cast<unsigned>(random.below(381));
  trial.damage = random.below(3) == 0 ? 0 : static_cast<double>(random.below(1001)) / 10'000;
  trial.setup.motion = static_cast<sim::MotionKind>(random.below(sim::motion_names.size()));
  if (trial.damage > 0) add_faults(trial.setup, trial.damage);
  return trial;
}

FormatTrial trial_of(const FrameFormat& format, sim::MotionKind motion, unsigned cycles,
                     std::uint64_t number) {
  sim::Random random(number);
  FormatTrial trial;
  trial.text = std::string(format_text(format).view());
  trial.setup = line_of(format, random);
  trial.cycles = cycles;
  trial.setup.motion = motion;
  return trial;
}

TrialResult run(const FormatTrial& trial) {
  sim::Line line(trial.setup);
  identify::SampleCollector collector;
  std::uint64_t number = 0;
  decode::Decoder decoder(decode::CycleReader(std::nullopt, {}),
                          [&](const decode::Cycle& cycle) { collector.add(number++, cycle); });
  Motions motions(trial.setup.format);
  for (unsigned i = 0; i < trial.cycles; ++i) {
    const sim::SimulatedCycle& cycle = line.next();
    motions.add(cycle);
    decoder.push(cycle.edges, {.ma = sim::ma_line, .slo = sim::slo_line});
  }
  decoder.finish(line.end());
  TrialResult result;
  result.finding = identify::find_format(collector.samples());
  result.sure = result.finding.sure() != nullptr;
  if (result.finding.candidates.empty()) {
    result.mistake = "nothing";
  } else {
    compare(trial.setup.format, collector.samples(), motions, result);
  }
  return result;
}

}  // namespace biss::trial
