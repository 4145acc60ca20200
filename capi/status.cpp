// Names and texts of the codes.
#include <array>
#include <cstddef>
#include <string_view>

#include "biss/frame/frame.hpp"
#include "capi/biss_c.h"

namespace {

struct StatusText {
  const char* name;
  const char* text;
};

constexpr std::array<StatusText, BISS_NO_CRC + 1> statuses{{
    {"ok", "done"},
    {"null_argument", "a required pointer is null"},
    {"no_memory", "no memory for the handle"},
    {"bad_format", "neither an encoder of the catalogue nor a frame format"},
    {"bad_timing", "no device can have this timing"},
    {"bad_setup", "a value of the setup is out of its range"},
    {"time_range", "a time beyond BISS_TIME_MAX"},
    {"time_backwards", "a time before the last one"},
    {"reentered", "a handle was called from its own callback"},
    {"value_range", "a position or counter is wider than its field"},
    {"running", "a request is running"},
    {"slo_low", "no request was made: SLO is low, the encoder is not ready"},
    {"too_early", "no request was made: the last one is too recent"},
    {"no_reading", "there is no reading or frame"},
    {"bad_handle", "the handle is closed, or of another kind"},
    {"channel_count", "the format has a different number of channels"},
    {"clock_range", "a number of clocks is out of its range"},
    {"no_room", "the buffer is too small"},
    {"bad_crc", "there is no such checksum"},
    {"bit_count", "a number of bits is not 1 to 64"},
    {"fault_rule", "a fault is not KIND:RATE with a rate of 0 to 1, nor KIND@CYCLE"},
    {"fault_kind", "there is no such kind of fault, or it needs an encoder"},
    {"fault_place", "this fault cannot begin at this place"},
    {"fault_twice", "a kind of fault is given twice"},
    {"no_register", "there is no such register"},
    {"file", "the file cannot be written"},
    {"bad_eds", "the data sheet does not describe the data channels"},
    {"bad_safety", "these frames cannot be monitored with this setup"},
    {"clock_max", "the clock is above the limit of the encoder"},
    {"no_error_flag", "a position has no nE: set no_error_flag to read it"},
    {"no_crc", "a channel has no checksum: set unchecked to read it"},
}};

// CMake's version of the project, which is also the version of the package.
static_assert(std::string_view(BISS_C_VERSION) == BISS_PROJECT_VERSION);
static_assert(BISS_C_VERSION_NUMBER == BISS_PROJECT_VERSION_NUMBER);

constexpr StatusText text_of(biss_status status) {
  const auto index = static_cast<unsigned>(status);
  return index < statuses.size() ? statuses[index] : StatusText{"unknown", "no such status"};
}

}  // namespace

extern "C" {

const char* biss_version(void) { return BISS_C_VERSION; }

const char* biss_status_name(biss_status status) { return text_of(status).name; }

const char* biss_status_text(biss_status status) { return text_of(status).text; }

const char* biss_cause_name(biss_cause cause) {
  if (cause == BISS_CAUSE_OK) return "ok";
  if (cause < BISS_CAUSE_OK || cause > BISS_CAUSE_STOP_BIT) return "unknown";
  return biss::name_of(static_cast<biss::FrameError>(cause - 1)).data();  // of a literal
}

}  // extern "C"
