// GHW files for tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "wire/edge.hpp"

namespace biss::capture {

/// Writes numbers of a GHW.
class GhwText {
 public:
  explicit GhwText(bool big_endian) : big_endian_(big_endian) {}

  void put(std::string_view bytes) { text_ += bytes; }
  void byte(unsigned value) { text_ += static_cast<char>(value); }
  void word(std::uint32_t value) { fixed(value, 4); }
  void time(std::uint64_t value) { fixed(value, 8); }
  void number(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7U) byte(static_cast<unsigned>(value & 0x7FU) | 0x80U);
    byte(static_cast<unsigned>(value));
  }
  void signed_number(std::int64_t value) {
    for (; value < -64 || value > 63; value >>= 7U) {
      byte(static_cast<unsigned>(value & 0x7F) | 0x80U);
    }
    byte(static_cast<unsigned>(value & 0x7F));
  }
  void section(std::string_view name) {
    text_ += name;
    text_ += '\0';
    word(0);
  }
  /// Strings that share no letters.
  void strings(const std::vector<std::string>& strings) {
    section("STR");
    word(static_cast<std::uint32_t>(strings.size()));
    word(0);
    for (const std::string& string : strings) put(string + '\0');
    put(std::string_view("EOS\0", 4));
  }
  const std::string& text() const { return text_; }

 private:
  void fixed(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
      byte(static_cast<unsigned>(value >> (8 * (big_endian_ ? bytes - 1 - i : i)) & 0xFFU));
    }
  }

  bool big_endian_;
  std::string text_;
};

/// The beginning of a file.
inline GhwText ghw_start(unsigned version = 1, bool big_endian = false) {
  GhwText text(big_endian);
  text.put(std::string_view("GHDLwave\n\x10\0", 11));
  text.byte(version);
  text.byte(big_endian ? 2 : 1);
  text.put(std::string_view("\4\1\0", 3));
  return text;
}

inline const std::vector<std::string> ghw_levels{"'U'", "'X'", "'0'", "'1'", "'Z'",
                                                 "'W'", "'L'", "'H'", "'-'"};

/// Each line as a std_ulogic in the scope `tb`. Times are in picoseconds in the edges.
inline std::string ghw_of(const std::vector<std::string>& names,
                          const std::vector<wire::Edge>& edges, unsigned version = 1,
                          bool big_endian = false) {
  GhwText text = ghw_start(version, big_endian);
  std::vector<std::string> strings = ghw_levels;
  strings.insert(strings.end(), {"std_ulogic", "tb"});
  const auto first_name = static_cast<unsigned>(strings.size() + 1);
  strings.insert(strings.end(), names.begin(), names.end());
  text.strings(strings);
  text.section("TYP");
  text.word(1);
  text.put("\x17\x0A\x09\1\2\3\4\5\6\7\x08\x09");
  text.byte(0);
  text.section("WKT");
  text.put(std::string_view("\3\1\0", 3));
  text.section("HIE");
  for (const std::size_t count : {std::size_t{1}, names.size(), names.size()}) {
    text.word(static_cast<std::uint32_t>(count));
  }
  text.put("\6\x0B");
  for (unsigned line = 0; line < names.size(); ++line) {
    text.byte(16);
    text.number(first_name + line);
    text.number(1);
    text.number(line + 1);
  }
  text.put(std::string_view("\x0F\0EOH\0", 6));
  text.section("SNP");
  text.time(0);
  for (std::size_t line = 0; line < names.size(); ++line) text.byte(0);
  text.put(std::string_view("ESN\0CYC\0", 8));
  text.time(0);
  std::int64_t now = 0;
  std::uint32_t last = 0;
  for (const wire::Edge& edge : edges) {
    const std::int64_t time = edge.time.count * 1'000;
    if (time != now || edge.line + 1 <= last) {
      text.number(0);
      text.signed_number(time - now);
      now = time;
      last = 0;
    }
    text.number(edge.line + 1 - last);
    last = edge.line + 1;
    text.byte(edge.level == wire::Level::high ? 3 : edge.level == wire::Level::low ? 2 : 1);
  }
  text.number(0);
  text.signed_number(-1);
  text.put(std::string_view("ECY\0DIR\0", 8));
  text.word(0);
  text.word(0);
  text.put(std::string_view("EOD\0TAI\0", 8));
  text.word(0);
  text.word(0);
  return text.text();
}

}  // namespace biss::capture
