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
// They share nothing but the answer of the encoder and the messages.
#pragma once

#include <concepts>
#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/safety/field_evaluation.hpp"
#include "biss/safety/line_evaluation.hpp"
#include "biss/safety/monitor.hpp"
#include "firmware/cross_compare/message.hpp"

namespace cross_compare {

/// `Evaluation` is FieldEvaluation<Plan> on the one processor and LineEvaluation<Plan> on the other.
template <class Plan, class Evaluation>
class Processor {
  static constexpr bool is_first = std::same_as<Evaluation, biss::FieldEvaluation<Plan>>;
  static_assert(is_first || std::same_as<Evaluation, biss::LineEvaluation<Plan>>);

 public:
  /// Runs the self test of both evaluations, before the first request.
  [[nodiscard]] constexpr bool power_up() { return monitor_.self_test(); }

  /// Evaluates the answer to a request. \return the message to the other processor
  constexpr Message evaluate(std::uint32_t request, const biss::BitView& bits) {
    request_ = request;
    own_ = Evaluation::find(monitor_.plan(), bits);
    return encode(request, own_);
  }

  /// Compares with the other processor. Without a good message of this request there is no
  /// judgement: the watchdog then ends the safe state.
  /// \return the position, as this processor alone vouches for it
  constexpr biss::GuardedPosition compare(const biss::TwoClocks& now, const Message& message) {
    const auto other = decode(request_, message);
    if (!other) {
      monitor_.watch(now);
      return {};
    }
    return (is_first ? monitor_.step(now, own_, *other) : monitor_.step(now, *other, own_))
        .position;
  }

  /// To be called in every control period, at the same moment.
  constexpr bool is_safe(const biss::TwoClocks& now) {
    return monitor_.watch(now).verdict == biss::SafetyVerdict::safe;
  }

  constexpr biss::SafetyState state() const { return monitor_.state(); }
  /// The cause of the fault that holds. \pre state() is latched or failed
  constexpr biss::SafetyVerdict cause() const { return monitor_.latched_cause(); }
  constexpr bool acknowledge(biss::SafetyVerdict cause) { return monitor_.acknowledge(cause); }

 private:
  biss::SafetyMonitor<Plan> monitor_;
  biss::SafetyFinding own_{};
  std::uint32_t request_ = 0;
};

}  // namespace cross_compare
