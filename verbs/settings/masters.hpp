// Drives, controllers and chips that read BiSS C: their parameters for the frame format. The data is
// in masters.txt, which describes it; exchange.hpp converts a format to settings and back with it.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace biss::verbs {

enum class Form : std::uint8_t { decimal, hexadecimal, word, dollar, microseconds };

/// One line of masters.txt. All text is static.
struct Parameter {
  std::string_view key;  ///< empty: a limit that no parameter has
  std::string_view name;
  std::string_view term;
  std::uint64_t low = 0;
  std::uint64_t high = UINT64_MAX;
  std::string_view known;
  std::optional<std::uint64_t> fallback{};
  Form form = Form::decimal;
  std::string_view before{};
  unsigned shift = 0;
  unsigned bits = 0;                                             ///< 0: not a part of a word
  std::vector<std::pair<std::uint64_t, std::uint32_t>> codes{};  ///< of clocks, in hertz
  std::uint32_t base = 0;
  std::uint32_t unit = 0;
  std::vector<std::string_view> names{};
  std::string_view doubt{};

  bool uncertain() const { return known == "inferred" || known == "not known"; }
};

struct Master {
  std::string_view name;
  std::string_view product;
  std::string_view place{};
  std::string_view source{};
  std::string_view note{};
  std::vector<Parameter> parameters{};
  /// Whether it evaluates error and warning; else these bits may have any meaning.
  bool error_evaluated = true;
  bool warning_evaluated = true;
  /// Only the number of bits is set, in any arrangement.
  bool any_arrangement = false;
  /// The form of the polynomial is not known, or the CRC is not checked.
  bool any_crc = false;

  /// The first row with this term. Null if there is none.
  const Parameter* find(std::string_view term) const;
};

/// The text of masters.txt.
extern const char* const masters_table;

const std::vector<Master>& masters();

/// The master of this name; a VerbError (wrong usage) with the reason if there is none.
const Master& master_of(std::string_view name);

}  // namespace biss::verbs
