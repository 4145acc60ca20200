// The firmware of processor B: it evaluates with biss::LineEvaluation.
#include "firmware/cross_compare_run/firmware_of.hpp"

namespace cross_compare_run {

constinit const Firmware processor_b = FirmwareOf<biss::LineEvaluation<Plan>>::functions;

}  // namespace cross_compare_run
