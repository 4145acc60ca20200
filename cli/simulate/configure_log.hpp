// What a master that began with knowing nothing asked, and what it found: the summary of
// `biss simulate --configure`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/configure/configurator.hpp"

namespace biss::cli {

class ConfigureLog {
 public:
  /// Where it stands: before each request, and behind the last.
  void note(const Configurator& configurator);

  /// The steps, and format, timing and identity with where each comes from; or the cause why not.
  /// \param time that it took
  std::string text(const Result<Configuration, ConfigureFault>& found, Picoseconds time) const;

 private:
  struct Step {
    ConfigureStep step{};
    std::uint8_t slave = 0;
    std::uint32_t requests = 0;
  };

  std::vector<Step> steps_;
  std::uint32_t requests_ = 0;
};

/// One line: the cause, the step, the slave, and how the access went.
std::string text_of(const ConfigureFault& fault);

}  // namespace biss::cli
