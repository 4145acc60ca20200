// biss_master: the core's RequestCycle.
#include <cstdint>

#include "biss/frame/codec.hpp"
#include "biss/master/request.hpp"
#include "capi/control.hpp"
#include "capi/device.hpp"
#include "capi/frame.hpp"

namespace biss::capi {

namespace {

using Request = RequestCycle<FrameCodec<>>;

constexpr std::int64_t period_min_ps = 32;

bool is_possible(const biss_master_setup& setup) {
  const std::int64_t half = setup.period_ps / 2;
  return are_durations({setup.period_ps, setup.low_time_ps, setup.sample_step_ps,
                        setup.line_delay_max_ps, setup.reset_time_ps, setup.idle_min_ps}) &&
         setup.period_ps >= period_min_ps && setup.low_time_ps < setup.period_ps &&
         setup.sample_shift_ps >= -half && setup.sample_shift_ps <= half && setup.slaves >= 1 &&
         setup.slaves <= max_channels && setup.extra_clocks <= UINT16_MAX;
}

MasterSetup from_c(const Described& device, const biss_master_setup& setup) {
  const bool limited = setup.line_delay_max_ps != 0;
  return {.period = picoseconds(setup.period_ps),
          .timing = device.timing,
          .slaves = static_cast<std::uint8_t>(setup.slaves),
          .compensate = setup.compensate,
          .extra_clocks = static_cast<std::uint16_t>(setup.extra_clocks),
          .low_time = picoseconds(setup.low_time_ps),
          .sample_step = picoseconds(setup.sample_step_ps),
          .sample_shift = picoseconds(setup.sample_shift_ps),
          .line_delay_max = limited ? picoseconds(setup.line_delay_max_ps) : biss_line_delay_max,
          .reset_time = picoseconds(setup.reset_time_ps),
          .trust_cycle_time = setup.trust_cycle_time,
          .idle_min = picoseconds(setup.idle_min_ps),
          .no_error_flag = setup.no_error_flag,
          .unchecked = setup.unchecked};
}

biss_status status_of(Refusal refusal) {
  if (refusal == Refusal::none) return BISS_OK;
  return refusal == Refusal::slo_low ? BISS_SLO_LOW : BISS_TOO_EARLY;
}

biss_reading reading_of(const Request::Reading& from) {
  biss_reading reading{};
  put_result(from.frame, reading);
  reading.begin_ps = from.begin.count;
  reading.line_delay_measured = from.line_delay.has_value();
  reading.line_delay_ps = from.line_delay.value_or(Picoseconds{}).count;
  reading.ack_clocks = from.ack_clocks;
  reading.clocks = from.clocks;
  reading.marginal = from.marginal;
  reading.ready = from.ready;
  return reading;
}

struct Master {
  Master(const Described& device, const biss_master_setup& setup)
      : request(FrameCodec<>(device.format), from_c(device, setup)), control(setup.control) {}

  // Once CDS is known, or known to be missing: CDM may depend on it.
  void answer_cds(Picoseconds now) {
    const auto cds = request.reading().cds;
    if (answered || control == nullptr || !(cds || request.done())) return;
    answered = true;
    auto bit = CdsBit::missing;
    if (!request.done()) bit = *cds ? CdsBit::one : CdsBit::zero;
    const bool cdm = step_control(control, now, bit);
    if (!request.done()) request.set_cdm(cdm);
  }

  Request request;
  Clock clock;
  biss_control* control;
  bool answered = true;  // the CDS of the request under way
  bool has_reading = false;
};

}  // namespace

extern "C" {

biss_master_setup biss_master_defaults(const biss_format* format, int64_t period_ps) {
  biss_master_setup setup{};
  setup.format = format;
  setup.period_ps = period_ps;
  setup.compensate = true;
  setup.slaves = 1;
  return setup;
}

biss_status biss_master_init(biss_master* master, const biss_master_setup* setup) {
  if (const auto wrong = begin_init(master, setup)) return wrong;
  Described device;
  if (const auto wrong = read(setup->format, device)) return wrong;
  if (device.format.needs_previous()) return BISS_BAD_FORMAT;
  if (!is_possible(*setup)) return BISS_BAD_SETUP;
  if (const auto refused = check_spi(device, {.period = picoseconds(setup->period_ps),
                                              .no_error_flag = setup->no_error_flag,
                                              .unchecked = setup->unchecked})) {
    return refused;
  }
  if (setup->control != nullptr && !is_open(setup->control)) return BISS_BAD_HANDLE;
  return make<Master>(master, device, *setup);
}

biss_status biss_master_begin(biss_master* master, int64_t now_ps, bool slo, bool cdm,
                              biss_output* out) {
  if (const auto wrong = check_call(master, out)) return wrong;
  auto& self = thing<Master>(master);
  if (const auto wrong = self.clock.check(now_ps)) return wrong;
  if (!self.request.done()) return BISS_RUNNING;
  self.clock.set(now_ps);
  const StepOutput output =
      self.request.begin(picoseconds(now_ps), slo, cdm && self.control == nullptr);
  self.has_reading = true;
  self.answered = self.request.done();
  *out = {output.level, output.deadline.count};
  return status_of(self.request.reading().refusal);
}

biss_status biss_master_step(biss_master* master, int64_t now_ps, bool slo, biss_output* out) {
  if (const auto wrong = check_call(master, out)) return wrong;
  auto& self = thing<Master>(master);
  if (const auto wrong = self.clock.check(now_ps)) return wrong;
  self.clock.set(now_ps);
  const StepOutput output = self.request.step(picoseconds(now_ps), slo);
  self.answer_cds(picoseconds(now_ps));
  *out = {output.level, output.deadline.count};
  return BISS_OK;
}

bool biss_master_done(const biss_master* master) {
  return !is_open(master) || thing<Master>(master).request.done();
}

biss_status biss_master_reading(const biss_master* master, biss_reading* reading) {
  if (const auto wrong = check_call(master, reading)) return wrong;
  auto& self = thing<Master>(master);
  if (!self.request.done()) return BISS_RUNNING;
  if (!self.has_reading) return BISS_NO_READING;
  *reading = reading_of(self.request.reading());
  return BISS_OK;
}

}  // extern "C"

}  // namespace biss::capi
