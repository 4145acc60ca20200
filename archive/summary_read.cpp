// The JSON of a summary, read: every figure is checked before it is used.
#include <array>
#include <charconv>
#include <streambuf>
#include <utility>

#include "archive/hash.hpp"
#include "archive/json.hpp"
#include "archive/summary.hpp"

namespace biss::archive {

namespace {

constexpr std::uint64_t version_read = 1;
constexpr std::uint64_t most_parts = std::uint64_t{1} << 20U;

// Passes a text on and hashes it, but for its last bytes, which are the checksum's.
class CheckedText : public std::streambuf {
 public:
  explicit CheckedText(std::istream& text) : text_(text) {}

  // \pre all was read
  bool checksum_holds() const { return end_ == checksum_end(hash_); }

 private:
  int_type underflow() override {
    text_.read(block_.data(), static_cast<std::streamsize>(block_.size()));
    const auto size = static_cast<std::size_t>(text_.gcount());
    if (size == 0) return traits_type::eof();
    end_.append(block_.data(), size);
    const std::size_t hashed = end_.size() - std::min(end_.size(), checksum_end(0).size());
    hash_ = hash_of(std::string_view(end_).substr(0, hashed), hash_);
    end_.erase(0, hashed);
    setg(block_.data(), block_.data(), block_.data() + size);
    return traits_type::to_int_type(block_[0]);
  }

  std::istream& text_;
  std::array<char, 65536> block_{};
  std::string end_;
  std::uint64_t hash_ = hash_of("");
};

std::uint64_t hex_number(JsonReader& reader, const std::string& digits) {
  std::uint64_t number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [rest, error] = std::from_chars(digits.data(), end, number, 16);
  if (error != std::errc() || rest != end) reader.fail("'hash' is no hexadecimal number");
  return number;
}

Parts read_parts(JsonReader& reader, const Json& object) {
  Parts parts;
  parts.count = reader.number(object, "count", most_parts);
  const Json& done = reader.list(object, "done");
  for (std::size_t i = 0; i < done.size(); ++i) {
    const std::uint64_t part = reader.element(done, i, "done", parts.count);
    if (part == 0 || !parts.done.insert(part).second) reader.fail("'done' has a wrong shard");
  }
  if (parts.count == 0 || parts.done.empty()) reader.fail("'shards' has no shard");
  return parts;
}

void read_group(JsonReader& reader, const Json& object, Summary& summary) {
  GroupKey key{
      reader.text(object, "folder"), reader.text(object, "ma"), reader.text(object, "slo"), {}};
  if (!reader.member(object, "format").is_null()) key.format = reader.text(object, "format");
  Group group;
  group.captures = reader.number(object, "captures");
  group.counts = reader.counts(object);
  for (std::size_t i = 0; i < quantity_count; ++i) {
    group.histograms[i] =
        reader.histogram(reader.member(object, name_of(static_cast<Quantity>(i))));
  }
  if (!summary.groups.emplace(std::move(key), std::move(group)).second) {
    reader.fail("an encoder is listed twice");
  }
}

// The sums of the groups are those of the files, and the files are those of the list.
void compare_sums(JsonReader& reader, const Summary& summary) {
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
    reader.fail(fmt::format("it has {} files, its shards have {}", list.files,
                            summary.parts.files_of(summary.list.files)));
  }
  if (summary.parts.complete() && list != summary.list) {
    reader.fail("its files are not those of its list");
  }
  const bool same = sums.size() == summary.groups.size() &&
                    std::equal(sums.begin(), sums.end(), summary.groups.begin(),
                               [](const auto& a, const auto& b) {
                                 return a.first == b.first &&
                                        a.second.captures == b.second.captures &&
                                        a.second.counts == b.second.counts;
                               });
  if (!same) reader.fail("the figures of its encoders are not the sums of its files");
}

}  // namespace

tl::expected<Summary, std::string> read_summary(std::istream& text) {
  using Event = Json::parse_event_t;
  Summary summary;
  JsonReader reader;
  std::string key;
  // Files are many: each is taken as soon as it is complete, so that its JSON needs no memory.
  const auto take = [&](int depth, Event event, Json& parsed) {
    if (event == Event::key && depth == 1) key = parsed.get<std::string>();
    if (event != Event::object_end || depth != 2) return true;
    if (key == "files") summary.files.push_back(reader.entry(parsed));
    if (key == "encoders") read_group(reader, parsed, summary);
    return key != "files" && key != "encoders";
  };
  CheckedText checked(text);
  std::istream stream(&checked);
  const Json json = Json::parse(stream, take, false);
  if (json.is_discarded()) return tl::unexpected(std::string("it is no JSON, or ends early"));
  if (!json.is_object() || !json.contains("biss_archive")) {
    return tl::unexpected(std::string("it is no summary of biss archive"));
  }
  const std::uint64_t version = reader.number(json, "biss_archive");
  if (reader.good() && version != version_read) {
    return tl::unexpected(
        fmt::format("its version is {}, this program reads version {}", version, version_read));
  }
  summary.setup = {reader.text(json, "program"), reader.texts(json, "settings")};
  const Json& list = reader.member(json, "list");
  summary.list = {reader.number(list, "files"), hex_number(reader, reader.text(list, "hash"))};
  summary.parts = read_parts(reader, reader.member(json, "shards"));
  reader.list(json, "encoders");
  reader.list(json, "files");
  if (reader.good()) compare_sums(reader, summary);
  if (!checked.checksum_holds()) reader.fail(std::string(checksum_wrong));
  if (!reader.good()) return tl::unexpected(reader.error());
  return summary;
}

}  // namespace biss::archive
