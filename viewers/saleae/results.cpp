#include "viewers/saleae/results.hpp"

#include <algorithm>
#include <fstream>
#include <limits>

#include "report/writers.hpp"

namespace logic {

namespace {

using biss::report::Cell;
using biss::report::Column;
using biss::report::Kind;
using biss::report::Role;

constexpr auto largest_integer = static_cast<std::uint64_t>(std::numeric_limits<S64>::max());

// The data table of Logic shows these. A column without a value is left out.
void add_field(FrameV2& frame, const Column& column, const Cell& cell, const std::string& text) {
  const char* name = column.name.c_str();
  switch (cell.kind()) {
    case Kind::absent:
      return;
    case Kind::flag:
      return frame.AddBoolean(name, cell.unsigned_value() != 0);
    case Kind::unsigned_integer:
      if (cell.unsigned_value() <= largest_integer) {
        return frame.AddInteger(name, static_cast<S64>(cell.unsigned_value()));
      }
      break;
    case Kind::signed_integer:
      return frame.AddInteger(name, cell.signed_value());
    case Kind::nanoseconds:
      return frame.AddDouble(name, static_cast<double>(cell.time().count) / 1000.0);
    case Kind::real:
      return frame.AddDouble(name, cell.real_value());
    case Kind::text:
    case Kind::bits:
      break;
  }
  frame.AddString(name, text.c_str());
}

// Whether a bubble shows this value besides the status.
bool is_shown(const Column& column, const Cell& cell) {
  if (cell.kind() == Kind::absent) return false;
  const bool flag = column.role == Role::error_at_0 || column.role == Role::warning_at_0;
  return column.name.starts_with("position") || column.role == Role::warnings ||
         (flag && cell.unsigned_value() == 0);
}

}  // namespace

void Results::add(const biss::saleae::Row& row) {
  Texts texts;
  texts.brief = name_of(row.status);
  texts.full = texts.brief;
  // All rows have the same columns. Only this thread adds rows.
  const bool is_first = rows_.empty();
  std::string heading;
  FrameV2 table_row;
  for (std::size_t i = 0; i < row.columns.size(); ++i) {
    const Column& column = row.columns[i];
    const Cell& cell = row.cells[i];
    std::string text;
    if (cell.kind() == Kind::text) text = cell.text();
    biss::report::append_plain(text, cell);
    add_field(table_row, column, cell, text);
    if (is_shown(column, cell)) texts.full += ' ' + column.name + '=' + text;
    // No cell has a comma.
    const char end = i + 1 == row.columns.size() ? '\n' : ',';
    texts.csv += text + end;
    if (is_first) heading += column.name + end;
  }
  Frame frame;
  // Frames may not overlap.
  const std::uint64_t begin = std::max(row.first_sample, end_);
  end_ = std::max(begin, row.last_sample) + 1;
  frame.mStartingSampleInclusive = static_cast<S64>(begin);
  frame.mEndingSampleInclusive = static_cast<S64>(end_ - 1);
  frame.mData1 = 0;
  frame.mData2 = 0;
  frame.mType = static_cast<U8>(row.status);
  frame.mFlags = static_cast<U8>(is_good(row.status) ? 0 : DISPLAY_AS_ERROR_FLAG);
  {
    const std::lock_guard lock(mutex_);
    if (is_first) heading_ = std::move(heading);
    rows_.push_back(std::move(texts));
  }
  AddFrame(frame);
  AddFrameV2(table_row, "cycle", begin, end_ - 1);
  CommitResults();
}

Results::Texts Results::texts_of(U64 frame_index) {
  const std::lock_guard lock(mutex_);
  return frame_index < rows_.size() ? rows_[frame_index] : Texts{};
}

void Results::GenerateBubbleText(U64 frame_index, Channel& channel, DisplayBase) {
  ClearResultStrings();
  if (channel != settings_.slo()) return;
  const Texts texts = texts_of(frame_index);
  AddResultString(texts.brief.c_str());
  AddResultString(texts.full.c_str());
}

void Results::GenerateFrameTabularText(U64 frame_index, DisplayBase) {
  ClearTabularText();
  AddTabularText(texts_of(frame_index).full.c_str());
}

void Results::GenerateExportFile(const char* file, DisplayBase, U32) {
  std::ofstream out(file);
  const U64 count = GetNumFrames();
  {
    const std::lock_guard lock(mutex_);
    out << heading_;
  }
  for (U64 i = 0; i < count; ++i) {
    out << texts_of(i).csv;
    if (UpdateExportProgressAndCheckForCancel(i, count)) return;
  }
  UpdateExportProgressAndCheckForCancel(count, count);
}

void Results::GeneratePacketTabularText(U64, DisplayBase) {}
void Results::GenerateTransactionTabularText(U64, DisplayBase) {}

}  // namespace logic
