#include "live/line_control.hpp"

#include <utility>

namespace biss::live {

LineControl::LineControl(SpiPort port, Hertz clock, std::function<bool()> go_on)
    : bounds_(bounds_up_to_cds(period_of(clock), {})),
      reader_(std::move(port), microseconds(10), common_cycle, biss_static_timeout_max),
      go_on_(std::move(go_on)) {
  // The port samples after the rising edge: on a short line, ACK is the second sample.
  bounds_.lead_min_clocks = 1;
  reader_.set_bytes(bytes_up_to_cds(bounds_));
}

bool LineControl::run(Configurator& configurator) {
  while (!configurator.done()) {
    const auto answer = request(configurator.cdm_ahead());
    if (!answer) return false;
    configurator.answer_ahead(answer->time, answer->cds);
  }
  return true;
}

bool LineControl::run(ControlSession& session) {
  while (!session.done()) {
    const auto answer = request(session.cdm_ahead());
    if (!answer) return false;
    session.step_ahead(answer->time, answer->cds);
  }
  return true;
}

std::optional<LineControl::Answer> LineControl::request(bool cdm) {
  reader_.port().end_with(cdm);
  std::optional<Answer> failed;
  const auto transfer = reader_.next(
      [&](PortFault fault, Picoseconds time) {
        failed = Answer{.time = time};
        // Perhaps a part of the transfer was made.
        if (++faults_in_a_row_ == most_faults || fault == PortFault::gone) fault_ = fault;
      },
      [&](Picoseconds) { return !failed && go_on_(); });
  if (!transfer) return fault_ ? std::nullopt : failed;
  faults_in_a_row_ = 0;
  const BitView bits(transfer->bytes);
  return Answer{transfer->time, cds_of(bits, bounds_)};
}

}  // namespace biss::live
