#include "verbs/simulate/positions.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <istream>
#include <string_view>

#include "biss/base/bits.hpp"
#include "device/quantity.hpp"
#include "dump/text.hpp"

namespace biss::verbs {

namespace {

constexpr std::size_t max_positions = 1'000'000;

using Positions = tl::expected<std::vector<std::uint64_t>, VerbError>;

tl::unexpected<VerbError> wrong_positions(const std::string& text) {
  return tl::make_unexpected(VerbError{ExitStatus::io, text});
}

Positions read_position_lines(const std::string& path, std::istream& stream, unsigned bits) {
  std::vector<std::uint64_t> positions;
  dump::LineSource lines(stream, {});
  const auto at_line = [&](std::uint64_t number, std::string_view what) {
    return wrong_positions(fmt::format("{}: line {}: {}", path, number, what));
  };
  while (lines.next()) {
    const std::string_view line = lines.line();
    const std::string_view text = dump::trimmed(line.substr(0, line.find('#')));
    if (text.empty()) continue;
    if (positions.size() == max_positions) {
      return at_line(lines.number(), fmt::format("more than {} positions", max_positions));
    }
    const auto position = parse_count(text, low_mask(bits));
    if (!position.ok()) {
      return at_line(lines.number(),
                     quantity_error_text(Quantity::count, text, position.error(), low_mask(bits)));
    }
    positions.push_back(*position);
  }
  if (lines.error()) {
    return at_line(lines.error()->line,
                   lines.error()->cause == dump::DumpCause::line_too_long
                       ? fmt::format("longer than {} bytes", dump::max_line_bytes)
                       : "cannot be read");
  }
  if (positions.empty()) return wrong_positions(fmt::format("{}: no position", path));
  return positions;
}

}  // namespace

Positions read_positions(const std::string& path, unsigned bits) {
  if (path == "-") return read_position_lines("standard input", std::cin, bits);
  std::error_code ignored;
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path, ignored)) {
    return wrong_positions(fmt::format("--positions: cannot open '{}'", path));
  }
  return read_position_lines(path, file, bits);
}

}  // namespace biss::verbs
