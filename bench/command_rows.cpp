// The command as a whole process: start, reading the file, writing the rows.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include "bench/line.hpp"
#include "bench/rows.hpp"
#include "bench/samples.hpp"

namespace biss::bench {

namespace {

constexpr std::size_t command_cycles = 20'000;

// A temporary folder, removed by the destructor.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "biss-bench-XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }

  bool good() const { return !path_.empty(); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

void decode(benchmark::State& state, const std::string& extension) {
  const Line line = make_line(command_cycles);
  const Folder folder;
  if (!folder.good()) return state.SkipWithError("no temporary folder");
  const std::string capture = folder.file("line." + extension);
  std::ofstream(capture) << (extension == "vcd" ? vcd_text(line) : csv_text(line));
  const std::string command = std::string("'") + BISS_BENCH_COMMAND + "' decode '" + capture +
                              "' -f " + line_format_text + " --to csv > /dev/null 2>&1";
  for ([[maybe_unused]] auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    if (std::system(command.c_str()) != 0) return state.SkipWithError("biss decode failed");
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    state.SetIterationTime(took.count());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(command_cycles));
}

// A sampled capture to its summary on stderr, and the damaged cycles alone as rows.
void summarise(benchmark::State& state, bool verify) {
  const Folder folder;
  if (!folder.good()) return state.SkipWithError("no temporary folder");
  const std::string capture = folder.file("line.sr");
  std::ofstream(capture) << sr_archive(sampled_line(archive_samples, request_period).samples);
  const std::string command = std::string("'") + BISS_BENCH_COMMAND + "' decode '" + capture +
                              "' -f " + sampled_format_text + " --only-errors --threads 1" +
                              (verify ? "" : " --no-verify") + " > /dev/null 2>&1";
  for ([[maybe_unused]] auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    if (std::system(command.c_str()) != 0) return state.SkipWithError("biss decode failed");
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    state.SetIterationTime(took.count());
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(archive_samples));
}

}  // namespace

void add_command_rows(Table& table) {
  for (const char* extension : {"vcd", "csv"}) {
    table.add({.name = std::string("biss decode --to csv of a ") + extension + ", cycles",
               .unit = Unit::million_a_second,
               .own_time = true},
              [=](benchmark::State& state) { decode(state, extension); });
  }
  for (const bool verify : {false, true}) {
    table.add({.name = std::string("biss decode of a .sr to its summary") +
                       (verify ? "" : ", no checksums"),
               .unit = Unit::megabytes,
               .reference = std::string(".sr, ") + request_line + inflate_row,
               .share = verify ? verified_share : inflate_share,
               .own_time = true},
              [=](benchmark::State& state) { summarise(state, verify); });
  }
}

}  // namespace biss::bench
