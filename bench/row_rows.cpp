// The rows of `decode`, from request cycles in memory to text.
#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "bench/line.hpp"
#include "bench/rows.hpp"
#include "decode/decoder.hpp"
#include "report/hdf5.hpp"
#include "report/table.hpp"
#include "rows/table.hpp"

namespace biss::bench {

namespace {

// Few enough to stay in the second-level cache, as in a decoder.
constexpr std::size_t row_cycles = 500;

struct Cycles {
  FrameFormat format;
  std::vector<decode::Cycle> list;
};

Cycles make_cycles() {
  const Line line = make_line(row_cycles);
  Cycles made{.format = line.format, .list = {}};
  decode::Decoder decoder(decode::CycleReader(line.format, DeviceTiming{}),
                          [&](const decode::Cycle& cycle) { made.list.push_back(cycle); });
  decoder.push(line.edges, {.ma = 0, .slo = 1});
  decoder.finish(line.end);
  return made;
}

class CountingSink final : public report::TextSink {
 public:
  bool write(std::string_view text) override {
    bytes += text.size();
    benchmark::DoNotOptimize(text.data());
    return true;
  }
  std::size_t bytes = 0;
};

void put_rows(rows::DecodeTable& table, const Cycles& from, report::TableWriter& writer) {
  std::uint64_t number = 0;
  for (const decode::Cycle& cycle : from.list) writer.row(table.cells(number++, cycle));
}

void write_text(benchmark::State& state, report::Format format) {
  const Cycles from = make_cycles();
  rows::DecodeTable table(from.format);
  CountingSink sink;
  const auto writer = report::make_table_writer(format, table.columns(), sink);
  for ([[maybe_unused]] auto _ : state) put_rows(table, from, *writer);
  if (!writer->finish() || sink.bytes == 0) return state.SkipWithError("no rows were written");
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(from.list.size()));
}

// A file in memory, of at most 64 MiB.
class MemoryFile final : public report::FileSink {
 public:
  MemoryFile() : bytes_(std::size_t{64} << 20U) {}

  bool write_at(std::uint64_t offset, std::span<const std::byte> bytes) override {
    if (offset + bytes.size() > bytes_.size()) failed = true;
    if (!failed) std::copy(bytes.begin(), bytes.end(), bytes_.data() + offset);
    return !failed;
  }
  bool read_at(std::uint64_t offset, std::span<std::byte> bytes) override {
    if (offset + bytes.size() > bytes_.size()) failed = true;
    if (!failed) std::copy_n(bytes_.data() + offset, bytes.size(), bytes.begin());
    return !failed;
  }
  void fail(std::string_view) override { failed = true; }

  bool failed = false;

 private:
  std::vector<std::byte> bytes_;
};

void write_hdf5(benchmark::State& state) {
  constexpr std::size_t repeats = 400;
  const Cycles from = make_cycles();
  rows::DecodeTable table(from.format);
  MemoryFile file;
  for ([[maybe_unused]] auto _ : state) {
    const auto writer = report::make_hdf5_writer(table.columns(), file);
    for (std::size_t i = 0; i < repeats; ++i) put_rows(table, from, *writer);
    if (!writer->finish()) return state.SkipWithError("the file was not written");
  }
  state.SetItemsProcessed(state.iterations() *
                          static_cast<std::int64_t>(from.list.size() * repeats));
}

// As many bytes as the rows have, copied to a block that stays in the cache.
void copy_text(benchmark::State& state) {
  const Cycles from = make_cycles();
  rows::DecodeTable table(from.format);
  report::StringSink sink;
  const auto writer = report::make_table_writer(report::Format::csv, table.columns(), sink);
  put_rows(table, from, *writer);
  writer->finish();
  const std::string& text = sink.text();
  std::vector<char> copy(text.size());
  for ([[maybe_unused]] auto _ : state) {
    std::memcpy(copy.data(), text.data(), text.size());
    benchmark::DoNotOptimize(copy.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(from.list.size()));
}

}  // namespace

void add_row_rows(Table& table) {
  const std::string copy = "memcpy of the rows' CSV, rows";
  table.add({.name = copy, .unit = Unit::million_a_second}, copy_text);
  const auto add = [&](const char* name, report::Format format) {
    table.add(
        {.name = std::string("rows to ") + name, .unit = Unit::million_a_second, .reference = copy},
        [format](benchmark::State& state) { write_text(state, format); });
  };
  add("CSV", report::Format::csv);
  add("JSON lines", report::Format::jsonl);
  add("VCD", report::Format::vcd);
  table.add({.name = "rows to HDF5", .unit = Unit::million_a_second, .reference = copy},
            write_hdf5);
}

}  // namespace biss::bench
