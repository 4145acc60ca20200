// The firmware of processor B: it evaluates with biss::LineEvaluation.
#include "firmware/cross_compare/processor.hpp"
#include "firmware/cross_compare_run/processors.hpp"

namespace cross_compare_run {
namespace {

using Processor = cross_compare::Processor<Plan, biss::LineEvaluation<Plan>>;
constinit Processor processor;

}  // namespace

const Firmware processor_b{
    // A power-up begins with a memory that was reset.
    .power_up =
        [] {
          processor = Processor();
          return processor.power_up();
        },
    .evaluate = [](std::uint32_t request,
                   const biss::BitView& bits) { return processor.evaluate(request, bits); },
    .compare =
        [](const biss::TwoClocks& now, const cross_compare::Message& message) {
          return processor.compare(now, message);
        },
    .is_safe = [](const biss::TwoClocks& now) { return processor.is_safe(now); },
    .state = [] { return processor.state(); },
    .cause = [] { return processor.cause(); },
    .acknowledge = [](biss::SafetyVerdict cause) { return processor.acknowledge(cause); }};

}  // namespace cross_compare_run
