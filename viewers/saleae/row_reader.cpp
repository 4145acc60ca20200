#include "viewers/saleae/row_reader.hpp"

#include <array>
#include <utility>

#include "biss/configure/named_device.hpp"

namespace biss::saleae {

namespace {

// The sample period, rounded up, as in `biss decode` for a capture of samples.
decode::MarginSetup margin_of(Hertz rate) {
  const std::int64_t count = rate.count;
  return {.resolution = picoseconds((picoseconds_per_second + count - 1) / count)};
}

}  // namespace

tl::expected<void, std::string> set_format(RowSetup& setup, std::string_view format) {
  if (format.empty() || format == "none") {
    setup.format.reset();
    setup.timing = {};
    return {};
  }
  const auto device = read_device(format);
  if (!device.ok()) {
    return tl::make_unexpected("Frame format, character " +
                               std::to_string(device.error().item.at + 1) + ": " +
                               std::string(biss::text_of(device.error())));
  }
  setup.format = device->format;
  setup.timing = device->timing;
  return {};
}

RowReader::RowReader(const RowSetup& setup, Hertz rate, OnRow on_row)
    : clock_(rate),
      lines_{.ma = ma_line,
             .slo = slo_line,
             .ma_inverted = setup.ma_inverted,
             .slo_inverted = setup.slo_inverted},
      on_row_(std::move(on_row)),
      table_(setup.format),
      limits_(setup.timing, margin_of(rate).resolution),
      needs_next_(setup.format && setup.format->needs_previous()),
      cycles_(std::make_shared<std::vector<decode::Cycle>>()),
      decoder_(decode::CycleReader(setup.format, setup.timing, margin_of(rate)),
               [cycles = cycles_](const decode::Cycle& cycle) { cycles->push_back(cycle); }) {}

void RowReader::push(wire::LineIndex line, std::uint64_t sample, bool level) {
  if (sample > clock_.last_index()) return;
  const std::array edges{
      wire::Edge{clock_.time_of(sample), line, level ? wire::Level::high : wire::Level::low}};
  decoder_.push(edges, lines_);
  deliver();
}

void RowReader::deliver() {
  for (const decode::Cycle& cycle : *cycles_) {
    if (ahead_ != 0) {
      --ahead_;
    } else {
      deliver(cycle);
    }
  }
  cycles_->clear();
}

void RowReader::rest_until(std::uint64_t sample) {
  if (needs_next_ || ahead_ != 0 || sample > clock_.last_index()) return;
  decode::Decoder copy = decoder_;
  copy.finish(clock_.time_of(sample));
  const std::size_t count = cycles_->size();
  deliver();
  ahead_ = count;
}

void RowReader::deliver(const decode::Cycle& cycle) {
  on_row_({.status = cycle.status,
           .columns = table_.columns(),
           .cells = table_.cells(number_++, cycle, std::nullopt, limits_.judge(cycle)),
           .first_sample = clock_.first_at_or_after(cycle.time),
           .last_sample = clock_.first_at_or_after(cycle.time + cycle.clocked)});
}

}  // namespace biss::saleae
