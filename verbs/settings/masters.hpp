// Drives, controllers and chips that read BiSS C: their parameters for the frame format. The data is
// in masters.txt, which describes it; exchange.hpp converts a format to settings and back with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace biss::verbs {

enum class Form : std::uint8_t { decimal, microseconds, power, hexadecimal, word, dollar };

/// One line of masters.txt. All text is static.
struct Parameter {
  std::string_view key;  ///< empty: a limit that no parameter has
  std::string_view name;
  std::string_view term;
  std::int64_t low = 0;
  std::int64_t high = INT64_MAX;
  std::string_view known;
  std::optional<std::int64_t> fallback{};
  Form form = Form::decimal;
  std::string_view before{};
  unsigned shift = 0;
  unsigned bits = 0;                             ///< 0: not a part of a word
  std::map<std::int64_t, std::int64_t> codes{};  ///< all values; of clocks, in hertz
  std::int64_t base = 0;
  std::int64_t unit = 0;
  std::int64_t steps = 1'000'000;  ///< of a time, in a second
  bool may_be_negative = false;
  std::optional<std::int64_t> sure{};  ///< the value for which there is no doubt
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
  /// The beginning of its keys, and of the same keys of other channels.
  std::vector<std::string_view> channels{};
  /// The lines of the table with these words.
  std::string_view free{};
  std::string_view assumed{};

  /// The settings leave the fact open: `arrangement`, `polynomial` (its form is not known), `crc`
  /// (it is not checked), `status` or `warning` bits, or the master can do `more` than its rows.
  bool open(std::string_view fact) const { return free.find(fact) != std::string_view::npos; }
  bool any_polynomial() const { return open("crc") || open("polynomial"); }
  /// No source has its `crc`, or what it does with the `status` bits.
  bool assumes(std::string_view fact) const { return assumed.find(fact) != std::string_view::npos; }
  /// How many of the two bits before the CRC it evaluates; the rest may have any meaning.
  std::size_t status_needed() const { return open("status") ? 0 : open("warning") ? 1 : 2; }
  /// The first row with this term. Null if there is none.
  const Parameter* find(std::string_view term) const;
  /// Each once.
  std::vector<std::string> keys() const;
};

/// The text of masters.txt.
extern const char* const masters_table;

const std::vector<Master>& masters();

/// Equal but for the case of letters.
bool same_text(std::string_view a, std::string_view b);

/// The master of this name, in any letter case; a VerbError (wrong usage) with the reason if there is none.
const Master& master_of(std::string_view name);

}  // namespace biss::verbs
