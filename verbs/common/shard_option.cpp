#include "verbs/common/shard_option.hpp"

#include <algorithm>
#include <optional>

#include "report/text.hpp"

namespace biss::verbs {

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

Option add_shard_option(Verb verb, lab::Shard& shard, const std::string& description) {
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
