#include "simulators/encoder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "biss/timing/device_timing.hpp"
#include "device/quantity.hpp"

namespace biss::simulators {

namespace {

// Registers that no master may write: EDS_BANK to serial number, device and manufacturer ID.
bool is_fixed(std::uint8_t address) {
  return (address >= 0x41 && address <= 0x47) || address >= 0x78;
}

std::uint64_t chosen_position(const PositionChoice& choice, unsigned bits, std::uint64_t request,
                              sim::Random& random) {
  const std::uint64_t mask = low_mask(bits);
  switch (choice.kind) {
    case PositionKind::number:
      return choice.number & mask;
    case PositionKind::largest:
      return mask;
    case PositionKind::walk:
      return bits == 0 ? 0 : std::uint64_t{1} << (request % bits);
    case PositionKind::ramp:
      return request & mask;
    case PositionKind::random:
      return random.next() & mask;
  }
  return 0;
}

// The slots of a channel: its first bit, the first bit of its CRC, and the bit after its last one.
struct ChannelSlots {
  std::size_t begin = 2;
  std::size_t crc = 2;
  std::size_t end = 2;
};

ChannelSlots slots_of(const FrameFormat& format, std::size_t channel) {
  ChannelSlots slots;
  for (std::size_t k = 0; k <= channel; ++k) {
    slots.begin = slots.end;
    slots.end += format.channel_list[k].total_bits();
    slots.crc = slots.end - format.channel_list[k].crc.width_bits;
  }
  return slots;
}

constexpr std::string_view wrong_crc = "wrong CRC";
constexpr std::string_view wrong_burst = "burst";
constexpr std::string_view wrong_polarity = "polarity";
constexpr std::string_view jitter_early = "a tenth of a period early";
constexpr std::string_view jitter_late = "a tenth of a period late";

std::string wrong_bit_case(std::size_t channel, const ChannelSlots& slots, std::size_t slot) {
  if (slot < slots.crc) return fmt::format("channel {} data", channel);
  return fmt::format("channel {} CRC bit {}", channel, slots.end - 1 - slot);
}

void expect_wrong_crcs(Coverage& coverage, const FrameFormat& format) {
  if (!has_crcs(format)) return;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelSlots slots = slots_of(format, k);
    for (std::size_t slot = slots.crc - 1; slot < slots.end; ++slot) {
      coverage.expect(wrong_crc, wrong_bit_case(k, slots, slot));
    }
  }
  for (const std::string_view one : {wrong_burst, wrong_polarity}) coverage.expect(wrong_crc, one);
}

}  // namespace

Encoder::Encoder(std::string name, Settings settings)
    : Instance(Role::encoder, std::move(name), std::move(settings)),
      jitter_(this->settings().seed),
      registers_(this->settings().registers) {
  const Settings& chosen = this->settings();
  open_slave(in_turn(chosen.processing, 0));
  coverage().expect("format", chosen.format_text);
  coverage().expect_values(chosen.format);
  for (const Fault fault : {Fault::none, Fault::flip, Fault::no_answer, Fault::early_ack,
                            Fault::slo_low, Fault::cds_high, Fault::stop_high}) {
    coverage().expect("cause", biss_cause_name(cause_of(fault, chosen.format.cds0)));
  }
  expect_wrong_crcs(coverage(), chosen.format);
  for (const std::string_view one : {jitter_early, jitter_late}) coverage().expect("jitter", one);
  coverage().expect_line();
  coverage().expect_ack();
}

void Encoder::open_slave(Picoseconds processing) {
  if (biss_slave_state(&slave_) != nullptr && processing == processing_) return;
  biss_slave_setup setup = biss_slave_defaults(&settings().device);
  setup.ready_ps = processing.count;
  setup.user = this;
  setup.sample = &Encoder::sample;
  if (!settings().registers.empty()) {
    setup.register_permits = &Encoder::permits;
    setup.register_read = &Encoder::read_register;
    setup.register_write = &Encoder::write_register;
  }
  biss_slave_init(&slave_, &setup);  // the settings are valid
  processing_ = processing;
  output_ = {true, BISS_NEVER};
}

