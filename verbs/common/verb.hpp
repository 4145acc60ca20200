// How a verb joins the command, Python and the page: one file, and one word in verbs/CMakeLists.txt.
//
//     // verbs/crc/crc.cpp
//     namespace biss::verbs {
//     namespace {
//     struct CrcOptions { std::string format; std::string output; report::Format to{}; … };
//     ExitStatus run_crc(const CrcOptions& options, Host& host) { … }
//     }  // namespace
//
//     void add_crc(Command& command) {
//       const auto options = std::make_shared<CrcOptions>();
//       Verb verb = command.add_verb({.name = "crc",
//                                          .purpose = "Show the frame for a position, bit by bit",
//                                          .examples = {"biss crc -f pos26,nE,nW,crc6 12345"}},
//                                         [options](Host& host) { return run_crc(*options, host); });
//       verb.add_option("-f,--format", options->format, "Frame format").required();
//       add_output_option(verb, options->output);
//       add_to_option(verb, options->to);
//     }
//     }  // namespace biss::verbs
//
// A run that writes a table:
//
//     Output output(host);
//     if (!output.open(options.output)) return output.status();
//     const auto table = report::make_table_writer(options.to, columns, output,
//                                                  output.table_options());
//     while (…) if (!table->row(cells)) return output.status();      // disk full, reader left
//     if (input_failed) {                                            // rows so far to a pipe,
//       table->finish();                                             // no partial file
//       output.abandon();
//       return host.fail(ExitStatus::io, "…");
//     }
//     if (!table->finish() || !output.finish()) return output.status();
//     host.print_summary(summary.text());
//     return ExitStatus::done;
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "biss/base/units.hpp"
#include "device/quantity.hpp"
#include "lab/shard.hpp"
#include "report/table.hpp"
#include "verbs/common/files.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {

struct DeclaredVerb;
struct HelpOptions;
struct WrongWords;

/// Takes the values of an option; false if a value cannot be converted. A flag has `true` or `false`.
using SetValues = std::function<bool(const std::vector<std::string>& values)>;

/// Runs a verb once its command line is known to be good. It prints its own errors, by Host::fail().
using Run = std::function<ExitStatus(Host& host)>;

/// The purpose of an option. A verb, or the page, that takes over options of another verb chooses
/// them by their scope.
enum class Scope : std::uint8_t {
  reading,  ///< which cycles there are, and how a verb judges them
  file,     ///< how the file is read; not for a file that keeps a part of its lines
  judging,  ///< the columns `marginal` and `safety`
  rows,     ///< which rows and columns a table has
  command,  ///< this verb's own: its output, its threads, its port
};

/// One option of a verb, with its values on the command line. The Command owns it; it stays in its
/// place.
struct Option {
  Option() = default;
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;

  /// The name of the value in the help: FILE, KIND:RATE, …
  Option& type_name(const std::string& name) {
    value = name;
    return *this;
  }
  Option& required(bool is = true) {
    is_required = is;
    return *this;
  }
  Option& needs(const Option& other) {
    needed.push_back(&other);
    return *this;
  }
  Option& excludes(Option& other) {
    excluded.push_back(&other);
    other.excluded.push_back(this);
    return *this;
  }
  /// Splits a value at this character into several.
  Option& delimiter(char character) {
    separator = character;
    return *this;
  }
  /// Accepts these values only.
  Option& one_of(const std::vector<std::string>& values) {
    choices = values;
    return *this;
  }
  /// The value names a file that the verb opens; the command refuses two that are the same, see
  /// file_conflict(). `path` takes the path from the value, and nothing if the value has none.
  /// Without it the help calls the value FILE.
  Option& file(FileUse use, std::string (*path)(const std::string& value) = nullptr) {
    file_use = use;
    path_of = path;
    if (path == nullptr && !is_argument()) value = "FILE";
    return *this;
  }

  bool is_flag() const { return value.empty(); }
  bool is_argument() const { return !names.starts_with('-'); }
  /// `--format`, `FILE`.
  std::string name() const { return names.substr(names.find(',') + 1); }

