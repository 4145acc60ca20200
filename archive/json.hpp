// JSON of this room: numbers of any size. The from_json() functions throw a std::exception with a
// description of the first fault.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

#include "archive/entry.hpp"
#include "report/text.hpp"

namespace biss::archive {

/// Objects keep the order in which they were made.
using Json = nlohmann::ordered_json;

/// Above 2^53 a string, as JSON numbers are doubles elsewhere.
Json json_of(std::uint64_t value);
void to_json(Json& json, const Histogram& histogram);
Json json_of(const Counts& counts);
/// Includes the histograms if the link has any.
void to_json(Json& json, const LinkEntry& link);
void to_json(Json& json, const FileEntry& entry);

/// A text, or null if it is empty.
inline Json text_or_null(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

[[noreturn]] inline void wrong_json(const std::string& what) { throw std::runtime_error(what); }

/// The text of text_or_null().
std::string text_from(const Json& json);
/// The number of json_of(), at most `most`; `name` is for the message.
std::uint64_t number_from(const Json& json, std::string_view name,
                          std::uint64_t most = std::numeric_limits<std::uint64_t>::max());
inline std::uint64_t member_number(const Json& object, std::string_view name,
                                   std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) {
  return number_from(object.at(name), name, most);
}
void from_json(const Json& json, Histogram& histogram);
Counts counts_from(const Json& json);
void from_json(const Json& json, LinkEntry& link);
void from_json(const Json& json, FileEntry& entry);

}  // namespace biss::archive
