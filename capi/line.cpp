// biss_line: the simulator's FarEnd, on the heap.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "biss/base/bits.hpp"
#include "capi/biss_c_sim.h"
#include "capi/device.hpp"
#include "sim/far_end.hpp"
#include "sim/fault_text.hpp"

namespace biss::capi {

namespace {

using sim::FarEndSetup;
using sim::FaultRule;

std::optional<sim::MotionKind> find_motion(const char* name) {
  const std::string_view wanted = name == nullptr ? "ramp" : name;
  const auto found = std::find(sim::motion_names.begin(), sim::motion_names.end(), wanted);
  if (found == sim::motion_names.end()) return std::nullopt;
  return static_cast<sim::MotionKind>(found - sim::motion_names.begin());
}

bool is_possible(const biss_line_setup& setup) {
  if (!are_durations({setup.interval_ps, setup.ma_delay_ps, setup.slo_delay_ps,
                      setup.internal_delay_ps, setup.ma_filter_ps, setup.ma_jitter_ps,
                      setup.slo_jitter_ps, setup.ready_min_ps, setup.ready_max_ps})) {
    return false;
  }
  const std::int64_t delay =
      setup.ma_delay_ps + setup.slo_delay_ps + setup.internal_delay_ps + setup.ma_filter_ps;
  constexpr std::uint32_t clock_max_hz = 100'000'000;
  return setup.clock_hz >= 1000 && setup.clock_hz <= clock_max_hz &&
         delay <= biss_line_delay_max.count && setup.ma_jitter_ps <= setup.ma_delay_ps &&
         setup.slo_jitter_ps <= setup.slo_delay_ps + setup.internal_delay_ps &&
         setup.ready_min_ps <= setup.ready_max_ps && setup.counter_first <= 1 &&
         setup.counter_start >= setup.counter_first && setup.counter_start <= 63 &&
         setup.register_busy_frames <= UINT16_MAX &&
         !(setup.foreign_encoder && (setup.registers || setup.position != nullptr)) &&
         find_motion(setup.motion);
}

// \pre is_possible()
FarEndSetup from_c(const biss_line_setup& setup, const Described& device) {
  FarEndSetup result;
  sim::LineSetup& line = result.line;
  line.format = device.format;
  line.timing = device.timing;
  line.clock = hertz(setup.clock_hz);
  line.interval = picoseconds(setup.interval_ps);
  line.ma_delay = picoseconds(setup.ma_delay_ps);
  line.slo_delay = picoseconds(setup.slo_delay_ps);
  line.internal_delay = picoseconds(setup.internal_delay_ps);
  line.ma_jitter = picoseconds(setup.ma_jitter_ps);
  line.slo_jitter = picoseconds(setup.slo_jitter_ps);
  line.processing = picoseconds(setup.ready_min_ps);
  line.motion = *find_motion(setup.motion);
  line.life.first = static_cast<std::uint8_t>(setup.counter_first);
  line.life.starts = sim::SignOfLife::all_from(static_cast<std::uint8_t>(setup.counter_start));
  line.seed = setup.seed;
  if (setup.registers) {
    line.registers.resize(1);
    const auto frames = static_cast<std::uint16_t>(setup.register_busy_frames);
    line.registers[0].set_busy({frames, frames});
  }
  result.processing_max = picoseconds(setup.ready_max_ps);
  result.ma_filter = picoseconds(setup.ma_filter_ps);
  result.foreign_encoder = setup.foreign_encoder;
  return result;
}

// The setup of the far end, or the problem of a setup and the place of its rule.
struct Checked {
  FarEndSetup far;
  biss_status status = BISS_OK;
  std::size_t wrong_at = 0;

