#include "live/line_control.hpp"

#include <utility>

#include "biss/configure/configure_link.hpp"

namespace biss::live {

LineControl::LineControl(SpiPort port, Hertz clock, std::function<bool()> go_on)
    : bounds_(bounds_up_to_cds(period_of(clock), {})),
      reader_(std::move(port), microseconds(10), common_cycle, biss_static_timeout_max),
      go_on_(std::move(go_on)) {
  // The port samples after the rising edge: on a short line, ACK is the second sample.
  bounds_.lead_min_clocks = 1;
  reader_.set_bytes(bytes_up_to_cds(bounds_));
}

// A transfer that failed may have been made in part: its CDS is missing.
std::optional<CdsBit> LineControl::request(bool cdm) {
  reader_.port().end_with(cdm);
  bool failed = false;
  const auto on_fault = [&](PortFault fault, Picoseconds time) {
    fault_ = fault;
    time_ = time;
    failed = true;
  };
  const auto transfer = reader_.next(on_fault, [&](Picoseconds) { return !failed && go_on_(); });
  if (transfer) {
    time_ = transfer->time;
    faults_in_a_row_ = 0;
    fault_.reset();
    return cds_of(BitView(transfer->bytes), bounds_);
  }
  if (!failed || fault_ == PortFault::gone || ++faults_in_a_row_ == 10) return std::nullopt;
  return CdsBit::missing;
}

}  // namespace biss::live
