// Names and texts of the status codes and causes of the C interface, and its version.
#include <algorithm>
#include <array>

#include "biss/frame/status.hpp"
#include "capi/biss_c.h"

namespace {

struct StatusText {
  biss_status status;
  const char* name;
  const char* text;
};

constexpr std::array<StatusText, BISS_NO_CRC + 1> statuses{{
    {BISS_OK, "ok", "done"},
    {BISS_NULL_ARGUMENT, "null_argument", "a required pointer is null"},
    {BISS_NO_MEMORY, "no_memory", "no memory"},
    {BISS_BAD_FORMAT, "bad_format", "neither an encoder of the catalogue nor a frame format"},
    {BISS_BAD_TIMING, "bad_timing", "no device can have this timing"},
    {BISS_BAD_SETUP, "bad_setup", "a value of the setup is out of its range"},
    {BISS_TIME_RANGE, "time_range", "a time beyond BISS_TIME_MAX"},
    {BISS_TIME_BACKWARDS, "time_backwards", "a time before the last one"},
    {BISS_REENTERED, "reentered", "an object was called from its own callback"},
    {BISS_VALUE_RANGE, "value_range", "a position or counter is wider than its field"},
    {BISS_RUNNING, "running", "a request is running"},
    {BISS_SLO_LOW, "slo_low", "no request was made: SLO is low, the encoder is not ready"},
    {BISS_TOO_EARLY, "too_early", "no request was made: the last one is too recent"},
    {BISS_NO_READING, "no_reading", "there is no reading or frame"},
    {BISS_BAD_HANDLE, "bad_handle", "the object had no init, was moved, or is of another kind"},
    {BISS_CHANNEL_COUNT, "channel_count", "the format has a different number of channels"},
    {BISS_CLOCK_RANGE, "clock_range", "a number of clocks is out of its range"},
    {BISS_NO_ROOM, "no_room", "the buffer is too small"},
    {BISS_BAD_CRC, "bad_crc", "there is no such checksum"},
    {BISS_BIT_COUNT, "bit_count", "a number of bits is not 1 to 64"},
    {BISS_FAULT_RULE, "fault_rule",
     "a fault is not KIND:RATE with a rate of 0 to 1, nor KIND@CYCLE"},
    {BISS_FAULT_KIND, "fault_kind", "there is no such kind of fault, or it needs an encoder"},
    {BISS_FAULT_PLACE, "fault_place", "this fault cannot begin at this place"},
    {BISS_FAULT_TWICE, "fault_twice", "a kind of fault is given twice"},
    {BISS_NO_REGISTER, "no_register", "there is no such register"},
    {BISS_FILE, "file", "the file cannot be written"},
    {BISS_BAD_EDS, "bad_eds", "the data sheet does not describe the data channels"},
    {BISS_BAD_SAFETY, "bad_safety", "these frames cannot be monitored with this setup"},
    {BISS_CLOCK_MAX, "clock_max", "the clock is above the limit of the encoder"},
    {BISS_NO_ERROR_FLAG, "no_error_flag", "a position has no nE: set no_error_flag to read it"},
    {BISS_NO_CRC, "no_crc", "a channel has no checksum: set unchecked to read it"},
}};

// text_of() finds a row by its place: as many rows as codes, in ascending order.
static_assert(std::ranges::adjacent_find(statuses, std::ranges::greater_equal(),
                                         &StatusText::status) == statuses.end() &&
              statuses.back().status == BISS_NO_CRC);

// A caller may have any number in a biss_status or biss_cause; a negative one becomes a large index.
constexpr StatusText text_of(biss_status status) {
  const auto index = static_cast<unsigned>(status);
  return index < statuses.size() ? statuses[index]
                                 : StatusText{status, "unknown", "no such status"};
}

// The causes have the numbers of CycleStatus, and its names, which are literals.
static_assert(BISS_CAUSE_OK == static_cast<int>(biss::CycleStatus::ok) &&
              BISS_CAUSE_STOP_BIT == static_cast<int>(biss::CycleStatus::stop_bit));

}  // namespace

extern "C" {

const char* biss_version(void) { return BISS_C_VERSION; }

const char* biss_status_name(biss_status status) { return text_of(status).name; }

const char* biss_status_text(biss_status status) { return text_of(status).text; }

const char* biss_cause_name(biss_cause cause) {
  const auto index = static_cast<unsigned>(cause);
  return index <= BISS_CAUSE_STOP_BIT ? biss::cycle_status_names[index].data() : "unknown";
}

}  // extern "C"
