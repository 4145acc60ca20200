#include "cli/simulate/capture_output.hpp"

#include <algorithm>

#include "capture/event_csv.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/vcd.hpp"
#include "cli/common/message.hpp"

namespace biss::cli {

namespace {

std::unique_ptr<capture::EdgeWriter> make_writer(const std::string& path,
                                                 const std::vector<std::string>& lines,
                                                 Hertz sample_rate, capture::ByteSink& sink) {
  using capture::CsvDialect;
  if (path.ends_with(".sr")) return std::make_unique<capture::SrWriter>(lines, sample_rate, sink);
  if (CaptureOutput::is_sampled(path)) {
    return std::make_unique<capture::RawWriter>(capture::packed_layout(lines, sample_rate), sink);
  }
  if (path.ends_with(".csv")) {
    const bool saleae = path.ends_with(".saleae.csv");
    return std::make_unique<capture::EventCsvWriter>(
        lines, sink, saleae ? CsvDialect::saleae : CsvDialect::nanoseconds);
  }
  return std::make_unique<capture::VcdWriter>(lines, sink);
}

const char* cause_text(capture::WriteCause cause) {
  switch (cause) {
    case capture::WriteCause::too_many_lines:
      return "more lines than a sample has bits; write a VCD";
    case capture::WriteCause::too_large:
      return "more than the format can hold; write fewer cycles or a VCD";
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

CaptureOutput::CaptureOutput(const std::string& path, const std::vector<std::string>& lines,
                             Hertz sample_rate, Output& output)
    : output_(output), writer_(make_writer(path, lines, sample_rate, *this)) {}

bool CaptureOutput::is_sampled(const std::string& path) {
  return path.ends_with(".sr") || path.ends_with(".bin") || path.ends_with(".raw");
}

bool CaptureOutput::take(const capture::Written& written) {
  if (!written.ok()) cause_ = written.error();
  return written.ok();
}

bool CaptureOutput::write(std::span<const wire::Edge> edges) { return take(writer_->write(edges)); }

bool CaptureOutput::finish(Picoseconds end_time) { return take(writer_->finish(end_time)); }

ExitStatus CaptureOutput::status() const {
  if (!cause_ || *cause_ == capture::WriteCause::write_failed) return output_.status();
  return fail(ExitStatus::io, std::string("cannot write the capture: ") + cause_text(*cause_));
}

Hertz usual_sample_rate(Hertz clock) {
  constexpr std::uint64_t most = 4'000'000'000;
  const std::uint64_t wanted = std::uint64_t{clock.count} * 8;
  for (std::uint64_t decade = 1; decade <= most; decade *= 10) {
    for (const std::uint64_t step : {1U, 2U, 5U}) {
      if (decade * step >= wanted)
        return {static_cast<std::uint32_t>(std::min(decade * step, most))};
    }
  }
  return {static_cast<std::uint32_t>(most)};
}

}  // namespace biss::cli
