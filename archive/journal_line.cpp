// A line of the journal: a checksum, then the entry as JSON.
#include <fmt/format.h>

#include <exception>

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
                  {"entry", stamped.entry}};
  const std::string text = text_of(json);
  return checksum_of(text) + ' ' + text;
}

tl::expected<StampedEntry, std::string> read_journal_line(std::string_view line) {
  if (line.size() < checksum_digits + 1) return tl::unexpected(std::string("it ends early"));
  const std::string_view text = line.substr(checksum_digits + 1);
  if (line.substr(0, checksum_digits + 1) != checksum_of(text) + ' ') {
    return tl::unexpected(std::string("its checksum is wrong"));
  }
  try {
    const Json json = Json::parse(text);
    const auto time = whole_number<std::int64_t>(json.at("time_ns").get<std::string>());
    if (!time) wrong_json("'time_ns' is not a time");
    StampedEntry stamped{{member_number(json, "bytes"), *time}, json.at("entry").get<FileEntry>()};
    for (const LinkEntry& link : stamped.entry.links) {
      if (link.histograms.empty()) wrong_json("'histograms' is missing");
    }
    return stamped;
  } catch (const std::exception& error) {
    return tl::unexpected(std::string(error.what()));
  }
}

}  // namespace biss::archive
