// biss_axis: the core's EncoderAxis with one channel.
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/axis/encoder_axis.hpp"
#include "capi/biss_c_axis.h"
#include "capi/device.hpp"
#include "capi/frame.hpp"
#include "capi/object.hpp"

namespace biss::capi {

namespace {

static_assert(BISS_AXIS_UNEXPECTED + 1 == axis_cause_count);
static_assert(BISS_AXIS_STOPPED == static_cast<int>(AxisState::tripped));
static_assert(BISS_BAD_TRIP == static_cast<int>(BadCycleRule::trip));
static_assert(BISS_WARNING_TRIP == static_cast<int>(WarningRule::trip));
static_assert(BISS_NO_STEP_LIMIT == no_step_limit);

struct StartCall {
  bool (*call)(void* user, std::uint8_t* bytes, std::size_t count);
  void* user;

  bool start(std::span<std::uint8_t> receive) const {
    return call(user, receive.data(), receive.size());
  }
};

struct CAxis {
  CAxis(const biss_axis_setup& from, const AxisSetup& chosen)
      : spi{from.start, from.user}, setup(chosen), axis(spi, thing<Spi>(from.spi).reader, setup) {}

  StartCall spi;
  AxisSetup setup;
  EncoderAxis<StartCall, SpiReader<FrameCodec<>>, BISS_AXIS_BYTES> axis;
};

bool is_possible(const biss_axis_setup& setup) {
  return setup.bad_cycles >= BISS_BAD_HOLD && setup.bad_cycles <= BISS_BAD_TRIP &&
         setup.warnings >= BISS_WARNING_MEASURE && setup.warnings <= BISS_WARNING_TRIP &&
         setup.trip_after <= UINT16_MAX && setup.power_up_ps >= 0;
}

biss_status status_of(AxisError error) {
  switch (error) {
    case AxisError::buffer:
      return BISS_NO_ROOM;
    case AxisError::format:
      return BISS_BAD_FORMAT;
    default:
      return BISS_BAD_SETUP;
  }
}

}  // namespace

extern "C" {

const char* biss_axis_cause_name(biss_axis_cause cause) {
  const auto index = static_cast<std::size_t>(cause);
  return index < axis_cause_count ? name_of(static_cast<AxisCause>(index)).data() : "unknown";
}

biss_axis_setup biss_axis_defaults(const biss_spi* spi, int64_t cycle_ps, int64_t max_step) {
  const AxisSetup defaults;
  biss_axis_setup setup{};
  setup.spi = spi;
  setup.cycle_ps = cycle_ps;
  setup.max_step = max_step;
  setup.bad_cycles = BISS_BAD_EXTRAPOLATE;
  setup.trip_after = defaults.trip_after;
  setup.power_up_ps = defaults.power_up.count;
  return setup;
}

biss_status biss_axis_init(biss_axis* axis, const biss_axis_setup* setup) {
  if (const auto wrong = begin_init(axis, setup)) return wrong;
  if (setup->spi == nullptr || setup->start == nullptr) return BISS_NULL_ARGUMENT;
  if (!is_open(setup->spi)) return BISS_BAD_HANDLE;
  if (!is_possible(*setup)) return BISS_BAD_SETUP;
  const AxisSetup chosen{.cycle = picoseconds(setup->cycle_ps),
                         .to_sampling = thing<Spi>(setup->spi).to_sampling,
                         .max_step = setup->max_step,
                         .bad_cycles = static_cast<BadCycleRule>(setup->bad_cycles),
                         .warnings = static_cast<WarningRule>(setup->warnings),
                         .trip_after = static_cast<std::uint16_t>(setup->trip_after),
                         .power_up = picoseconds(setup->power_up_ps),
                         .reversed = setup->reversed,
                         .offset = setup->offset};
  const biss_status made = make<CAxis>(axis, *setup, chosen);
  const auto error = thing<CAxis>(axis).axis.error();
  if (!error) return made;
  axis->mark = 0;
  return status_of(*error);
}

biss_status biss_axis_request(biss_axis* axis, int64_t now_ps) {
  return with<CAxis>(axis, [now_ps](auto& of) { of.axis.request(picoseconds(now_ps)); });
}

biss_status biss_axis_complete(biss_axis* axis) {
  return with<CAxis>(axis, [](auto& of) { of.axis.transfer_complete(); });
}

biss_status biss_axis_failed(biss_axis* axis) {
  return with<CAxis>(axis, [](auto& of) { of.axis.transfer_failed(); });
}

biss_status biss_axis_get(const biss_axis* axis, biss_axis_position* position) {
  if (const auto wrong = check_call(axis, position)) return wrong;
  const AxisPosition now = thing<CAxis>(axis).axis.position();
  *position = {now.position,
               now.uncertainty,
               now.step,
               now.moment.count,
               now.number,
               now.bad_in_a_row,
               static_cast<biss_axis_state>(now.state),
               static_cast<biss_axis_cause>(now.cause),
               now.usable()};
  return BISS_OK;
}

uint32_t biss_axis_count(const biss_axis* axis, biss_axis_cause cause) {
  const bool known = is_open(axis) && cause >= 0 && cause <= BISS_AXIS_UNEXPECTED;
  return known ? thing<CAxis>(axis).axis.axis().counts()[static_cast<AxisCause>(cause)] : 0;
}

biss_status biss_axis_reset(biss_axis* axis) {
  return with<CAxis>(axis, [](auto& of) { of.axis.reset(); });
}

biss_status biss_axis_trip(biss_axis* axis) {
  return with<CAxis>(axis, [](auto& of) { of.axis.axis().trip(); });
}

biss_status biss_axis_set_turns(biss_axis* axis, int64_t turns) {
  if (const auto wrong = check_call(axis)) return wrong;
  Axis& of = thing<CAxis>(axis).axis.axis();
  if (of.state() == AxisState::no_position) return BISS_NO_READING;
  return of.set_turns(turns) ? BISS_OK : BISS_VALUE_RANGE;
}

}  // extern "C"

}  // namespace biss::capi
