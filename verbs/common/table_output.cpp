#include "verbs/common/table_output.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <span>
#include <tl/expected.hpp>
#include <utility>

#include "report/hdf5.hpp"
#include "report/summary.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {

namespace {

// Adds the same cells at the end of each row, and hands on the chosen ones.
class CaptureRows final : public report::TableWriter {
 public:
  CaptureRows(std::unique_ptr<report::TableWriter> writer, std::size_t columns,
              std::vector<std::size_t> places, const Output& output, bool needs_all)
      : writer_(std::move(writer)),
        columns_(columns),
        places_(std::move(places)),
        chosen_(places_.size()),
        output_(output),
        needs_all_(needs_all) {}

  void set_last(FieldRow fields) { last_ = std::move(fields); }
  // False when the rows cannot be written, or are of no use because their reader has left.
  bool good() const { return good_; }

  bool row(std::span<const report::Cell> cells) override {
    if (!last_.empty()) {
      row_.assign(cells.begin(), cells.end());
      row_.resize(columns_ - last_.size());
      for (const Field& each : last_) row_.push_back(each.cell());
      cells = row_;
    }
    for (std::size_t i = 0; i < places_.size(); ++i) {
      chosen_[i] = places_[i] < cells.size() ? cells[places_[i]] : report::Cell();
    }
    good_ =
        writer_->row(places_.empty() ? cells : chosen_) && (needs_all_ || !output_.reader_left());
    return good_;
  }
  bool finish() override { return writer_->finish(); }

 private:
  std::unique_ptr<report::TableWriter> writer_;
  std::size_t columns_;
  std::vector<std::size_t> places_;
  std::vector<report::Cell> chosen_;
  const Output& output_;
  bool needs_all_;
  FieldRow last_;
  std::vector<report::Cell> row_;
  bool good_ = true;
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

// The outputs and files that are left undone by a run that ends at an unreadable capture.
std::string rest_text(const DecodedCapture& capture, const std::string& output) {
  report::Summary text;
  if (!output.empty()) {
    text.entry("not written", output,
               "biss convert --partial keeps the part of a damaged capture before the damage");
  }
  const auto files = capture.files_left();
  if (!files.empty()) {
    const std::string more = files.size() == 1 ? "" : fmt::format(" and {} more", files.size() - 1);
    text.entry("not read", files.front() + more, "the run ends at a capture that cannot be read");
  }
  return text.text();
}

}  // namespace

void RunMessages::add_summary(std::string_view text) {
  if (text.empty()) return;
  if (!summaries_.empty()) summaries_ += '\n';
  summaries_ += text;
}

ExitStatus RunMessages::fail(ExitStatus status, std::string line) {
  lines_.push_back(std::move(line));
  return status;
}

void RunMessages::print(Host& host) const {
  host.print_summary(summaries_);
  for (const std::string& line : lines_) host.warn(line);
}

ExitStatus write_captures(
    DecodedCapture& capture, const std::string& output_path, report::Format to,
    const std::function<std::vector<report::Column>()>& columns, bool needs_all,
    const std::function<ExitStatus(report::TableWriter& writer, RunMessages& messages)>& write,
    const std::vector<std::string>& chosen) {
  if (!capture.next()) {
    if (capture.status() == ExitStatus::io) capture.host().print_summary(rest_text(capture, ""));
    return capture.status();
  }
  Output output(capture.host());
  if (!output.open(output_path)) return output.status();
  if (capture.words() != nullptr && capture.words()->next) output.write_soon();
  std::vector<report::Column> all = columns();
  for (report::Column& column : columns_of(capture.fields())) {
    const bool taken = std::any_of(all.begin(), all.end(), [&](const report::Column& each) {
      return each.name == column.name;
    });
    if (taken) column.name += "_line";
    all.push_back(std::move(column));
  }
  auto places = places_of(chosen, all);
  if (!places) return capture.host().fail(ExitStatus::usage, places.error());
  if (to == report::Format::vcd && !places->empty()) put_time_first(*places, all);
  std::vector<report::Column> shown;
  for (const std::size_t place : *places) shown.push_back(all[place]);
  auto writer = make_writer(to, shown.empty() ? all : shown, output);
  if (!writer) return capture.host().fail(ExitStatus::usage, writer.error());
  CaptureRows rows(std::move(*writer), all.size(), std::move(*places), output, needs_all);
  RunMessages messages;
  ExitStatus status = ExitStatus::done;
  do {
    rows.set_last(capture.fields());
    status = std::max(status, write(rows, messages));
  } while (rows.good() && status < ExitStatus::usage && capture.next());
  if (!rows.good()) return output.status();
  status = std::max(status, capture.status());
  if (status < ExitStatus::usage) {
    if (!rows.finish() || !output.finish()) return output.status();
  } else if (status == ExitStatus::io) {
    const bool is_file = output.file() != nullptr;
    rows.finish();
    output.abandon();
    messages.add_summary(rest_text(capture, is_file ? output_path : ""));
  }
  messages.print(capture.host());
  return status;
}

}  // namespace biss::verbs