std::int64_t Encoder::step(std::int64_t now, bool ma) {
  now_ = std::max(now_, now);
  // MA is low from the start if the master has had no reset: this is not a request.
  live_ = live_ || ma;
  ma = ma || !live_;
  // One delay for all edges of a request, and the next one when the cable is empty.
  const bool begins = !ma && !running_ && ma_.due() == BISS_NEVER && ma_.received();
  if (begins) line_delay_ = next_line_delay();
  if (!ma_.put(now_, ma, (line_delay_ / 2).count) && !overloaded_) {
    overloaded_ = true;
    board().broken(requests(), now_, "MA", "pulses that a cable carries", "too many pulses");
  }
  for (std::int64_t due = deadline(); due <= now_; due = deadline()) advance(due);
  return deadline();
}

// If SLO falls a clock early and the line delay is a clock, SLO seems to fall in time.
Picoseconds Encoder::next_line_delay() const {
  if (in_turn(settings().faults, requests()) == Fault::early_ack) return {};
  return in_turn(settings().line_delays, requests());
}

std::int64_t Encoder::deadline() const {
  std::int64_t due = std::min({ma_.due(), slo_.due(), output_.deadline_ps});
  if (running_ && fault_ == Fault::no_answer) {
    due = std::min(due, last_edge_ + biss_static_timeout_max.count);
  }
  return due;
}

void Encoder::advance(std::int64_t now) {
  slo_.take(now);
  if (ma_.take(now)) take_edge(now, ma_.received());
  const bool hidden = running_ && fault_ == Fault::no_answer;
  const bool before = output_.level;
  const biss_status status =
      biss_slave_step(&slave_, now, hidden || ma_.received(), false, &output_);
  if (status != BISS_OK) {
    board().broken(requests(), now, "value", "a value that fits", biss_status_text(status));
  }
  const std::string_view state = biss_slave_state(&slave_);
  if (running_ && slot_ == before_start && clocks_ > 2 && output_.level && !before) {
    slot_ = 0;
    start_clock_ = clocks_;
  }
  if (running_ && state == "early_request" && !early_) {
    early_ = true;
    board().broken(outcome_.request, now, "request", "after the timeout", "before its end");
  }
  const bool silent = hidden && now - last_edge_ >= biss_static_timeout_max.count;
  if (running_ && (hidden ? silent : state == "idle" && ma_.received())) end_request(now);
  drive(now, faulty_level(output_.level));
}

void Encoder::drive(std::int64_t now, bool level) {
  if (level == driven_) return;
  driven_ = level;
  const auto jitter = static_cast<std::uint64_t>(settings().jitter.count);
  const auto late = static_cast<std::int64_t>(jitter_.below(jitter + 1));
  const std::int64_t than_first = late - first_late_.value_or(late);
  if (running_ && !first_late_) first_late_ = late;
  earliest_ = std::min(earliest_, than_first);
  latest_ = std::max(latest_, than_first);
  slo_.put(now, level, (line_delay_ - line_delay_ / 2).count + late);
  slo_.take(now);
}

void Encoder::take_edge(std::int64_t now, bool level) {
  // The encoder cannot see the end of a request that it ignored; the design's report counts as the
  // end.
  const bool next =
      reported_ && fault_ == Fault::no_answer && now - last_edge_ > longest_period_.count;
  if (running_ && !level && next) end_request(now);
  if (!running_ && !level) begin_request(now);
  if (!running_) return;
  measure_clock(now, level);
  last_edge_ = now;
  if (!level) return;
  ++clocks_;
  if (slot_ != before_start) ++slot_;
  if (slot_ == stop_slot()) deliver(now);
}

