#include "verbs/common/shard_option.hpp"

#include <charconv>
#include <optional>

namespace biss::verbs {

namespace {

std::optional<lab::Shard> parse_shard(const std::string& text) {
  lab::Shard shard;
  const char* end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, shard.number);
  if (number.ec != std::errc() || number.ptr == end || *number.ptr != '/') return std::nullopt;
  const auto count = std::from_chars(number.ptr + 1, end, shard.count);
  if (count.ec != std::errc() || count.ptr != end) return std::nullopt;
  if (shard.number == 0 || shard.number > shard.count) return std::nullopt;
  if (shard.count > lab::max_shards) return std::nullopt;
  return shard;
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
