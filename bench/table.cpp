#include "bench/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <utility>

namespace biss::bench {

namespace {

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    const auto colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

std::string shown(double value, Unit unit) {
  if (unit == Unit::nanoseconds) {
    if (value >= 100) return fmt::format("{:.0f} ns", value);
    return fmt::format("{:.{}f} ns", value, value < 10 ? 2 : 1);
  }
  const char* name = unit == Unit::megabytes ? "MB/s" : "million/s";
  return fmt::format("{:.{}f} {}", value, value < 10 ? 2 : 0, name);
}

// The reference without the parts that it has in common with the row's own name.
std::string short_reference(const std::string& row, const std::string& reference) {
  const auto differ = std::mismatch(row.begin(), row.end(), reference.begin(), reference.end());
  const std::string common(row.begin(), differ.first);
  const std::string ending(differ.second, reference.end());
  if (differ.first == row.end() && ending.starts_with(", ")) return ending.substr(2);
  const auto comma = common.rfind(", ");
  return comma == std::string::npos ? reference : reference.substr(comma + 2);
}

}  // namespace

void Table::add(Row row, std::function<void(benchmark::State&)> run) {
  auto* registered = benchmark::RegisterBenchmark(
      row.name.c_str(), [work = std::move(run)](benchmark::State& state) { work(state); });
  if (row.own_time) registered->UseManualTime();
  rows_.push_back(std::move(row));
}

void Table::take(const benchmark::BenchmarkReporter::Run& run) {
  const std::string name = run.run_name.function_name;
  if (run.error_occurred) {
    errors_.push_back(name + ": " + run.error_message);
    return;
  }
  if (run.run_type != benchmark::BenchmarkReporter::Run::RT_Iteration) return;
  for (const char* counter : {"items_per_second", "bytes_per_second"}) {
    const auto found = run.counters.find(counter);
    if (found != run.counters.end()) rates_[name].push_back(found->second.value);
  }
}

bool Table::has(const std::string& name) const { return rates_.count(name) != 0; }

Table::Figure Table::figure_of(const Row& row) const {
  std::vector<double> rates = rates_.at(row.name);
  std::sort(rates.begin(), rates.end());
  const double median = rates[rates.size() / 2];
  const double best = rates.back();
  if (row.unit == Unit::nanoseconds) return {1e9 / median, 1e9 / best};
  return {median / 1e6, best / 1e6};
}

std::string Table::line_of(const Row& row) const {
  const Figure figure = figure_of(row);
  std::string ratio;
  const auto reference = std::find_if(
      rows_.begin(), rows_.end(), [&](const Row& other) { return other.name == row.reference; });
  if (reference != rows_.end() && has(reference->name)) {
    const double other = figure_of(*reference).median;
    const double times =
        row.unit == Unit::nanoseconds ? other / figure.median : figure.median / other;
    ratio = fmt::format("{:.{}f} × {}", times, times < 10 ? 2 : 0,
                        short_reference(row.name, reference->name));
  }
  std::string target;
  if (row.target != 0) {
    target = row.unit == Unit::nanoseconds ? fmt::format("≤ {:g} ns", row.target)
                                           : fmt::format("≥ {:g} million/s", 1000 / row.target);
  }
  if (row.share != 0) target = fmt::format("≥ {:.2f} ×", 1 / row.share);
  return fmt::format("| {} | {} | {} | {} | {} |\n", row.name, shown(figure.median, row.unit),
                     shown(figure.best, row.unit), target, ratio);
}

std::string Table::text() const {
  std::string out =
      "| what | median | best | target | speed against the reference |\n"
      "|---|---:|---:|---:|---|\n";
  for (const Row& row : rows_) {
    if (has(row.name)) out += line_of(row);
  }
  return out;
}

std::string circumstances() {
  return fmt::format("{}, {} {}", processor(), BISS_BENCH_COMPILER, BISS_BENCH_FLAGS);
}

}  // namespace biss::bench
