// The session and the query in a biss_control.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/base/units.hpp"
#include "biss/configure/configurator.hpp"
#include "biss/control/session.hpp"
#include "capi/biss_c_control.h"
#include "capi/device.hpp"

namespace biss::capi {

struct Control {
  explicit Control(const ControlOptions& options) : session(options) {}

  bool done() const { return session.done() && next == nullptr; }

  static bool usual_step(Control& self, Picoseconds now, CdsBit cds) {
    const bool bit = self.session.step(now, cds);
    while (self.next != nullptr && self.session.done()) self.next(self);
    return bit;
  }

  /// The next access of a query. \pre the last one is done
  static void advance(Control& self) {
    const ControlOutcome last = self.session.outcome();
    if (!self.query.advance(self.session) && !self.begins_eds()) {
      self.next = nullptr;
      return;
    }
    self.earlier_frames += last.frames;
    self.earlier_tries += last.tries;
    self.earlier_busy = std::max(self.earlier_busy, last.longest_busy);
  }

  /// After everything else of the device comes its EDS, if it has one.
  bool begins_eds() {
    if (query.failed() || query.step() != ConfigureStep::find_eds) return false;
    const SlaveDescription& found = query.description();
    return query.names_eds(found) && query.begin_eds(session, id, found);
  }

  // Pointers, so that a master without registers links no session, and a session no query.
  bool (*step)(Control& self, Picoseconds now, CdsBit cds) = &usual_step;
  void (*next)(Control& self) = nullptr;  // advance() while a query runs
  ControlSession session;
  std::array<std::uint8_t, sequential_max_bytes> bytes{};
  std::size_t read_count = 0;
  configure_detail::SlaveQuery query;
  // The numbers of all accesses of a query but the last one.
  std::uint32_t earlier_frames = 0;
  std::uint32_t earlier_tries = 0;
  Picoseconds earlier_busy{};
  std::uint8_t id = 0;   // of the device that is queried
  bool queried = false;  // the last access was a query
  Clock clock;
};

/// Takes the CDS of a frame. \return the CDM that ends it; false if the session has ended
inline bool step_control(biss_control* control, Picoseconds now, CdsBit cds) {
  return is_open(control) && thing<Control>(control).step(thing<Control>(control), now, cds);
}

}  // namespace biss::capi
