// Handles that close automatically, and a line without delay between the two; for the tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "capi/biss_c.h"

namespace biss::capi {

struct Closer {
  void operator()(biss_slave* slave) const { biss_slave_close(slave); }
  void operator()(biss_master* master) const { biss_master_close(master); }
};
using SlaveHandle = std::unique_ptr<biss_slave, Closer>;
using MasterHandle = std::unique_ptr<biss_master, Closer>;

inline SlaveHandle open_slave(const biss_slave_setup& setup) {
  biss_slave* slave = nullptr;
  EXPECT_EQ(biss_slave_open(&setup, &slave), BISS_OK);
  return SlaveHandle(slave);
}

inline MasterHandle open_master(const biss_master_setup& setup) {
  biss_master* master = nullptr;
  EXPECT_EQ(biss_master_open(&setup, &master), BISS_OK);
  return MasterHandle(master);
}

/// An encoder in a test: what it sends, and the calls that it received.
struct Encoder {
  std::vector<biss_channel> says{};
  bool cds = false;
  std::vector<std::int64_t> moments{};
  std::vector<bool> cdm_bits{};

  static void sample(void* user, std::int64_t moment, biss_channel* channels, std::size_t count) {
    auto& self = *static_cast<Encoder*>(user);
    self.moments.push_back(moment);
    std::copy_n(self.says.begin(), std::min(count, self.says.size()), channels);
  }
  static bool answer_cds(void* user) { return static_cast<Encoder*>(user)->cds; }
  static void take_cdm(void* user, bool bit) {
    static_cast<Encoder*>(user)->cdm_bits.push_back(bit);
  }

  biss_slave_setup setup(const char* format) {
    biss_slave_setup setup = biss_slave_defaults(format);
    setup.user = this;
    setup.sample = &sample;
    setup.cds = &answer_cds;
    setup.cdm = &take_cdm;
    return setup;
  }
};

/// Both ends joined by a wire; a request at a time.
class Line {
 public:
  Line(biss_slave* slave, biss_master* master) : slave_(slave), master_(master) {}

  /// \return the first status of the encoder's steps that is not BISS_OK
  biss_status request(bool cdm) {
    biss_status status = BISS_OK;
    EXPECT_EQ(biss_master_begin(master_, now_, slo_.level, cdm, &ma_), BISS_OK);
    for (;;) {
      const biss_status step = biss_slave_step(slave_, now_, ma_.level, false, &slo_);
      if (status == BISS_OK) status = step;
      EXPECT_EQ(biss_master_step(master_, now_, slo_.level, &ma_), BISS_OK);
      if (biss_master_done(master_)) break;
      now_ = std::min(ma_.deadline_ps, slo_.deadline_ps);
      EXPECT_EQ(biss_master_step(master_, now_, slo_.level, &ma_), BISS_OK);
    }
    EXPECT_EQ(biss_slave_step(slave_, now_, ma_.level, false, &slo_), BISS_OK);
    now_ += 100'000'000;
    return status;
  }

  std::int64_t now() const { return now_; }

  biss_reading reading() const {
    biss_reading reading{};
    EXPECT_EQ(biss_master_reading(master_, &reading), BISS_OK);
    return reading;
  }

 private:
  biss_slave* slave_;
  biss_master* master_;
  biss_output ma_{true, BISS_NEVER};
  biss_output slo_{true, BISS_NEVER};
  std::int64_t now_ = 0;
};

}  // namespace biss::capi
