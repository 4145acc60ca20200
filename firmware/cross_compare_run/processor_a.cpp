// The firmware of processor A: it evaluates with biss::FieldEvaluation.
#include "firmware/cross_compare_run/firmware_of.hpp"

namespace cross_compare_run {

constinit const Firmware processor_a = FirmwareOf<biss::FieldEvaluation<Plan>>::functions;

}  // namespace cross_compare_run
