#include "verbs/common/table_output.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "report/hdf5.hpp"

namespace biss::verbs {

namespace {

// Passes on some cells of each row.
class ChosenColumns final : public report::TableWriter {
 public:
  ChosenColumns(std::vector<std::size_t> places, std::unique_ptr<report::TableWriter> writer)
      : places_(std::move(places)), cells_(places_.size()), writer_(std::move(writer)) {}

  bool row(std::span<const report::Cell> cells) override {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      cells_[i] = places_[i] < cells.size() ? cells[places_[i]] : report::Cell();
    }
    return writer_->row(cells_);
  }
  bool finish() override { return writer_->finish(); }

 private:
  std::vector<std::size_t> places_;
  std::vector<report::Cell> cells_;
  std::unique_ptr<report::TableWriter> writer_;
};

using Places = std::vector<std::size_t>;

tl::expected<Places, std::string> places_of(const std::vector<std::string>& names,
                                            std::span<const report::Column> columns) {
  Places places;
  for (const std::string& name : names) {
    const auto found = std::find_if(columns.begin(), columns.end(),
                                    [&](const auto& column) { return column.name == name; });
    if (found == columns.end()) {
      std::vector<std::string_view> known;
      for (const report::Column& column : columns) known.push_back(column.name);
      return tl::unexpected(
          fmt::format("--columns: '{}' is not one of {}", name, fmt::join(known, ", ")));
    }
    const auto place = static_cast<std::size_t>(found - columns.begin());
    if (std::find(places.begin(), places.end(), place) != places.end()) {
      return tl::unexpected(fmt::format("--columns: '{}' is given twice", name));
    }
    places.push_back(place);
  }
  return places;
}

// A waveform has the times of the rows, whether they are chosen or not.
void put_time_first(Places& places, std::span<const report::Column> columns) {
  const auto time = std::find_if(columns.begin(), columns.end(), [](const auto& column) {
    return column.kind == report::Kind::nanoseconds;
  });
  if (time == columns.end()) return;
  const auto place = static_cast<std::size_t>(time - columns.begin());
  std::erase(places, place);
  places.insert(places.begin(), place);
}

tl::expected<std::unique_ptr<report::TableWriter>, std::string> make_writer(
    report::Format to, std::span<const report::Column> columns, Output& output) {
  if (auto kept = output.host().keep_rows(columns)) return kept;
  if (to != report::Format::hdf5) {
    return report::make_table_writer(to, columns, output, output.table_options());
  }
  if (output.file() == nullptr) {
    return tl::unexpected(std::string("--to hdf5: not to a pipe or device; name a file with -o"));
  }
  return report::make_hdf5_writer(columns, *output.file());
}

}  // namespace

tl::expected<std::unique_ptr<report::TableWriter>, std::string> make_table(
    const TableChoice& choice, std::span<const report::Column> columns, Output& output) {
  if (choice.columns.empty()) return make_writer(choice.to, columns, output);
  auto places = places_of(choice.columns, columns);
  if (!places) return tl::unexpected(places.error());
  if (choice.to == report::Format::vcd) put_time_first(*places, columns);
  std::vector<report::Column> chosen;
  for (const std::size_t place : *places) chosen.push_back(columns[place]);
  return make_writer(choice.to, chosen, output)
      .map(
          [&](std::unique_ptr<report::TableWriter> writer) -> std::unique_ptr<report::TableWriter> {
            return std::make_unique<ChosenColumns>(std::move(*places), std::move(writer));
          });
}

}  // namespace biss::verbs