  std::string names{};  ///< `-f,--format`; without a dash an argument: `FILE`
  std::string value{};  ///< the name of the value in the help; empty for a flag
  std::string meaning{};
  std::string heading{};
  /// The scope of the handle; an argument is for this verb alone.
  Scope scope = Scope::reading;
  bool repeats = false;
  SetValues set{};
  bool is_required = false;
  /// Splits a value into several, unless it is 0.
  char separator = '\0';
  /// Values that are allowed; empty: all.
  std::vector<std::string> choices{};
  std::vector<const Option*> needed{};
  std::vector<const Option*> excluded{};
  std::optional<FileUse> file_use{};
  std::string (*path_of)(const std::string& value) = nullptr;
  /// The values on the command line, in their order.
  std::vector<std::string> given{};
};

/// The help of a verb. Each example is a whole command line; the first one is also in the help of
/// the command.
struct VerbText {
  std::string name;
  std::string purpose;
  std::vector<std::string> examples;
};

/// The place of the value of an option, or of its values.
template <class... Values>
using TargetOf = std::variant<std::reference_wrapper<Values>...>;
using Target = TargetOf<std::string, std::int64_t, std::vector<std::string>, std::vector<double>,
                        std::vector<std::uint64_t>>;

/// A verb whose options are declared. A handle: copied freely, valid as long as the Command. Each
/// `target` must live until the command line is parsed. An empty value of an option is wrong usage.
class Verb {
 public:
  explicit Verb(DeclaredVerb* verb, std::string heading = "Options", Scope scope = Scope::reading)
      : verb_(verb), heading_(std::move(heading)), scope_(scope) {}

  /// The same verb; the help lists the options that are declared by this handle under `heading`.
  Verb section(const std::string& heading) const { return Verb(verb_, heading, scope_); }
  /// The same verb; the options that are declared by this handle are for this.
  Verb scope(Scope scope) const { return Verb(verb_, heading_, scope); }

  Option& add_option(const std::string& name, Target target, const std::string& description) const;
  Option& add_flag(const std::string& name, bool& target, const std::string& description) const;
  /// `set` gets the text of each value; see wrong_value().
  /// \param repeats it may be given several times
  Option& add_text_option(const std::string& name, std::function<void(const std::string&)> set,
                          const std::string& description, bool repeats = false) const;

  /// An option declared before, by its long name. Throws std::logic_error if it was not.
  Option& get_option(const std::string& name) const;
  /// The options that the command line has.
  std::vector<const Option*> given_options() const;
  /// A verb below this one, such as `merge` in `biss safety campaign merge`. Without `run`, the
  /// verb above runs; a top verb without `run` needs a verb below it.
  Verb add_verb(const VerbText& text, Run run = {}) const;
  void on_run(Run run) const;
  void add_help_flag() const;
  /// The command line names this verb.
  bool parsed() const;
  /// Calls `check` when the command line of this verb is parsed; see wrong_value().
  void after_parsing(std::function<void()> check) const;

 private:
  Option& declared(const std::string& names, const std::string& value, const std::string& meaning,
                   bool repeats, SetValues set) const;

  DeclaredVerb* verb_;
  std::string heading_;
  Scope scope_;
};

/// Ends the parsing of the command line: the value of option `name` is wrong usage.
[[noreturn]] void wrong_value(const std::string& name, const std::string& why);

/// An option by its long name, `--format`, and its values. A flag needs none.
using GivenOption = std::pair<std::string, std::vector<std::string>>;
using GivenOptions = std::vector<GivenOption>;

/// The verbs, and a run of one of them. Wrong usage is one message and ExitStatus::usage; an
/// exception that leaves a verb, also for lack of memory, is one message and ExitStatus::io.
class Command {
 public:
  /// \param host outlives the command; verbs run with it
  explicit Command(Host& host);
  ~Command();
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  /// Adds a verb; its options are declared by the handle returned.
  Verb add_verb(const VerbText& text, Run run);

  /// Runs a verb once.
  /// \param words name the verb, such as `safety analyse`; the further ones are its arguments
  ExitStatus run(const std::vector<std::string>& words, const GivenOptions& options);

  /// The same with a parser: it puts the values into the records.
  DeclaredVerb& declared();
  ExitStatus run_given(const WrongWords& words);

 private:
  void add_help();
  ExitStatus check_and_run(const WrongWords& words);
  ExitStatus print_help(const HelpOptions& options) const;
  ExitStatus wrong_usage(const std::string& what) const;

