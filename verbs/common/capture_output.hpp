// The output of a verb's edges: the formats of captures that are written.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "biss/base/units.hpp"
#include "capture/edge_writer.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {

/// The formats of captures that are written.
enum class CaptureFormat : std::uint8_t { vcd, event_csv, saleae_csv, saleae_binary, sr, raw, dsl };

struct CaptureFormatText {
  std::string_view name;       ///< for `--to`
  std::string_view extension;  ///< that selects it
};

inline constexpr std::array<CaptureFormatText, 7> capture_formats{{{"vcd", ".vcd"},
                                                                   {"csv", ".csv"},
                                                                   {"saleae-csv", ".saleae.csv"},
                                                                   {"saleae-bin", ".saleae.bin"},
                                                                   {"sr", ".sr"},
                                                                   {"raw", ".bin"},
                                                                   {"dsl", ".dsl"}}};

const CaptureFormatText& text_of(CaptureFormat format);

/// By the extension; `.raw` is raw samples too. Nothing for any other.
std::optional<CaptureFormat> capture_format_of(std::string_view path);

/// Whether the extension belongs to captures that are read and never written: FST, Saleae sessions,
/// and compressed captures.
bool is_only_read(std::string_view path);

/// The format holds samples, not changes.
bool is_sampled(CaptureFormat format);
bool holds_negative_times(CaptureFormat format);

/// Writes edges to an Output, which outlives it, in this format.
class CaptureOutput final : public capture::ByteSink {
 public:
  /// `sample_rate` is for the sampled formats, and for Saleae's binary export, which allows 0 Hz.
  /// \pre at most 64 lines for sampled formats, and for these sample_rate is not 0 Hz
  CaptureOutput(CaptureFormat format, const std::vector<std::string>& lines, Hertz sample_rate,
                Output& output);
  CaptureOutput(const CaptureOutput&) = delete;
  CaptureOutput& operator=(const CaptureOutput&) = delete;

  /// The same as for EdgeWriter; false if writing failed; status() is then the exit status of the
  /// verb.
  bool write(std::span<const wire::Edge> edges);
  bool finish(Picoseconds end_time);
  /// Prints on stderr why writing failed, unless only the reader left.
  ExitStatus status() const;

 private:
  bool write(std::string_view bytes) override { return output_.write(bytes); }
  bool flush() override { return true; }
  bool take(const capture::Written& written);

  Output& output_;
  CaptureFormat format_;
  std::unique_ptr<capture::EdgeWriter> writer_;
  std::optional<capture::WriteCause> cause_;
};

/// A rate that analysers have, to sample a clock with: the next of 1, 2 and 5 times a power of ten
/// from eight times the clock on; 4 GHz at most. Each has a period of whole picoseconds.
Hertz usual_sample_rate(Hertz clock);

/// Warns if samples at this rate miss levels of the clock.
void warn_of_lost_clocks(Hertz sample_rate, Hertz clock, Host& host);

}  // namespace biss::verbs
