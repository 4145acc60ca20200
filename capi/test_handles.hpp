// Handles of any kind that close automatically, and a master at a simulated line; for the tests.
#pragma once

#include "capi/biss_c_sim.h"
#include "capi/handles.hpp"

namespace biss::capi {

template <auto close>
struct HandleCloser {
  void operator()(auto* handle) const { close(handle); }
};
template <class Thing, auto close>
using Handle = std::unique_ptr<Thing, HandleCloser<close>>;

/// \param open such as biss_line_open
template <auto close, class Setup, class Thing>
Handle<Thing, close> opened(biss_status (*open)(Setup, Thing**), Setup setup) {
  Thing* thing = nullptr;
  EXPECT_EQ(open(setup, &thing), BISS_OK);
  return Handle<Thing, close>(thing);
}

using LineHandle = Handle<biss_line, biss_line_close>;

inline LineHandle open_line(const biss_line_setup& setup) {
  return opened<biss_line_close>(biss_line_open, &setup);
}

/// A master at the line; a request every 100 us.
class LineReader {
 public:
  static constexpr std::int64_t interval = 100'000'000;

  LineReader(biss_line* line, const biss_master_setup& setup)
      : line_(line), master_(open_master(setup)) {}

  biss_reading request(bool cdm = false) {
    const std::int64_t begin = static_cast<std::int64_t>(requests_++) * interval;
    while (out_.deadline_ps < begin) step(out_.deadline_ps);
    const biss_status begun = biss_master_begin(master_.get(), begin, out_.slo, cdm, &ma_);
    if (begun == BISS_OK) {
      step(begin);
      while (!biss_master_done(master_.get())) {
        const std::int64_t now = std::min(ma_.deadline_ps, out_.deadline_ps);
        step(now);
        EXPECT_EQ(biss_master_step(master_.get(), now, out_.slo, &ma_), BISS_OK);
        step(now);
      }
    } else {
      worst_ = begun;
    }
    biss_reading reading{};
    EXPECT_EQ(biss_master_reading(master_.get(), &reading), BISS_OK);
    return reading;
  }

  /// The truth about the last request.
  biss_line_request truth() const {
    biss_line_request request{};
    EXPECT_EQ(biss_line_request_of(line_, &request), BISS_OK);
    return request;
  }
  biss_status worst() const { return worst_; }

 private:
  void step(std::int64_t now) {
    const biss_status status = biss_line_step(line_, now, ma_.level, true, &out_);
    if (status != BISS_OK) worst_ = status;
  }

  biss_line* line_;
  MasterHandle master_;
  biss_output ma_{true, BISS_NEVER};
  biss_line_output out_{true, true, BISS_NEVER};
  unsigned requests_ = 1;
  biss_status worst_ = BISS_OK;
};

}  // namespace biss::capi
