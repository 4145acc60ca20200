#include <optional>

#include "firmware/cost/row.hpp"

// Volatile, so that the format is unknown to the compiler.
static const biss::FrameFormat* volatile hidden = &cost::format;
static std::optional<biss::SpiReader<cost::Codec>> reader;

BISS_ROW(spi_program, "program: make a reader of a run-time format, read a buffer", buffer) {
  reader.emplace(cost::Codec(*hidden), cost::setup, biss::DeviceTiming{});
  const auto frame = reader->read(s.span());
  return frame.ok() && frame->trusted() ? frame->channel_list[0].position : ~std::uint64_t{0};
}
