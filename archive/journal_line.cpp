// A line of the journal: a checksum, then the entry as JSON.
#include <fmt/format.h>

#include <charconv>

#include "archive/hash.hpp"
#include "archive/json.hpp"

namespace biss::archive {

namespace {

constexpr std::size_t checksum_digits = 16;

std::string checksum_of(std::string_view text) { return fmt::format("{:016x}", hash_of(text)); }

}  // namespace

std::string journal_line(const StampedEntry& stamped) {
  // Times before 1970 are negative, so the time is text.
  const Json json{{"bytes", json_of(stamped.stamp.bytes)},
                  {"time_ns", fmt::format("{}", stamped.stamp.time)},
                  {"entry", json_of(stamped.entry)}};
  const std::string text = text_of(json);
  return checksum_of(text) + ' ' + text;
}

tl::expected<StampedEntry, std::string> read_journal_line(std::string_view line) {
  if (line.size() < checksum_digits + 1) return tl::unexpected(std::string("it ends early"));
  const std::string_view text = line.substr(checksum_digits + 1);
  if (line.substr(0, checksum_digits + 1) != checksum_of(text) + ' ') {
    return tl::unexpected(std::string("its checksum is wrong"));
  }
  const Json json = Json::parse(text, nullptr, false);
  JsonReader reader;
  StampedEntry stamped;
  stamped.stamp.bytes = reader.number(json, "bytes");
  const std::string time = reader.text(json, "time_ns");
  const auto [rest, error] =
      std::from_chars(time.data(), time.data() + time.size(), stamped.stamp.time);
  if (error != std::errc() || rest != time.data() + time.size())
    reader.fail("'time_ns' is no time");
  stamped.entry = reader.entry(reader.member(json, "entry"));
  for (const LinkEntry& link : stamped.entry.links) {
    if (link.histograms.empty()) reader.fail("'histograms' is missing");
  }
  if (!reader.good()) return tl::unexpected(reader.error());
  return stamped;
}

}  // namespace biss::archive
