#include "verbs/common/capture_output.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "capture/dsl.hpp"
#include "capture/event_csv.hpp"
#include "capture/saleae_binary.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/vcd.hpp"
#include "device/quantity.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {

namespace {

std::unique_ptr<capture::EdgeWriter> make_writer(CaptureFormat format,
                                                 const std::vector<std::string>& lines, Hertz rate,
                                                 capture::ByteSink& sink) {
  using capture::CsvDialect;
  switch (format) {
    case CaptureFormat::event_csv:
      return std::make_unique<capture::EventCsvWriter>(lines, sink, CsvDialect::nanoseconds);
    case CaptureFormat::saleae_csv:
      return std::make_unique<capture::EventCsvWriter>(lines, sink, CsvDialect::saleae);
    case CaptureFormat::saleae_binary:
      return std::make_unique<capture::SaleaeBinaryWriter>(lines, rate, sink);
    case CaptureFormat::sr:
      return std::make_unique<capture::SrWriter>(lines, rate, sink);
    case CaptureFormat::raw:
      return std::make_unique<capture::RawWriter>(capture::packed_layout(lines, rate), sink);
    case CaptureFormat::dsl:
      return std::make_unique<capture::DslWriter>(lines, rate, sink);
    case CaptureFormat::vcd:
      break;
  }
  return std::make_unique<capture::VcdWriter>(lines, sink);
}

const char* cause_text(capture::WriteCause cause, CaptureFormat format) {
  switch (cause) {
    case capture::WriteCause::too_many_lines:
      return format == CaptureFormat::saleae_binary
                 ? "a file of Saleae's binary export holds one line; write a file for each line"
                 : "more lines than a sample has bits; write a VCD";
    case capture::WriteCause::too_large:
      return "more than the format can hold; write less of it, or a VCD";
    case capture::WriteCause::time_before_zero:
      return "times before zero, which the format cannot hold; write an event CSV";
    case capture::WriteCause::no_such_line:
    case capture::WriteCause::time_backwards:
    case capture::WriteCause::write_failed:
      break;
  }
  return "edges that no capture can hold";
}

}  // namespace

std::optional<CaptureFormat> capture_format_of(std::string_view path) {
  // The longest matching extension is used.
  for (const CaptureFormat format :
       {CaptureFormat::saleae_csv, CaptureFormat::saleae_binary, CaptureFormat::vcd,
        CaptureFormat::event_csv, CaptureFormat::sr, CaptureFormat::raw, CaptureFormat::dsl}) {
    if (path.ends_with(text_of(format).extension)) return format;
  }
  if (path.ends_with(".raw")) return CaptureFormat::raw;
  return std::nullopt;
}

bool is_only_read(std::string_view path) {
  constexpr std::array<std::string_view, 6> extensions{".fst", ".sal", ".gz",
                                                       ".zst", ".xz",  ".bz2"};
  return std::any_of(extensions.begin(), extensions.end(),
                     [path](std::string_view extension) { return path.ends_with(extension); });
}

const CaptureFormatText& text_of(CaptureFormat format) {
  return capture_formats[static_cast<std::size_t>(format)];
}

bool is_sampled(CaptureFormat format) {
  return format == CaptureFormat::sr || format == CaptureFormat::raw ||
         format == CaptureFormat::dsl;
}

bool holds_negative_times(CaptureFormat format) {
  return !is_sampled(format) && format != CaptureFormat::vcd;
}

CaptureOutput::CaptureOutput(CaptureFormat format, const std::vector<std::string>& lines,
                             Hertz sample_rate, Output& output)
    : output_(output), format_(format), writer_(make_writer(format, lines, sample_rate, *this)) {}

bool CaptureOutput::take(const capture::Written& written) {
  if (!written.ok()) cause_ = written.error();
  return written.ok();
}

bool CaptureOutput::write(std::span<const wire::Edge> edges) { return take(writer_->write(edges)); }

bool CaptureOutput::finish(Picoseconds end_time) { return take(writer_->finish(end_time)); }

ExitStatus CaptureOutput::status() const {
  if (!cause_ || *cause_ == capture::WriteCause::write_failed) return output_.status();
  return output_.host().fail(
      ExitStatus::io, std::string("cannot write the capture: ") + cause_text(*cause_, format_));
}

Hertz usual_sample_rate(Hertz clock) {
  constexpr std::uint64_t most = 4'000'000'000;
  const std::uint64_t wanted = std::uint64_t{clock.count} * 8;
  for (std::uint64_t decade = 1; decade <= most; decade *= 10) {
    for (const std::uint64_t step : {1U, 2U, 5U}) {
      if (decade * step >= wanted)
        return Hertz{static_cast<std::uint32_t>(std::min(decade * step, most))};
    }
  }
  return Hertz{static_cast<std::uint32_t>(most)};
}

void warn_of_lost_clocks(Hertz sample_rate, Hertz clock, Host& host) {
  if (sample_rate.count >= 2 * std::uint64_t{clock.count}) return;
  host.warn(
      fmt::format("--sample-rate: {} misses clocks of MA at {}; give {} or more, or leave it out",
                  text_of(sample_rate), text_of(clock), text_of(usual_sample_rate(clock))));
}

}  // namespace biss::verbs
