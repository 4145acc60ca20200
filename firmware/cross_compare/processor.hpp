// One of two processors that judge the same BiSS Safety encoder and compare their findings.
//
//            bits of the answer                bits of the answer
//                   |                                 |
//   processor A: field_evaluation.hpp   processor B: line_evaluation.hpp
//                   |  ---- Message: finding of A --->  |
//                   |  <--- Message: finding of B ----  |
//              SafetyMonitor                     SafetyMonitor
//                   |                                 |
//             enables torque                    enables torque: both must
//
// Each processor has its own copy of the bits, its own clocks, its own monitor and its own output.
// They share only the answer of the encoder and the messages. A processor takes only a message of
// the other processor, of the same connection and request. It refuses its own message when that
// comes back (an echo on a half-duplex line, TX shorted to RX), and messages of another pair.
#pragma once

#include <concepts>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/safety/field_evaluation.hpp"
#include "biss/safety/line_evaluation.hpp"
#include "biss/safety/monitor.hpp"
#include "firmware/cross_compare/message.hpp"

namespace cross_compare {

/// `Evaluation` is FieldEvaluation<Plan> on the one processor and LineEvaluation<Plan> on the
/// other. It is the processor's identity, too: two processors with the same evaluation refuse each
/// other.
template <class Plan, class Evaluation>
class Processor {
  static constexpr bool is_first = std::same_as<Evaluation, biss::FieldEvaluation<Plan>>;
  static_assert(is_first || std::same_as<Evaluation, biss::LineEvaluation<Plan>>);
  static constexpr Sender own = is_first ? Sender::field : Sender::line;
  static constexpr Sender other = is_first ? Sender::line : Sender::field;

 public:
  /// \param connection number of this pair of processors: the same on both, and on no other
  ///   processor of the machine
  constexpr explicit Processor(std::uint16_t connection) : connection_(connection) {}

  /// Runs the self test of both evaluations, before the first request.
  [[nodiscard]] constexpr bool power_up() { return monitor_.self_test(); }

  /// Evaluates the answer to a request. \return the message to the other processor
  /// \param request number of the request, the same on both processors. After a power-up it must
  ///   not begin with earlier numbers if messages from before may still be on their way.
  constexpr Message evaluate(std::uint32_t request, const biss::BitView& bits) {
    request_ = request;
    transfer_clocks_ = static_cast<std::uint32_t>(bits.size_bits());
    found_ = Evaluation::find(monitor_.plan(), bits);
    waits_ = true;
    return encode({request, connection_, own}, found_);
  }

  /// Compares with the other processor, once for each answer. Without a good message of the other
  /// processor on this request there is no judgement: the watchdog then ends the safe state.
  /// \param now as for SafetyMonitor::step(); Transfer::clocks are the clocks of the answer
  /// \return the position on the authority of this processor alone
  constexpr biss::GuardedPosition compare(biss::TwoClocks now, const Message& message) {
    const auto received = decode({request_, connection_, other}, message);
    if (!received || !waits_) {
      monitor_.watch(now);
      return {};
    }
    waits_ = false;
    now.transfer.clocks = transfer_clocks_;
    return (is_first ? monitor_.step(now, found_, *received)
                     : monitor_.step(now, *received, found_))
        .position;
  }

  /// Call it in every control period, at the same moment.
  constexpr bool is_safe(const biss::TwoClocks& now) {
    return monitor_.watch(now).verdict == biss::SafetyVerdict::safe;
  }

  constexpr biss::SafetyState state() const { return monitor_.state(); }
  /// The cause of the fault that holds. \pre state() is latched or failed
  constexpr biss::SafetyVerdict cause() const { return monitor_.latched_cause(); }
  constexpr bool acknowledge(biss::SafetyVerdict cause) { return monitor_.acknowledge(cause); }

  /// The same as SafetyMonitor::expect_position(), on both processors, before the request is made.
  constexpr void expect_position(std::uint64_t low, std::uint64_t high) {
    monitor_.expect_position(low, high);
  }
  /// The same as SafetyMonitor::encoder_restarted(), on both processors. An answer that was not yet
  /// compared is dropped.
  constexpr void encoder_restarted() {
    waits_ = false;
    monitor_.encoder_restarted();
  }

 private:
  biss::SafetyMonitor<Plan> monitor_;
  biss::SafetyFinding found_{};
  std::uint32_t request_ = 0;
  std::uint32_t transfer_clocks_ = 0;
  std::uint16_t connection_;
  bool waits_ = false;  // for the message on found_
};

}  // namespace cross_compare
