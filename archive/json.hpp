// JSON of this room: numbers of any size, and reading that names the first thing that is wrong.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "archive/entry.hpp"

namespace biss::archive {

/// Objects keep the order in which they were made.
using Json = nlohmann::ordered_json;

/// Above 2^53 a string, as JSON numbers are doubles elsewhere.
Json json_of(std::uint64_t value);
Json json_of(const Histogram& histogram);
Json json_of(const Counts& counts);
/// With the histograms, where it has some.
Json json_of(const LinkEntry& link);
Json json_of(const FileEntry& entry);

/// One line, as all texts of this room. \pre its texts are valid UTF-8
inline std::string text_of(const Json& json) { return json.dump(); }

/// Reads members of objects. After the first wrong one, error() says what it is; values read are
/// then empty and mean nothing.
class JsonReader {
 public:
  const std::string& error() const { return error_; }
  bool good() const { return error_.empty(); }
  void fail(std::string what) {
    if (error_.empty()) error_ = std::move(what);
  }

  /// An empty object where it is missing.
  const Json& member(const Json& object, std::string_view name);
  /// A list, or an empty one.
  const Json& list(const Json& object, std::string_view name);
  std::string text(const Json& object, std::string_view name);
  std::vector<std::string> texts(const Json& object, std::string_view name);
  std::uint64_t number(const Json& object, std::string_view name,
                       std::uint64_t most = std::numeric_limits<std::uint64_t>::max());
  /// An element of a list.
  std::uint64_t element(const Json& list, std::size_t at, std::string_view name,
                        std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

  Counts counts(const Json& object);
  Histogram histogram(const Json& object);
  LinkEntry link(const Json& object);
  FileEntry entry(const Json& object);

 private:
  std::uint64_t value(const Json& json, std::string_view name, std::uint64_t most);

  std::string error_;
};

}  // namespace biss::archive
