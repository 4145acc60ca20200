// biss_master: a handle of the core's RequestCycle.
#include <algorithm>
#include <cstdint>
#include <limits>

#include "biss/frame/codec.hpp"
#include "biss/master/request.hpp"
#include "capi/device.hpp"

namespace biss::capi {

namespace {

using Request = RequestCycle<FrameCodec<>>;

constexpr std::int64_t period_min_ps = 32;

bool is_possible(const biss_master_setup& setup) {
  for (const std::int64_t duration :
       {setup.period_ps, setup.low_time_ps, setup.sample_step_ps, setup.line_delay_max_ps,
        setup.reset_time_ps, setup.idle_min_ps}) {
    if (!is_duration(duration)) return false;
  }
  const std::int64_t half = setup.period_ps / 2;
  return setup.period_ps >= period_min_ps && setup.low_time_ps < setup.period_ps &&
         setup.sample_shift_ps >= -half && setup.sample_shift_ps <= half && setup.slaves >= 1 &&
         setup.slaves <= max_channels &&
         setup.extra_clocks <= std::numeric_limits<std::uint16_t>::max();
}

MasterSetup from_c(const Device& device, const biss_master_setup& setup) {
  MasterSetup result{.period = picoseconds(setup.period_ps),
                     .timing = device.timing,
                     .slaves = static_cast<std::uint8_t>(setup.slaves),
                     .compensate = setup.compensate,
                     .extra_clocks = static_cast<std::uint16_t>(setup.extra_clocks),
                     .low_time = picoseconds(setup.low_time_ps),
                     .sample_step = picoseconds(setup.sample_step_ps),
                     .sample_shift = picoseconds(setup.sample_shift_ps)};
  if (setup.line_delay_max_ps != 0) result.line_delay_max = picoseconds(setup.line_delay_max_ps);
  result.reset_time = picoseconds(setup.reset_time_ps);
  result.idle_min = picoseconds(setup.idle_min_ps);
  result.trust_cycle_time = setup.trust_cycle_time;
  return result;
}

biss_status status_of(Refusal refusal) {
  if (refusal == Refusal::none) return BISS_OK;
  return refusal == Refusal::slo_low ? BISS_SLO_LOW : BISS_TOO_EARLY;
}

biss_reading as_c(const Request::Reading& from) {
  biss_reading reading{};
  if (from.frame.ok()) {
    reading.channel_count = from.frame->channel_count;
    for (std::size_t k = 0; k < reading.channel_count; ++k) {
      const Channel& channel = from.frame->channel_list[k];
      reading.channels[k] = {channel.position, channel.life_counter, channel.nE, channel.nW};
    }
    reading.cds = from.frame->cds;
  } else {
    reading.cause = static_cast<biss_cause>(1 + static_cast<int>(from.frame.error().cause));
    reading.cause_channel = from.frame.error().channel;
  }
  reading.begin_ps = from.begin.count;
  reading.line_delay_measured = from.line_delay.has_value();
  reading.line_delay_ps = from.line_delay.value_or(Picoseconds{}).count;
  reading.ack_clocks = from.ack_clocks;
  reading.clocks = from.clocks;
  reading.marginal = from.marginal;
  reading.ready = from.ready;
  return reading;
}

}  // namespace

}  // namespace biss::capi

struct biss_master {
  biss_master(const biss::capi::Device& device, const biss_master_setup& setup)
      : request(biss::FrameCodec<>(device.format), biss::capi::from_c(device, setup)) {}

  biss::capi::Request request;
  biss::capi::Clock clock;
  bool has_reading = false;
};

extern "C" {

biss_master_setup biss_master_defaults(const char* format, int64_t period_ps) {
  biss_master_setup setup{};
  setup.format = format;
  setup.period_ps = period_ps;
  setup.compensate = true;
  setup.slaves = 1;
  return setup;
}

biss_status biss_master_open(const biss_master_setup* setup, biss_master** master) {
  if (master == nullptr) return BISS_NULL_ARGUMENT;
  *master = nullptr;
  if (setup == nullptr || setup->format == nullptr) return BISS_NULL_ARGUMENT;
  auto device = biss::capi::find_device(setup->format);
  if (!device) return BISS_BAD_FORMAT;
  if (!biss::capi::override_timing(setup->timing, *device)) return BISS_BAD_TIMING;
  if (!biss::capi::is_possible(*setup)) return BISS_BAD_SETUP;
  *master = biss::capi::make_handle<biss_master>(*device, *setup);
  return *master == nullptr ? BISS_NO_MEMORY : BISS_OK;
}

biss_status biss_master_begin(biss_master* master, int64_t now_ps, bool slo, bool cdm,
                              biss_output* out) {
  if (master == nullptr || out == nullptr) return BISS_NULL_ARGUMENT;
  if (const biss_status wrong = master->clock.check(now_ps); wrong != BISS_OK) return wrong;
  if (!master->request.done()) return BISS_RUNNING;
  master->clock.set(now_ps);
  const biss::StepOutput output = master->request.begin(biss::picoseconds(now_ps), slo, cdm);
  master->has_reading = true;
  *out = {output.level, output.deadline.count};
  return biss::capi::status_of(master->request.reading().refusal);
}

biss_status biss_master_step(biss_master* master, int64_t now_ps, bool slo, biss_output* out) {
  if (master == nullptr || out == nullptr) return BISS_NULL_ARGUMENT;
  if (const biss_status wrong = master->clock.check(now_ps); wrong != BISS_OK) return wrong;
  master->clock.set(now_ps);
  const biss::StepOutput output = master->request.step(biss::picoseconds(now_ps), slo);
  *out = {output.level, output.deadline.count};
  return BISS_OK;
}

bool biss_master_done(const biss_master* master) {
  return master == nullptr || master->request.done();
}

biss_status biss_master_reading(const biss_master* master, biss_reading* reading) {
  if (master == nullptr || reading == nullptr) return BISS_NULL_ARGUMENT;
  if (!master->request.done()) return BISS_RUNNING;
  if (!master->has_reading) return BISS_NO_READING;
  *reading = biss::capi::as_c(master->request.reading());
  return BISS_OK;
}

void biss_master_close(biss_master* master) { biss::capi::destroy_handle(master); }

}  // extern "C"
