// biss eds build: the banks of a data sheet from a description.
#include <fmt/format.h>

#include <cctype>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dump/write.hpp"
#include "verbs/eds/rows.hpp"
#include "verbs/eds/source.hpp"

namespace biss::verbs {
namespace {

struct BuildOptions {
  EdsArguments arguments;
  std::string to;
  std::string name = "eds";
  std::optional<std::uint8_t> bank;
  bool force = false;
  std::string output;
};

const std::vector<std::string> build_formats{"hex", "bin", "ihex", "c"};

bool is_identifier(const std::string& name) {
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    if (std::isalpha(c) == 0 && c != '_' && (i == 0 || std::isdigit(c) == 0)) return false;
  }
  return !name.empty();
}

// The words of C++ too, because C++ programs also include a header in C.
constexpr std::string_view reserved_words =
    " alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t"
    " char32_t char8_t class co_await co_return co_yield compl concept const const_cast"
    " consteval constexpr constinit continue decltype default delete do double dynamic_cast"
    " else enum explicit export extern false float for friend goto if inline int long mutable"
    " namespace new noexcept not not_eq nullptr operator or or_eq private protected public"
    " register reinterpret_cast requires restrict return short signed sizeof static"
    " static_assert static_cast struct switch template this thread_local throw true try"
    " typedef typeid typename typeof typeof_unqual union unsigned using virtual void volatile"
    " wchar_t while xor xor_eq ";

// The parts that a description gives are written even if no data sheet with them is found.
dump::DataSheet with_drafted(dump::DataSheet sheet, const dump::DataSheet& drafted) {
  if (sheet.empty()) return drafted;
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (!sheet.profiles[i]) sheet.profiles[i] = drafted.profiles[i];
  }
  return sheet;
}

ExitStatus run_build(const BuildOptions& options, Host& host) {
  if (!is_identifier(options.name)) {
    throw wrong_usage("--name '{}': not an identifier in C", options.name);
  }
  if (reserved_words.find(" " + options.name + " ") != std::string_view::npos) {
    throw wrong_usage("--name '{}': a reserved word of C or C++", options.name);
  }
  const EdsSource source = load_eds(options.arguments, host);
  const dump::RegisterDump& dump = source.dump;
  const auto range = dump.banks();
  if (!range) return host.fail(ExitStatus::data_failed, "there is no bank to write");
  const std::string format =
      options.to.empty() ? std::string(dump::format_of(options.output)) : options.to;
  const bool banks_only = dump::holds_banks_only(format);
  const unsigned first = options.bank.value_or(0);
  if (banks_only && first > range->last) {
    throw wrong_usage("--bank {}: the last bank is {}", first, range->last);
  }
  const auto findings = eds_findings(with_drafted(source.sheet, source.drafted));
  for (const EdsFindingRow& row : findings) {
    host.warn(fmt::format("{}{} {}", row.part,
                          row.channel ? fmt::format(" of channel {}:", *row.channel) : ":",
                          finding_line(row)));
  }
  if (!findings.empty() && !options.force) {
    return host.fail(ExitStatus::data_failed, "not written; --force writes it with these findings");
  }
  const ExitStatus written = write_output(host, options.output, [&](Output& output) {
    return output.write(write_as(format, dump, options.name, first));
  });
  if (written == ExitStatus::done && banks_only) host.print_summary(text_of_banks(dump, first));
  return written;
}

}  // namespace

Run add_eds_build(Verb verb) {
  const auto options = std::make_shared<BuildOptions>();
  add_eds_file(verb, options->arguments.file);
  add_name_option(verb, "--to", options->to, build_formats,
                  "Output format; by default from the extension of -o, else hex");
  add_count_option(verb, "--bank", into(options->bank),
                   "First bank of bin and c; 0 by default. Banks without data are erased (0xFF)",
                   255);
  verb.add_option("--name", options->name, "Name of the constant in C; eds by default")
      .type_name("NAME");
  verb.add_flag("--force", options->force, "Write the banks even if there are findings");
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_build(*options, host); };
}

}  // namespace biss::verbs