void Encoder::begin_request(std::int64_t now) {
  board().fail_waiting();
  open_slave(in_turn(settings().processing, requests()));
  running_ = true;
  delivered_ = early_ = reported_ = false;
  slot_ = before_start;
  first_late_.reset();
  earliest_ = latest_ = 0;
  clocks_ = start_clock_ = 0;
  shortest_period_ = longest_period_ = {};
  last_rise_ = 0;
  fault_ = in_turn(settings().faults, requests());
  // The cable was not empty.
  if (fault_ == Fault::early_ack && line_delay_.count != 0) fault_ = Fault::none;
  outcome_ = {};
  outcome_.request = requests();
  outcome_.time_ps = now;
  outcome_.cause = biss_cause_name(cause_of(fault_, settings().format.cds0));
  sim::Random random(sim::scrambled(settings().seed) + requests());
  choose_values(random);
  choose_damage(random);
}

// Every damage has the cause crc: a CRC detects a burst that is no longer than itself.
void Encoder::choose_damage(sim::Random& random) {
  const FrameFormat& format = settings().format;
  damaged_.assign(static_cast<std::size_t>(stop_slot()), false);
  damage_.clear();
  const bool walks = fault_ == Fault::flip_crc;
  const std::size_t turn = walks ? crc_flips_++ : random.below(format.channel_count);
  const std::size_t k = turn % format.channel_count;
  const ChannelSlots slots = slots_of(format, k);
  const std::size_t crc_bits = slots.end - slots.crc;
  if (fault_ == Fault::flip || walks) {
    const std::size_t slot = walks ? slots.crc + turn / format.channel_count % crc_bits
                                   : slots.begin + random.below(slots.end - slots.begin);
    damaged_[slot] = true;
    damage_ = wrong_bit_case(k, slots, slot);
  } else if (fault_ == Fault::burst) {
    const std::size_t length = 2 + random.below(crc_bits - 1);
    const std::size_t last =
        slots.begin + length - 1 + random.below(slots.end - slots.begin - length + 1);
    for (std::size_t back = 0; back < length; ++back) {
      damaged_[last - back] = back == 0 || back + 1 == length || random.below(2) != 0;
    }
    damage_ = wrong_burst;
  } else if (fault_ == Fault::crc_polarity) {
    for (std::size_t each = 0; each < format.channel_count; ++each) {
      const ChannelSlots of_each = slots_of(format, each);
      for (std::size_t slot = of_each.crc; slot < of_each.end; ++slot) damaged_[slot] = true;
    }
    damage_ = wrong_polarity;
  }
}

void Encoder::choose_values(sim::Random& random) {
  const FrameFormat& format = settings().format;
  const Flags flags = in_turn(settings().flags, requests());
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    biss_channel value{};
    value.position = chosen_position(in_turn(settings().positions, requests()),
                                     channel.position_bits(), requests(), random);
    value.nE = flags.nE;
    value.nW = flags.nW;
    if (next_[k]) value = *next_[k];
    next_[k].reset();
    // A sign of life: 1 to 63, as in BiSS Safety.
    const std::uint64_t counter = 1 + requests() % low_mask(safety_counter_bits);
    value.life_counter = static_cast<std::uint32_t>(counter & low_mask(channel.life_counter.bits));
    // A flag that is not on the line reads 1.
    value.nE = value.nE || !channel.error.present;
    value.nW = value.nW || !channel.warning.present;
    outcome_.values[k] = {value, true, true};
  }
}

void Encoder::measure_clock(std::int64_t now, bool level) {
  if (!level) return;
  if (clocks_ > 0) {
    const Picoseconds period{now - last_rise_};
    shortest_period_ = clocks_ == 1 ? period : std::min(shortest_period_, period);
    longest_period_ = std::max(longest_period_, period);
  }
  last_rise_ = now;
}

bool Encoder::faulty_level(bool level) const {
  if (!running_) return level;
  switch (fault_) {
    case Fault::none:
    case Fault::no_answer:
      return level;
    case Fault::flip:
    case Fault::flip_crc:
    case Fault::burst:
    case Fault::crc_polarity:
      return slot_ >= 0 && slot_ < stop_slot() && damaged_[static_cast<std::size_t>(slot_)] ? !level
                                                                                            : level;
    case Fault::early_ack:
      return clocks_ == 1 ? false : level;
    case Fault::slo_low:
      return clocks_ < 2 && level;
    case Fault::cds_high:
      return level || slot_ == 1;
    case Fault::stop_high:
      return level || slot_ == stop_slot();
  }
  return level;
}