  // The first problem counts.
  void refuse(biss_status cause, std::size_t at = 0) {
    if (status != BISS_OK) return;
    status = cause;
    wrong_at = at;
  }
};

void read_rules(std::string_view text, bool foreign_encoder, Checked& checked) {
  constexpr std::string_view white_space = " \t\r\n";
  std::vector<FaultRule>& rules = checked.far.line.faults;
  std::vector<std::size_t> begins;
  for (std::size_t at = text.find_first_not_of(white_space); at < text.size();
       at = text.find_first_not_of(white_space, at)) {
    const std::size_t end = std::min(text.find_first_of(white_space, at), text.size());
    const auto rule = sim::parse_fault(text.substr(at, end - at));
    if (!rule) {
      const bool bad_kind = rule.error() == sim::FaultTextError::kind;
      return checked.refuse(bad_kind ? BISS_FAULT_KIND : BISS_FAULT_RULE, at);
    }
    if ((foreign_encoder && sim::needs_encoder(rule->kind)) || !sim::is_simulated(rule->kind)) {
      checked.refuse(BISS_FAULT_KIND, at);
    }
    if (std::any_of(rules.begin(), rules.end(), [&](const FaultRule& other) {
          return other.kind == rule->kind && other.cycle == rule->cycle;
        })) {
      checked.refuse(BISS_FAULT_TWICE, at);
    }
    rules.push_back(*rule);
    begins.push_back(at);
    at = end;
  }
  if (checked.status != BISS_OK) return;
  const sim::NominalCycle nominal = sim::FarEnd::nominal_of(checked.far);
  for (std::size_t k = 0; k < rules.size(); ++k) {
    const auto& place = rules[k].place;
    if (place && !sim::places_of(rules[k].kind, place->unit, nominal).contains(*place)) {
      checked.refuse(BISS_FAULT_PLACE, begins[k]);
    }
  }
}

Checked check(const biss_line_setup* setup) {
  if (setup == nullptr) return {{}, BISS_NULL_ARGUMENT};
  Described device;
  if (const auto wrong = read(setup->format, device)) return {{}, wrong};
  if (!is_possible(*setup) || (setup->registers && device.format.cds0)) {
    return {{}, BISS_BAD_SETUP};
  }
  Checked checked{from_c(*setup, device)};
  read_rules(setup->faults == nullptr ? "" : setup->faults, setup->foreign_encoder, checked);
  return checked;
}

unsigned position_bits_of(const FrameFormat& format) {
  for (const ChannelFormat& channel : format.channels()) {
    if (channel.position_bits() != 0) return channel.position_bits();
  }
  return 0;
}

struct Line {
  Line(const sim::FarEndSetup& setup, const biss_line_setup& from)
      : far(setup), chosen(from), position_mask(low_mask(position_bits_of(setup.line.format))) {
    if (from.position != nullptr) far.encoder().set_positions(&ask, this);
  }

  static std::optional<std::uint64_t> ask(void* self, Picoseconds moment) {
    auto& line = *static_cast<Line*>(self);
    const std::uint64_t position = line.chosen.position(line.chosen.user, moment.count);
    if ((position & ~line.position_mask) == 0) return position;
    line.value_range = true;
    return std::nullopt;
  }

