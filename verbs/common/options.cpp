// Options that several verbs declare: rates, times, lengths, output, parts of the work.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "report/text.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

Option& add_output_option(Verb verb, std::string& path, const std::string& help) {
  return verb.scope(Scope::command).add_option("-o,--output", path, help).file(FileUse::write);
}

void let_output_choose(Verb verb, const std::vector<std::string>& names,
                       std::function<void(const std::string& name)> take) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 4> endings{
      {{".csv", "csv"}, {".jsonl", "jsonl"}, {".h5", "hdf5"}, {".vcd", "vcd"}}};
  verb.after_parsing([verb, names, take = std::move(take)] {
    std::string output;
    for (const Option* option : verb.given_options()) {
      if (option->name() == "--to") return;
      if (option->name() == "--output") output = option->given.front();
    }
    for (const auto& [ending, format] : endings) {
      if (!output.ends_with(ending)) continue;
      const std::string name(format);
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        wrong_value("--output", fmt::format("'{}': {} is not written here; name another file, or "
                                            "give --to {}",
                                            output, name, fmt::join(names, "|")));
      }
      take(name);
    }
  });
}

Option& add_to_option(Verb verb, report::Format& target,
                      std::initializer_list<report::Format> allowed, bool by_output) {
  std::vector<std::string> names;
  for (const report::Format format : allowed) {
    names.emplace_back(report::format_names[static_cast<std::size_t>(format)]);
  }
  const auto take = [&target, names](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      wrong_value("--to", fmt::format("'{}' is not one of {}", name, fmt::join(names, ", ")));
    }
    target = *report::format_by_name(name);
  };
  if (by_output) let_output_choose(verb, names, take);
  return verb.scope(Scope::command)
      .add_text_option("--to", take,
                       by_output ? "Output format; by default from the extension of -o, else table"
                                 : "Output format; table by default")
      .type_name(fmt::format("{}", fmt::join(names, "|")));
}

Option& add_name_option(Verb verb, const std::string& name, std::string& target,
                        const std::vector<std::string>& names, const std::string& description) {
  return verb.add_option(name, target, description)
      .type_name(fmt::format("{}", fmt::join(names, "|")))
      .one_of(names);
}

std::string wrong_range(const std::optional<Picoseconds>& since,
                        const std::optional<Picoseconds>& until) {
  return since && until && *until < *since ? "--until: is before --since; exchange them" : "";
}

Option& add_count_option(Verb verb, const std::string& name, std::function<void(std::uint64_t)> set,
                         const std::string& description, std::uint64_t largest) {
  const auto take = [=](const std::string& text) {
    const auto value = parse_count(text, largest);
    if (!value) {
      wrong_value(name, quantity_error_text(Quantity::count, text, value.error(), largest));
    }
    set(*value);
  };
  return verb.add_text_option(name, take, description).type_name("N");
}

namespace {

std::optional<lab::Shard> parse_shard(std::string_view text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  const auto number = report::number_in<std::uint64_t>(text.substr(0, slash));
  const auto count =
      report::number_in<std::uint64_t>(text.substr(std::min(slash + 1, text.size())));
  if (number.value_or(0) == 0 || *number > count.value_or(0)) return std::nullopt;
  return *count <= lab::max_shards ? std::optional(lab::Shard{*number, *count}) : std::nullopt;
}

}  // namespace

Option& add_shard_option(Verb verb, lab::Shard& shard, const std::string& description) {
  return verb.scope(Scope::command)
      .add_text_option(
          "--shard",
          [&shard](const std::string& text) {
            const auto parsed = parse_shard(text);
            if (!parsed) {
              wrong_value("--shard", "takes K/N, 1/7 to 7/7 for example; N is at most 1048576");
            }
            shard = *parsed;
          },
          description)
      .type_name("K/N");
}

}  // namespace biss::verbs