void Encoder::deliver(std::int64_t now) {
  if (delivered_) return;
  delivered_ = true;
  board().sent(outcome_);
  check_clock(now);
  coverage().hit("format", settings().format_text);
  coverage().hit("cause", outcome_.cause);
  if (!damage_.empty()) coverage().hit(wrong_crc, damage_);
  const std::int64_t tenth = shortest_period_.count / 10;
  if (tenth > 0 && -earliest_ >= tenth) coverage().hit("jitter", jitter_early);
  if (tenth > 0 && latest_ >= tenth) coverage().hit("jitter", jitter_late);
  if (outcome_.cause != "ok") return;
  coverage().hit_values(settings().format, outcome_);
  coverage().hit_line(line_delay_, shortest_period_, settings().device.timing);
  coverage().hit_ack(start_clock_ - 2);
}

// One percent for the resolution of the simulation and of the design's divider.
void Encoder::check_clock(std::int64_t now) {
  if (clocks_ < 2) return;
  const Hertz fastest = rate_of(shortest_period_);
  const Hertz slowest = rate_of(longest_period_);
  const biss_timing& timing = settings().device.timing;
  const auto seen = [&](const char* limit, std::uint32_t rate, Hertz actual) {
    board().broken(outcome_.request, now, fmt::format("{} of MA", limit),
                   biss::text_of(hertz(rate)), biss::text_of(actual, 3));
  };
  if (std::uint64_t{fastest.count} * 100 > std::uint64_t{timing.clock_max_hz} * 101) {
    seen("highest clock", timing.clock_max_hz, fastest);
  }
  if (std::uint64_t{slowest.count} * 101 < std::uint64_t{timing.clock_min_hz} * 100) {
    seen("lowest clock", timing.clock_min_hz, slowest);
  }
}

bool Encoder::compare(const std::string& cause) {
  // A design may report before it has clocked STOP, and a fault may have no STOP.
  if (running_) deliver(now_);
  reported_ = true;
  return board().read(take_staged(requests(), now_, cause));
}

void Encoder::end_request(std::int64_t now) {
  running_ = false;
  const bool complete = fault_ == Fault::no_answer || fault_ == Fault::slo_low ||
                        fault_ == Fault::early_ack || slot_ >= stop_slot();
  if (!complete) {
    const int start = start_clock_ == 0 ? 3 : start_clock_;
    board().broken(outcome_.request, now, "clocks of MA",
                   fmt::format("{} or more", start + stop_slot()), fmt::format("{}", clocks_));
  }
  deliver(now);
  count_request();
}

bool Encoder::is_in_progress() const {
  if (!running_) return false;
  if (fault_ == Fault::no_answer) return now_ - last_edge_ < biss_static_timeout_max.count;
  return std::string_view(biss_slave_state(&slave_)) != "idle";
}

void Encoder::finish() {
  // The simulation may end within a request. One that hangs has had its timeout.
  if (is_in_progress()) {
    running_ = false;
    if (reported_) count_request();
    if (!reported_ && delivered_) board().withdraw(outcome_.request);
  }
  if (running_) end_request(now_);
  board().fail_waiting();
}

void Encoder::sample(void* user, std::int64_t /*moment*/, biss_channel* channels,
                     std::size_t count) {
  const auto& self = *static_cast<const Encoder*>(user);
  for (std::size_t k = 0; k < count; ++k) channels[k] = self.outcome_.values[k].channel;
}

bool Encoder::permits(void* user, bool write, std::uint8_t address) {
  const auto& self = *static_cast<const Encoder*>(user);
  return self.registers_.contains(address) && !(write && is_fixed(address));
}

int Encoder::read_register(void* user, std::uint8_t address) {
  const auto& self = *static_cast<const Encoder*>(user);
  const auto found = self.registers_.find(address);
  return found == self.registers_.end() ? 0 : found->second;
}

void Encoder::write_register(void* user, std::uint8_t address, std::uint8_t value) {
  static_cast<Encoder*>(user)->registers_[address] = value;
}

}  // namespace biss::simulators
