// Runs the benchmarks and prints one table.
//
//   biss_bench [--write FILE]… [options of Google Benchmark, such as --benchmark_filter=REGEX]
//
// --write puts the table into FILE too, between two lines `<!-- bench-table -->`.
#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "bench/rows.hpp"

namespace biss::bench {

namespace {

class TableReporter final : public benchmark::BenchmarkReporter {
 public:
  explicit TableReporter(Table& table) : table_(&table) {}
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) table_->take(run);
  }

 private:
  Table* table_;
};

std::string with_circumstances(const std::string& table) {
  return "\n" + table + "\n" + circumstances() +
         "; processor time,\nmedian and best of the repetitions.\n\n";
}

// Returns false if the two markers are not there.
bool replace_between(std::string& text, const std::string& marker, const std::string& table) {
  const std::size_t first = text.find(marker);
  if (first == std::string::npos) return false;
  const std::size_t begin = first + marker.size();
  const std::size_t end = text.find(marker, begin);
  if (end == std::string::npos) return false;
  text.replace(begin, end - begin, with_circumstances(table));
  return true;
}

bool write_into(const std::string& path, const Table& table) {
  std::ifstream in(path);
  std::stringstream buffer;
  buffer << in.rdbuf();
  std::string text = buffer.str();
  if (!in || !replace_between(text, "<!-- bench-table -->", table.text())) return false;
  return static_cast<bool>(std::ofstream(path) << text);
}

// Removes --write from the arguments. Later options override earlier ones.
std::vector<std::string> arguments(int count, char** values, std::vector<std::string>& files) {
  std::vector<std::string> kept{values[0], "--benchmark_repetitions=9", "--benchmark_min_time=0.05",
                                "--benchmark_enable_random_interleaving=true"};
  for (int i = 1; i < count; ++i) {
    if (std::strcmp(values[i], "--write") == 0 && i + 1 < count) {
      files.emplace_back(values[++i]);
    } else {
      kept.emplace_back(values[i]);
    }
  }
  return kept;
}

int run(int count, char** values) {
  std::vector<std::string> files;
  std::vector<std::string> kept = arguments(count, values, files);
  std::vector<char*> pointers;
  for (std::string& argument : kept) pointers.push_back(argument.data());
  int left = static_cast<int>(pointers.size());
  benchmark::Initialize(&left, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(left, pointers.data())) return 2;

  Table table;
  add_frame_rows(table);
  add_crc_rows(table);
  add_core_rows(table);
  add_capture_rows(table);
  add_row_rows(table);
  add_samples_rows(table);
  add_sim_rows(table);
  add_campaign_rows(table);
  add_command_rows(table);
  TableReporter reporter(table);
  benchmark::RunSpecifiedBenchmarks(&reporter);

  fmt::print("{}\n{}\n", circumstances(), table.text());
  for (const std::string& error : table.errors()) fmt::print(stderr, "bench: {}\n", error);
  for (const std::string& file : files) {
    if (write_into(file, table)) continue;
    fmt::print(stderr, "bench: cannot put the table into {}\n", file);
    return 1;
  }
  return table.errors().empty() ? 0 : 1;
}

}  // namespace

}  // namespace biss::bench

int main(int count, char** values) { return biss::bench::run(count, values); }
