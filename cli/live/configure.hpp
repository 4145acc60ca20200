// The control communication of `biss read`: the configuration, and accesses to registers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "device/device_text.hpp"
#include "live/spi_port.hpp"
#include "verbs/common/verb.hpp"

namespace biss::cli {

struct ConfigureArguments {
  bool configure = false;
  std::string registers;
  std::vector<std::string> accesses;

  bool given() const { return configure || !accesses.empty(); }
};

/// Declares --configure, --registers and --access.
void add_configure_options(verbs::Verb verb, ConfigureArguments& arguments);

/// Does what the arguments ask, at a clock that every encoder accepts, and prints it.
/// \param device with --configure, gets the format and the timing that were found
/// \return done: the encoder can be read. Throws a VerbError
verbs::ExitStatus configure_line(const ConfigureArguments& arguments, live::SpiPortSetup setup,
                                 FormatArguments& device, const std::function<bool()>& go_on,
                                 verbs::Host& host);

}  // namespace biss::cli
