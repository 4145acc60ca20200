// The report of a simulation: mismatches and coverage of all instances, as text and as JSON.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "simulators/instance.hpp"

namespace biss::simulators {

using Instances = std::vector<std::unique_ptr<Instance>>;

/// Mismatches, and one more if nothing was compared.
std::uint64_t failures_of(const Instance& instance);

/// \param errors wrong calls, in addition to the failures of the instances
std::string report_text(const Instances& instances, std::uint64_t errors);
std::string report_json(const Instances& instances, std::uint64_t errors);

}  // namespace biss::simulators
