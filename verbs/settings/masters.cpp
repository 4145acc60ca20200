#include "verbs/settings/masters.hpp"

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string>

#include "device/nearest.hpp"
#include "device/quantity.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {
namespace {

struct MastersTable {
  std::vector<Master> masters;
  /// Names of products without settings, and the reason.
  std::vector<std::pair<std::string_view, std::string_view>> none;
};

// The text up to the first separator; `text` is then the rest.
std::string_view take_part(std::string_view& text, std::string_view separator) {
  const std::size_t end = std::min(text.find(separator), text.size());
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + separator.size(), text.size()));
  return part;
}

std::int64_t count_of(std::string_view text) {
  return static_cast<std::int64_t>(parse_count(text, INT64_MAX).value());
}
std::int64_t rate_of(std::string_view text) { return parse_rate(text).value().count; }

void read_table_option(std::string_view option, Parameter& row) {
  constexpr std::string_view forms[] = {"", "us", "power", "hex", "word", "$"};
  std::string_view value = option;
  const std::string_view name = take_part(value, "=");
  if (option.find(':') != std::string_view::npos) {
    const std::int64_t code = count_of(take_part(option, ":"));
    row.codes[code] = option.empty() ? 0 : rate_of(option);
  } else if (name.empty()) {
    row.fallback = count_of(value);
  } else if (name == "at") {
    row.shift = static_cast<unsigned>(count_of(take_part(value, "+")));
    row.bits = static_cast<unsigned>(count_of(value));
  } else if (name == "before") {
    row.before = value;
  } else if (name == "sure") {
    row.sure = count_of(value);
  } else if (name == "negative") {
    row.may_be_negative = true;
  } else if (!value.empty()) {
    (name == "base" ? row.base : name == "unit" ? row.unit : row.steps) = rate_of(value);
  } else {
    row.form = static_cast<Form>(std::find(forms, std::end(forms), name) - forms);
  }
}

Parameter read_table_row(std::string_view line) {
  const std::string_view key = take_part(line, " | ");
  Parameter row{.key = key == "-" ? "" : key,
                .name = take_part(line, " | "),
                .term = take_part(line, " | "),
                .low = count_of(take_part(line, "..")),
                .known = {}};
  const std::string_view high = take_part(line, " | ");
  if (!high.empty()) row.high = count_of(high);
  row.known = take_part(line, " | ");
  std::string_view options = take_part(line, "|");
  while (options.ends_with(' ')) options.remove_suffix(1);
  while (!options.empty() && !options.starts_with("names=")) {
    read_table_option(take_part(options, " "), row);
  }
  take_part(options, "=");
  while (!options.empty()) row.names.push_back(take_part(options, "/"));
  row.doubt = line.substr(std::min<std::size_t>(line.find_first_not_of(' '), line.size()));
  return row;
}

void read_table_line(std::string_view line, MastersTable& table) {
  std::string_view rest = line;
  const std::string_view word = take_part(rest, " ");
  if (word == "master") {
    const std::string_view name = take_part(rest, " ");
    table.masters.push_back({.name = name, .product = rest});
  } else if (word == "none") {
    for (std::string_view names = take_part(rest, " : "); !names.empty();) {
      table.none.emplace_back(take_part(names, " "), rest);
    }
  } else if (Master& master = table.masters.back(); word == "channels") {
    while (!rest.empty()) master.channels.push_back(take_part(rest, " "));
  } else {
    constexpr std::pair<std::string_view, std::string_view Master::*> lines[] = {
        {"place", &Master::place}, {"source", &Master::source},   {"note", &Master::note},
        {"free", &Master::free},   {"assumed", &Master::assumed},
    };
    for (const auto& [name, text] : lines) {
      if (name == word) {
        master.*text = rest;
        return;
      }
    }
    master.parameters.push_back(read_table_row(line));
  }
}

const MastersTable& read_masters() {
  static const MastersTable table = [] {
    MastersTable made;
    for (std::string_view text = masters_table; !text.empty();) {
      const std::string_view line = take_part(text, "\n");
      if (!line.empty() && !line.starts_with('#')) read_table_line(line, made);
    }
    return made;
  }();
  return table;
}

}  // namespace

const Parameter* Master::find(std::string_view term) const {
  const auto row = std::find_if(parameters.begin(), parameters.end(),
                                [&](const Parameter& each) { return each.term == term; });
  return row == parameters.end() ? nullptr : &*row;
}

std::vector<std::string> Master::keys() const {
  std::vector<std::string> keys;
  for (const Parameter& row : parameters) {
    if (!row.key.empty()) keys.emplace_back(row.key);
  }
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

bool same_text(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](char x, char y) { return lower(x) == lower(y); });
}

const std::vector<Master>& masters() { return read_masters().masters; }

const Master& master_of(std::string_view name) {
  std::vector<std::string> names;
  for (const Master& master : masters()) {
    if (same_text(name, master.name)) return master;
    names.emplace_back(master.name);
  }
  for (const auto& [none, why] : read_masters().none) {
    if (none == name) throw wrong_usage("no_settings: {}: {}", none, why);
  }
  const std::string near = nearest(std::string(name), names);
  throw wrong_usage("unknown_master: '{}'{} ('biss settings' lists all)", name,
                    near.empty() ? "" : "; did you mean " + near + "?");
}

}  // namespace biss::verbs
