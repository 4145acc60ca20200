// Objects after their init, formats by name, a line without delay, and a master at a simulated
// line.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "capi/biss_c.h"
#include "capi/biss_c_sim.h"
#include "capi/object.hpp"

namespace biss::capi {

/// The format of a text, which is valid as long as the program; without channels if there is none.
inline const biss_format* named(const std::string& text) {
  static std::map<std::string, biss_format> formats;
  const auto [found, is_new] = formats.try_emplace(text);
  if (is_new) biss_format_parse(text.c_str(), &found->second);
  return &found->second;
}

/// The inverse; empty if the format is wrong.
inline std::string text_of(const biss_format& format) {
  char text[BISS_FORMAT_TEXT_MAX] = "";
  biss_format_text(&format, text, sizeof text, nullptr);
  return text;
}

template <class Object>
using Handle = std::unique_ptr<Object>;

/// \param init such as biss_slave_init
template <class Object, class Setup>
Handle<Object> opened(biss_status (*init)(Object*, const Setup*), const Setup& setup) {
  auto object = std::make_unique<Object>();
  EXPECT_EQ(init(object.get(), &setup), BISS_OK);
  return object;
}

using SlaveHandle = Handle<biss_slave>;
using MasterHandle = Handle<biss_master>;

struct LineCloser {
  void operator()(biss_line* line) const {
    biss_line_close(line);
    delete line;
  }
};
using LineHandle = std::unique_ptr<biss_line, LineCloser>;

inline SlaveHandle open_slave(const biss_slave_setup& setup) {
  return opened(biss_slave_init, setup);
}

inline MasterHandle open_master(const biss_master_setup& setup) {
  return opened(biss_master_init, setup);
}

inline LineHandle open_line(const biss_line_setup& setup) {
  return LineHandle(opened(biss_line_init, setup).release());
}

/// Every call refuses null, another kind, a copy, and the object after its end.
/// \param every all calls with an object, and their statuses
template <class Object>
void expect_refusals(Object* object, const auto& every) {
  using Statuses = std::vector<biss_status>;
  const std::size_t count = every(static_cast<Object*>(nullptr)).size();
  EXPECT_EQ(every(static_cast<Object*>(nullptr)), Statuses(count, BISS_NULL_ARGUMENT));
  const Statuses refused(count, BISS_BAD_HANDLE);
  struct OtherKind {
    std::uintptr_t mark;
    Object object;
  };
  auto other = std::make_unique<OtherKind>();
  other->object = *object;
  EXPECT_EQ(every(&other->object), refused);
  other->mark = mark_of(other.get());
  EXPECT_EQ(every(reinterpret_cast<Object*>(other.get())), refused);
  *object = {};
  EXPECT_EQ(every(object), refused);
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
    biss_slave_setup setup = biss_slave_defaults(format == nullptr ? nullptr : named(format));
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
