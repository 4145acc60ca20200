// The JSON of a summary, read: every figure is checked before it is used.
#include <exception>
#include <sstream>
#include <utility>

#include "archive/hash.hpp"
#include "archive/json.hpp"
#include "archive/summary.hpp"

namespace biss::archive {

namespace {

constexpr std::uint64_t version_read = 1;
constexpr std::uint64_t most_parts = std::uint64_t{1} << 20U;

Parts read_parts(const Json& json) {
  Parts parts;
  parts.count = member_number(json, "count", most_parts);
  for (const Json& each : json.at("done")) {
    const std::uint64_t part = number_from(each, "done", parts.count);
    if (part == 0 || !parts.done.insert(part).second) wrong_json("'done' has a wrong shard");
  }
  if (parts.count == 0 || parts.done.empty()) wrong_json("'shards' has no shard");
  return parts;
}

void read_group(const Json& json, Summary& summary) {
  GroupKey key{json.at("folder"), json.at("ma"), json.at("slo"), text_from(json.at("format"))};
  Group group{
      .captures = member_number(json, "captures"), .counts = counts_from(json), .histograms = {}};
  for (std::size_t i = 0; i < quantity_count; ++i) {
    json.at(name_of(static_cast<Quantity>(i))).get_to(group.histograms[i]);
  }
  if (!summary.groups.emplace(std::move(key), std::move(group)).second) {
    wrong_json("an encoder is listed twice");
  }
}

// Checks that the sums of the groups match the files, and that the files match the list.
void compare_sums(const Summary& summary) {
  std::map<GroupKey, Group> sums;
  ListMark list;
  for (const FileEntry& file : summary.files) {
    list.add(file.path);
    for (const LinkEntry& link : file.links) {
      Group& group = sums[group_of(file, link)];
      ++group.captures;
      group.counts.add(link.counts);
    }
  }
  if (list.files != summary.parts.files_of(summary.list.files)) {
    wrong_json(fmt::format("it has {} files, its shards have {}", list.files,
                           summary.parts.files_of(summary.list.files)));
  }
  if (summary.parts.complete() && list != summary.list) {
    wrong_json("its files do not match its list");
  }
  const bool same = sums.size() == summary.groups.size() &&
                    std::equal(sums.begin(), sums.end(), summary.groups.begin(),
                               [](const auto& a, const auto& b) {
                                 return a.first == b.first &&
                                        a.second.captures == b.second.captures &&
                                        a.second.counts == b.second.counts;
                               });
  if (!same) wrong_json("the figures of its encoders are not the sums of its files");
}

Summary summary_from(std::string_view text) {
  using Event = Json::parse_event_t;
  Summary summary;
  std::string key;
  // There are many files: each is taken as soon as it is complete, so that its JSON needs no
  // memory.
  const auto take = [&](int depth, Event event, Json& parsed) {
    if (event == Event::key && depth == 1) key = parsed.get<std::string>();
    if (event != Event::object_end || depth != 2) return true;
    if (key == "files") summary.files.push_back(parsed);
    if (key == "encoders") read_group(parsed, summary);
    return key != "files" && key != "encoders";
  };
  const Json json = Json::parse(text, take, false);
  if (json.is_discarded()) wrong_json("it is not JSON, or ends early");
  if (!json.is_object() || !json.contains("biss_archive")) {
    wrong_json("it is not a summary of biss archive");
  }
  if (const std::uint64_t version = member_number(json, "biss_archive"); version != version_read) {
    wrong_json(
        fmt::format("its version is {}, this program reads version {}", version, version_read));
  }
  summary.setup = {json.at("program"), json.at("settings")};
  const Json& list = json.at("list");
  const auto hash = report::number_in<std::uint64_t>(list.at("hash").get<std::string>(), 16);
  if (!hash) wrong_json("'hash' is not a hexadecimal number");
  summary.list = {member_number(list, "files"), *hash};
  summary.parts = read_parts(json.at("shards"));
  compare_sums(summary);
  if (!checksum_holds(text)) wrong_json(std::string(checksum_wrong));
  return summary;
}

}  // namespace

tl::expected<Summary, std::string> read_summary(std::istream& text) {
  try {
    // Any other file, such as a capture, may be larger than the memory.
    if (text.peek() != '{') wrong_json("it is not JSON, or ends early");
    std::ostringstream all;
    all << text.rdbuf();
    return summary_from(std::move(all).str());
  } catch (const std::exception& error) {
    return tl::unexpected(std::string(error.what()));
  }
}

}  // namespace biss::archive
