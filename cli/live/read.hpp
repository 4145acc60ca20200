// `biss read`: the positions of a real line. `biss watch` reads its cycles in the same way.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "biss/base/units.hpp"
#include "cli/live/configure.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/decode/decode_run.hpp"

namespace biss::cli {

struct ReadOptions {
  verbs::DecodeOptions decode;
  ConfigureArguments configure;
  std::string port;
  std::string ma_pin = "sck";
  Hertz clock = megahertz(1);
  Hertz rate = kilohertz(1);
  std::optional<Millimetres> cable;
  std::optional<std::uint64_t> cycles;
  std::optional<Picoseconds> duration;
  std::uint64_t bytes = 0;
  std::string record;
  bool live = false;
};

/// Gets each cycle, and its time; null: a transfer failed.
using OnPortCycle = std::function<void(const decode::Cycle* cycle, Picoseconds time)>;

/// Declares --port, and the options of add_request_options().
verbs::Option& add_port_options(verbs::Verb verb, ReadOptions& options);
/// Reads the line until a signal, --cycles or --duration end it, and prints what the port did.
/// \param on_cycle gets the cycles; without it, their rows are written
verbs::ExitStatus read_port(const ReadOptions& options, verbs::Host& host,
                            const OnPortCycle& on_cycle = {});

void add_read(verbs::Command& command);

/// The options of a line without its port, format and timing. \pre options outlive the parsing
void add_request_options(verbs::Verb verb, ReadOptions& options);

/// Opens the port; throws a VerbError if that is not possible.
/// \return the reading, until `goes_on` is false. Options and host outlive it
std::function<verbs::ExitStatus()> prepare_read(const ReadOptions& options, verbs::Host& host,
                                                std::function<bool()> goes_on,
                                                OnPortCycle on_cycle = {});

}  // namespace biss::cli
