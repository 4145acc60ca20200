#include "archive/figures.hpp"

namespace biss::archive {

using decode::Statistics;

namespace {

template <std::size_t size>
void add_each(std::array<std::uint64_t, size>& sum, const std::array<std::uint64_t, size>& other) {
  for (std::size_t i = 0; i < size; ++i) sum[i] += other[i];
}

}  // namespace

const decode::Distribution& distribution_of(const Statistics& statistics, Quantity quantity) {
  constexpr std::array by_quantity{&Statistics::period,     &Statistics::interval,
                                   &Statistics::line_delay, &Statistics::ack,
                                   &Statistics::ack_clocks, &Statistics::duty};
  static_assert(by_quantity.size() == quantity_count);
  return (statistics.*by_quantity[static_cast<std::size_t>(quantity)])();
}

void Counts::add(const Counts& other) {
  cycles += other.cycles;
  add_each(by_status, other.by_status);
  errors += other.errors;
  warnings += other.warnings;
  add_each(by_limit, other.by_limit);
  limited += other.limited;
  marginal += other.marginal;
  margin_judged += other.margin_judged;
}

std::uint64_t Counts::faults() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < by_status.size(); ++i) {
    if (is_fault(static_cast<CycleStatus>(i))) sum += by_status[i];
  }
  return sum;
}

CycleStatus Counts::foremost_fault() const {
  auto foremost = CycleStatus::ok;
  std::uint64_t most = 0;
  for (std::size_t i = 0; i < by_status.size(); ++i) {
    const auto status = static_cast<CycleStatus>(i);
    if (!is_fault(status) || by_status[i] <= most) continue;
    foremost = status;
    most = by_status[i];
  }
  return foremost;
}

Counts counts_of(const Statistics& statistics) {
  Counts counts;
  counts.cycles = statistics.cycles();
  for (std::size_t i = 0; i < cycle_status_count; ++i) {
    counts.by_status[i] = statistics.count(static_cast<CycleStatus>(i));
  }
  counts.errors = statistics.errors();
  counts.warnings = statistics.warnings();
  for (std::size_t i = 0; i < decode::limit_count; ++i) {
    counts.by_limit[i] = statistics.count(static_cast<decode::Limit>(i));
  }
  counts.limited = statistics.limited();
  counts.marginal = statistics.marginal();
  counts.margin_judged = statistics.margin_judged();
  return counts;
}

}  // namespace biss::archive