  sim::FarEnd far;
  Clock clock;
  biss_line_setup chosen;
  std::uint64_t position_mask;
  bool stepping = false;
  bool broken = false;
  bool value_range = false;
};

template <class... Pointers>
biss_status usable(const biss_line* line, const Pointers*... needed) {
  const biss_status wrong = check_call(line, needed...);
  return wrong == BISS_OK && thing<Line*>(line)->stepping ? BISS_REENTERED : wrong;
}

void put(sim::EncoderRegisters& registers, std::uint32_t bank, std::uint32_t address,
         std::uint8_t value, bool writable) {
  const auto protection = writable ? RegisterProtection::read_write : RegisterProtection::read_only;
  if (address == reg::bsel) {
    registers.put_bsel(value);
  } else if (address > reg::bsel) {
    registers.put(address, value, protection);
  } else {
    registers.bank(bank).put(address, {&value, 1}, protection);
  }
}

// The same as usable(), and whether the line has this register.
template <class... Pointers>
biss_status has_register(const biss_line* line, std::uint32_t bank, std::uint32_t address,
                         const Pointers*... needed) {
  if (const auto wrong = usable(line, needed...)) return wrong;
  const bool exists = address < bank_bytes ? bank < bank_count : address < register_count;
  return exists && thing<Line*>(line)->chosen.registers ? BISS_OK : BISS_NO_REGISTER;
}

biss_line_request request_of(const sim::FarEndCycle& cycle) {
  biss_line_request request{};
  request.number = cycle.number;
  request.begin_ps = cycle.begin.count;
  request.sampled = cycle.sampled.has_value();
  request.sampled_ps = cycle.sampled.value_or(Picoseconds{}).count;
  for (biss_channel& channel : request.channels) channel.nE = channel.nW = true;
  request.channel_count = put_channels(cycle.sent, request.channels);
  request.faults = cycle.faults;
  request.place_count = static_cast<std::uint32_t>(cycle.injected.size());
  const std::size_t shown = std::min(cycle.injected.size(), std::size(request.places));
  for (std::size_t k = 0; k < shown; ++k) {
    const sim::InjectedFault& fault = cycle.injected[k];
    request.places[k] = {static_cast<std::uint32_t>(fault.kind),
                         fault.place.unit == sim::PlaceUnit::bit, fault.place.thousandths};
  }
  request.late_ps = cycle.lateness.count;
  return request;
}

}  // namespace

extern "C" {

size_t biss_fault_count(void) { return sim::simulated_fault_count; }

const char* biss_fault_name(size_t kind) {
  return kind < biss_fault_count() ? sim::fault_list[kind].name.data() : nullptr;
}

const char* biss_fault_effect(size_t kind) {
  return kind < biss_fault_count() ? sim::fault_list[kind].effect.data() : nullptr;
}

biss_line_setup biss_line_defaults(const biss_format* format, uint32_t clock_hz) {
  biss_line_setup setup{};
  setup.format = format;
  setup.clock_hz = clock_hz;
  setup.counter_first = setup.counter_start = 1;
  setup.seed = 1;
  return setup;
}

biss_status biss_line_init(biss_line* line, const biss_line_setup* setup) {
  if (const auto wrong = begin_init(line)) return wrong;
  try {
    const auto checked = check(setup);
    if (checked.status != BISS_OK) return checked.status;
    return make<Line*>(line, new Line(checked.far, *setup));
  } catch (const std::exception&) {
    return BISS_NO_MEMORY;
  }
}

size_t biss_line_fault_at(const biss_line_setup* setup) {
  try {
    return check(setup).wrong_at;
  } catch (const std::exception&) {
    return 0;
  }
}

biss_status biss_line_step(biss_line* line, int64_t now_ps, bool ma, bool encoder_slo,
                           biss_line_output* out) {
  if (const auto wrong = usable(line, out)) return wrong;
  auto& self = *thing<Line*>(line);
  if (const auto wrong = self.clock.check(now_ps)) return wrong;
  if (self.broken) return BISS_NO_MEMORY;
  self.clock.set(now_ps);
  self.stepping = true;
  try {
    const auto output = self.far.step(picoseconds(now_ps), ma, encoder_slo);
    *out = {output.slo, output.ma, output.deadline.count};
  } catch (const std::exception&) {
    self.broken = true;
  }
  self.stepping = false;
  if (self.broken) return BISS_NO_MEMORY;
  return std::exchange(self.value_range, false) ? BISS_VALUE_RANGE : BISS_OK;
}

biss_status biss_line_set_flags(biss_line* line, bool nE, bool nW) {
  if (const auto wrong = usable(line)) return wrong;
  thing<Line*>(line)->far.set_flags(nE, nW);
  return BISS_OK;
}

biss_status biss_line_request_of(const biss_line* line, biss_line_request* request) {
  if (const auto wrong = usable(line, request)) return wrong;
  const sim::FarEndCycle* cycle = thing<Line*>(line)->far.cycle();
  if (cycle == nullptr) return BISS_NO_READING;
  *request = request_of(*cycle);
  return BISS_OK;
}

biss_status biss_line_put_register(biss_line* line, uint32_t bank, uint32_t address, uint8_t value,
                                   bool writable) {
  if (const auto wrong = has_register(line, bank, address)) return wrong;
  auto& far = thing<Line*>(line)->far;
  put(far.registers(), bank, address, value, writable);
  put(far.initial_registers(), bank, address, value, writable);
  return BISS_OK;
}

biss_status biss_line_register(biss_line* line, uint32_t bank, uint32_t address, uint8_t* value) {
  if (const auto wrong = has_register(line, bank, address, value)) return wrong;
  auto& registers = thing<Line*>(line)->far.registers();
  if (address < bank_bytes) {
    *value = registers.bank(bank)[address];
  } else {
    *value = address == reg::bsel ? registers.bsel() : registers.value(address);
  }
  return BISS_OK;
}

const char* biss_line_state(const biss_line* line) {
  const bool shown = is_open(line) && !thing<Line*>(line)->chosen.foreign_encoder;
  return shown ? name_of(thing<Line*>(line)->far.state()).data() : nullptr;
}

void biss_line_close(biss_line* line) {
  if (!is_open(line)) return;
  delete thing<Line*>(line);
  line->mark = 0;
}

}  // extern "C"

}  // namespace biss::capi