  Host& host_;
  std::unique_ptr<DeclaredVerb> root_;
  bool version_ = false;
};

/// Adds the verb of this name; without a name, or if no verb has it, all verbs of this build: the list
/// is in verbs/CMakeLists.txt.
void add_verbs(Command& command, std::string_view name = {});

/// A verb below a verb, as `biss eds show`. `add` declares its options and returns what runs it.
struct GroupVerb {
  VerbText text;
  Run (*add)(Verb verb);
};

/// Adds `biss GROUP` with its verbs, of which the command line must name one.
void add_verb_group(Command& command, const VerbText& group, const std::vector<GroupVerb>& verbs);

/// `-o,--output FILE`, to be given to Output::open().
Option& add_output_option(Verb verb, std::string& path,
                          const std::string& help = "Output file; standard output (-) by default");

/// Without `--to` the ending of `-o` chooses one of these formats: `.csv`, `.jsonl`, `.h5`, `.vcd`. The
/// command refuses the ending of another format of rows.
void let_output_choose(Verb verb, const std::vector<std::string>& names,
                       std::function<void(const std::string& name)> take);

/// `--to FORMAT` of the formats allowed; `target` holds the default.
/// \param by_output the rows go to `-o`, so let_output_choose()
Option& add_to_option(Verb verb, report::Format& target,
                      std::initializer_list<report::Format> allowed = {report::Format::table,
                                                                       report::Format::csv,
                                                                       report::Format::jsonl},
                      bool by_output = true);

/// An option that takes one of some names; `target` holds the default.
Option& add_name_option(Verb verb, const std::string& name, std::string& target,
                        const std::vector<std::string>& names, const std::string& description);

/// Adds an option with a unit. `set` is called only when the option is given, see into(); a wrong
/// value is wrong usage, its message points at the character.
template <class Value>
struct QuantityOption {
  Quantity quantity;
  Result<Value, QuantityError> (*parse)(std::string_view text);
  const char* value_name;

  Option& operator()(Verb verb, const std::string& name, std::function<void(Value)> set,
                     const std::string& description) const {
    const auto take = [of = *this, name, set](const std::string& text) {
      const auto value = of.parse(text);
      if (!value) wrong_value(name, quantity_error_text(of.quantity, text, value.error()));
      set(*value);
    };
    return verb.add_text_option(name, take, description).type_name(value_name);
  }
};

inline constexpr QuantityOption<Hertz> add_rate_option{Quantity::rate, parse_rate, "RATE"};
inline constexpr QuantityOption<Picoseconds> add_duration_option{Quantity::duration, parse_duration,
                                                                 "TIME"};
inline constexpr QuantityOption<Millimetres> add_length_option{Quantity::length, parse_length,
                                                               "LENGTH"};
/// A time in a capture, which may be negative.
inline constexpr QuantityOption<Picoseconds> add_time_option{Quantity::time, parse_time, "TIME"};
/// A share in thousandths.
inline constexpr QuantityOption<std::uint32_t> add_duty_option{Quantity::duty, parse_duty, "SHARE"};
/// Parts of a million with a sign.
inline constexpr QuantityOption<std::int32_t> add_deviation_option{Quantity::deviation,
                                                                   parse_deviation, "PPM"};
/// One line: there is no time from --since to --until; else empty.
std::string wrong_range(const std::optional<Picoseconds>& since,
                        const std::optional<Picoseconds>& until);
/// A count from 0 to `largest`, decimal or 0x….
Option& add_count_option(Verb verb, const std::string& name, std::function<void(std::uint64_t)> set,
                         const std::string& description, std::uint64_t largest = UINT64_MAX);

/// Puts the value into an optional<T>, or a T that holds the default; the place must live until the
/// command line is parsed: `add_rate_option(verb, "--clock", into(options->clock), "…")`.
template <class Target>
auto into(Target& target) {
  return [&target](auto value) { target = static_cast<Target>(value); };
}

/// `--shard K/N`, one of N parts of the work; `shard` must live until the command line is parsed.
Option& add_shard_option(Verb verb, lab::Shard& shard, const std::string& description);

}  // namespace biss::verbs
