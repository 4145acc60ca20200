// Text of `[section]` and `key=value` rows, as the archives of sigrok and DSView hold it.
#pragma once

#include <charconv>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "biss/base/units.hpp"
#include "capture/edge_source.hpp"

namespace biss::capture {

/// `text` with \s, \n, \t, \r and doubled backslashes for characters that cannot stand in a value.
std::string escaped(std::string_view text);

/// Decimal digits and nothing else.
template <class Number>
std::optional<Number> whole_number(std::string_view text) {
  Number number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failed != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// `100 MHz`, `12.5 MHz`, `2000000`: hertz, kilohertz, megahertz or gigahertz, with or without
/// `Hz`, rounded to the hertz. 0 Hz for a text that is not a rate, or beyond 4.29 GHz.
Hertz parse_sample_rate(std::string_view text);

/// The rate with the largest unit in which it is whole. \pre rate is not 0 Hz
std::string sample_rate_text(Hertz rate);

/// Reads a description of samples, row by row. A format adds its sections, its keys and complete().
class SamplesDescription {
 public:
  virtual ~SamplesDescription() = default;

 protected:
  static constexpr unsigned most_probes = 64;

  /// How a format writes its rows.
  struct Style {
    const char* part;  ///< CaptureError::part
    const char* row;   ///< a valid row
    unsigned first_probe;
    const char* probes;  ///< the valid probes
  };

  explicit SamplesDescription(const Style& style) : style_(style) {}

  /// Reads all rows; the first error.
  std::optional<CaptureError> read(std::string_view text);
  /// Notes that this is expected in the row; returns false.
  bool wrong(const char* expected, CaptureCause cause = CaptureCause::malformed);

  /// The row `[section]`.
  virtual bool begin_section(std::string_view row) = 0;
  /// A key of the section; here a key that all formats have.
  virtual bool take_key(std::string_view key, std::string_view value);
  /// The last section has ended: everything must be there.
  virtual bool complete() = 0;

  bool done_ = false;  // complete; other sections are not read
  std::string capture_file_;
  Hertz rate_;
  std::map<unsigned, std::string> probes_;  // names, by the numbers of the probes

 private:
  bool read_row(std::string_view row);

  Style style_;
  std::uint64_t line_ = 0;
  CaptureError error_;
};

}  // namespace biss::capture
