// The summary of `biss simulate --configure`: the requests of the master, and the results.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/configure/configurator.hpp"

namespace biss::verbs {

class ConfigureLog {
 public:
  /// Call before each request and after the last one.
  void note(const Configurator& configurator);

  /// The options of a configuration that reports its findings to this log. \pre it outlives the run
  ConfigureOptions options();

  /// The steps with their requests; format, timing and identity, each with its source, if they were
  /// found. \param time the duration of the configuration
  std::string text(const Result<Configuration, ConfigureFault>& found, Picoseconds time) const;

 private:
  struct Step {
    ConfigureStep step{};
    std::uint8_t slave = 0;
    std::uint32_t requests = 0;
  };

  std::vector<Step> steps_;
  std::vector<std::string> findings_;
  std::uint32_t requests_ = 0;
};

/// One line: the cause, the step, the slave, and how the access went.
std::string text_of(const ConfigureFault& fault);

}  // namespace biss::verbs
