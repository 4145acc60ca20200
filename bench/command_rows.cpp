// The command as a whole process: start, reading the file, writing the rows.
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <span>
#include <string>

#include "bench/line.hpp"
#include "bench/rows.hpp"
#include "bench/samples.hpp"
#include "capture/test_folder.hpp"

namespace biss::bench {

namespace {

using test::Folder;

constexpr std::size_t command_cycles = 20'000;
// A report has a part of this many.
constexpr std::size_t report_cycles = 100'000;

// The time of a whole process. False if it failed.
bool run_process(benchmark::State& state, const std::string& command) {
  for ([[maybe_unused]] auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    if (std::system((command + " > /dev/null 2>&1").c_str()) != 0) {
      state.SkipWithError("the command failed");
      return false;
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    state.SetIterationTime(took.count());
  }
  return true;
}

std::string decode_command(const std::string& capture, const char* format) {
  return std::string("'") + BISS_BENCH_COMMAND + "' decode '" + capture + "' -f " + format;
}

// A process that reads this number of cycles.
void read_cycles(
    benchmark::State& state, std::size_t cycles, const std::string& extension,
    const std::function<std::string(const Folder& folder, const std::string& capture)>& command) {
  const Folder folder;
  const std::string capture = folder.path("line." + extension);
  const Line line = make_line(cycles);
  std::ofstream(capture) << (extension == "vcd" ? vcd_text(line) : csv_text(line));
  if (!run_process(state, command(folder, capture))) return;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(cycles));
}

std::string rows_command(const Folder&, const std::string& capture) {
  return decode_command(capture, line_format_text) + " --to csv";
}

// The page is as short as it can be.
std::string report_command(const Folder& folder, const std::string& capture) {
  const std::string page =
      folder.file("page.html", R"(<script type="text/plain" id="biss-core"></script>)");
  return std::string("'") + BISS_BENCH_COMMAND + "' report '" + capture + "' -f " +
         line_format_text + " --page '" + page + "' -o '" + folder.path("report.html") + "'";
}

// A process that reads a capture of `samples` samples of the whole line.
void read_samples(benchmark::State& state, std::size_t samples,
                  const std::function<std::string(const std::string& capture)>& command) {
  const Folder folder;
  const std::string capture = folder.path("line.sr");
  if (samples == whole_samples) {
    std::ofstream(capture) << whole_archive();
  } else {
    std::ofstream(capture) << sr_archive(std::span(whole_line().samples).first(samples));
  }
  if (!run_process(state, command(capture))) return;
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(samples));
}

// The summary on stderr, and the damaged cycles alone as rows.
std::string summary_command(const std::string& capture, bool verify) {
  return decode_command(capture, sampled_format_text) + " --only-errors --threads 1" +
         (verify ? "" : " --no-verify");
}

// The bytes on SLO, without START, CRC and causes.
std::string sigrok_command(const std::string& capture) {
  return "sigrok-cli -i '" + capture +
         "' -P spi:clk=MA:miso=SLO:cpol=1:cpha=1:wordsize=8 -A spi=miso-data";
}

bool has_sigrok() { return std::system("command -v sigrok-cli > /dev/null 2>&1") == 0; }

// The decoder of sigrok needs seconds for a part of the line.
constexpr std::size_t sigrok_samples = whole_samples / 32;
constexpr const char* sigrok_row = "sigrok-cli, decoder spi, of a .sr";

}  // namespace

void add_command_rows(Table& table) {
  for (const char* extension : {"vcd", "csv"}) {
    table.add({.name = std::string("biss decode --to csv of a ") + extension + ", cycles",
               .unit = Unit::million_a_second,
               .own_time = true},
              [=](benchmark::State& state) {
                read_cycles(state, command_cycles, extension, rows_command);
              });
  }
  constexpr const char* whole_row = "a vcd of 100 000 cycles, biss decode --to csv";
  table.add(
      {.name = whole_row, .unit = Unit::million_a_second, .own_time = true},
      [](benchmark::State& state) { read_cycles(state, report_cycles, "vcd", rows_command); });
  table.add(
      {.name = "a vcd of 100 000 cycles, biss report",
       .unit = Unit::million_a_second,
       .reference = whole_row,
       .share = 5,
       .own_time = true},
      [](benchmark::State& state) { read_cycles(state, report_cycles, "vcd", report_command); });
  for (const bool verify : {false, true}) {
    table.add({.name = std::string("biss decode of a .sr to its summary") +
                       (verify ? "" : ", no checksums"),
               .unit = Unit::megabytes,
               .reference = std::string(".sr, ") + request_line + inflate_row,
               .share = verify ? verified_share : inflate_share,
               .own_time = true},
              [=](benchmark::State& state) {
                read_samples(state, whole_samples, [=](const std::string& capture) {
                  return summary_command(capture, verify);
                });
              });
  }
  if (!has_sigrok()) return;
  table.add({.name = sigrok_row, .unit = Unit::megabytes, .own_time = true},
            [](benchmark::State& state) { read_samples(state, sigrok_samples, sigrok_command); });
  for (const char* threads : {" --threads 1", " --threads 2"}) {
    table.add({.name = std::string("biss decode --to csv of a .sr,") + threads,
               .unit = Unit::megabytes,
               .reference = sigrok_row,
               .share = 1.0 / 400,
               .own_time = true},
              [=](benchmark::State& state) {
                read_samples(state, whole_samples, [=](const std::string& capture) {
                  return decode_command(capture, sampled_format_text) + " --to csv" + threads;
                });
              });
  }
}

}  // namespace biss::bench
