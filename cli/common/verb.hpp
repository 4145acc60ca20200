// How a verb joins the command: one file, and one line each in verbs.hpp, main.cpp, CMakeLists.txt.
//
//     // cli/crc/crc.cpp
//     namespace biss::cli {
//     namespace {
//     struct CrcOptions { std::string format; std::string output; report::Format to{}; … };
//     ExitStatus run_crc(const CrcOptions& options) { … }
//     }  // namespace
//
//     void add_crc(Command& command) {
//       const auto options = std::make_shared<CrcOptions>();
//       CLI::App& verb = command.add_verb({.name = "crc",
//                                          .purpose = "Show the frame for a position, bit by bit",
//                                          .examples = {"biss crc -f pos26,nE,nW,crc6 12345"}},
//                                         [options] { return run_crc(*options); });
//       verb.add_option("-f,--format", options->format, "Frame format")->required();
//       add_output_option(verb, options->output);
//       add_to_option(verb, options->to);
//     }
//     }  // namespace biss::cli
//
// A run that writes a table:
//
//     Output output;
//     if (!output.open(options.output)) return output.status();
//     const auto table = report::make_table_writer(options.to, columns, output,
//                                                  {.colour = output.wants_colour()});
//     while (…) if (!table->row(cells)) return output.status();      // disk full, reader left
//     if (input_failed) {                                            // rows so far to a pipe,
//       table->finish();                                             // no partial file
//       output.abandon();
//       return fail(ExitStatus::io, "…");
//     }
//     if (!table->finish() || !output.finish()) return output.status();
//     print_summary(summary.text());
//     return ExitStatus::done;
#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "cli/common/exit_status.hpp"
#include "cli/common/message.hpp"
#include "cli/common/output.hpp"
#include "cli/common/quantity.hpp"
#include "report/table.hpp"

namespace biss::cli {

/// What the help says of a verb. Each example is a whole command line; the first one also stands in
/// the help of the command.
struct VerbText {
  std::string name;
  std::string purpose;
  std::vector<std::string> examples;
};

/// Runs a verb once its command line is known to be good. It prints its own errors, by fail().
using Run = std::function<ExitStatus()>;

/// The command line `biss VERB …` and its verbs.
class Command {
 public:
  Command();

  /// Adds a verb; the options go to the App returned, which the Command owns.
  CLI::App& add_verb(const VerbText& text, Run run);

  /// Parses and runs. Wrong usage is one line on stderr and ExitStatus::usage; what escapes a verb
  /// as an exception, memory run out included, is one line and ExitStatus::io.
  ExitStatus run(int argc, const char* const* argv);

 private:
  struct Verb {
    CLI::App* app;
    Run run;
  };

  ExitStatus parse_and_run(int argc, const char* const* argv);
  ExitStatus unknown_verb(const std::string& name) const;
  ExitStatus wrong_usage(const std::string& what) const;
  std::string usage_text(const CLI::ParseError& error) const;

  CLI::App app_;
  std::vector<Verb> verbs_;
  std::string examples_;
};

/// `-o,--output FILE`, to be given to Output::open().
CLI::Option* add_output_option(CLI::App& verb, std::string& path);

/// `--to FORMAT` of the formats allowed; `target` holds the default.
CLI::Option* add_to_option(CLI::App& verb, report::Format& target,
                           std::initializer_list<report::Format> allowed = {
                               report::Format::table, report::Format::csv, report::Format::jsonl});

/// An option that takes one of some names; `target` holds the default.
CLI::Option* add_name_option(CLI::App& verb, const std::string& name, std::string& target,
                             const std::vector<std::string>& names, const std::string& description);

/// Options with a unit. `set` is called only when the option is given, see into(); a wrong value is
/// wrong usage, its message points at the character.
CLI::Option* add_rate_option(CLI::App& verb, const std::string& name,
                             std::function<void(Hertz)> set, const std::string& description);
CLI::Option* add_duration_option(CLI::App& verb, const std::string& name,
                                 std::function<void(Picoseconds)> set,
                                 const std::string& description);
CLI::Option* add_length_option(CLI::App& verb, const std::string& name,
                               std::function<void(Millimetres)> set,
                               const std::string& description);
/// A share in thousandths, see parse_duty().
CLI::Option* add_duty_option(CLI::App& verb, const std::string& name,
                             std::function<void(std::uint32_t)> set,
                             const std::string& description);
/// Parts of a million with a sign, see parse_deviation().
CLI::Option* add_deviation_option(CLI::App& verb, const std::string& name,
                                  std::function<void(std::int32_t)> set,
                                  const std::string& description);
/// A count from 0 to `largest`, decimal or 0x….
CLI::Option* add_count_option(CLI::App& verb, const std::string& name,
                              std::function<void(std::uint64_t)> set,
                              const std::string& description, std::uint64_t largest = UINT64_MAX);

/// Puts the value into an optional<T>, or a T that holds the default; the place must live until the
/// command line is parsed: `add_rate_option(verb, "--clock", into(options->clock), "…")`.
template <class Target>
auto into(Target& target) {
  return [&target](auto value) { target = static_cast<Target>(value); };
}

/// The candidate that differs from `name` by the fewest typing slips, or that `name` is the
/// beginning of; empty when none is near.
std::string nearest(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace biss::cli
