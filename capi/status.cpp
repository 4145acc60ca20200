// Names and texts of the codes.
#include <array>
#include <cstddef>

#include "biss/frame/frame.hpp"
#include "capi/biss_c.h"

namespace {

struct StatusText {
  const char* name;
  const char* text;
};

constexpr std::array<StatusText, BISS_NO_READING + 1> statuses{{
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
    {"no_reading", "no request was made yet"},
}};

// One for each cause, in the order of biss::FrameError.
static_assert(BISS_CAUSE_NO_RESPONSE == 1 + static_cast<int>(biss::FrameError::no_response));
static_assert(BISS_CAUSE_STOP_BIT == 1 + static_cast<int>(biss::FrameError::stop_bit));
static_assert(BISS_CAUSE_STOP_BIT == biss::frame_error_count);

constexpr StatusText text_of(biss_status status) {
  const auto index = static_cast<unsigned>(status);
  return index < statuses.size() ? statuses[index] : StatusText{"unknown", "no such status"};
}

}  // namespace

extern "C" {

const char* biss_status_name(biss_status status) { return text_of(status).name; }

const char* biss_status_text(biss_status status) { return text_of(status).text; }

const char* biss_cause_name(biss_cause cause) {
  if (cause == BISS_CAUSE_OK) return "ok";
  if (cause < BISS_CAUSE_OK || cause > BISS_CAUSE_STOP_BIT) return "unknown";
  return biss::name_of(static_cast<biss::FrameError>(cause - 1)).data();  // of a literal
}

}  // extern "C"
