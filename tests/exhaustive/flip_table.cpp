#include "tests/exhaustive/flip_table.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "biss/timing/device_timing.hpp"
#include "tests/exhaustive/twin.hpp"

namespace exhaustive {

namespace {

constexpr AffineBit zero{0, false};
constexpr AffineBit one{0, true};
constexpr std::size_t crc_bits = 6;

// The position's bits, first on the line first.
AffineBits position_of(const Case& what) {
  AffineBits bits;
  for (unsigned shift = what.position_bits; shift-- > 0;) {
    bits.push_back({std::uint64_t{1} << shift, false});
  }
  return bits;
}

// Judges the positions for which START is seen at one place.
class Judge {
 public:
  Judge(const Case& what, const AffineBits& line, std::size_t ack, Verdict& verdict)
      : what_(what), line_(line), ack_(ack), verdict_(verdict) {}

  void start_at(std::size_t start, const Positions& all) {
    start_ = start;
    const std::size_t ack_clocks = start - ack_;
    if (ack_clocks < what_.bounds.ack_min_clocks || ack_clocks > what_.bounds.ack_max_clocks) {
      return put(biss::FrameError::ack_range, all);
    }
    const std::size_t stop = start + 2 + what_.position_bits + 2 + crc_bits;
    if (stop > line_.size()) return put(biss::FrameError::truncated, all);
    Positions left = all;
    if (what_.cds0) {
      put(biss::FrameError::cds, left.with(line_[start + 1], true));
      left = left.with(line_[start + 1], false);
    }
    const Positions good = checksum_right(left);
    verdict_.tally[static_cast<std::size_t>(biss::FrameError::crc)] += left.count() - good.count();
    if (stop == line_.size()) return accept(good);
    put(biss::FrameError::stop_bit, good.with(line_[stop], true));
    accept(good.with(line_[stop], false));
  }

  void put(Outcome outcome, const Positions& positions) {
    if (positions.count() == 0) return;
    verdict_.tally[static_cast<std::size_t>(outcome)] += positions.count();
    verdict_.leaves.push_back({outcome, start_, positions});
  }

 private:
  void put(biss::FrameError cause, const Positions& positions) { put(outcome(cause), positions); }

  AffineBits data() const {
    const auto first = line_.begin() + static_cast<std::ptrdiff_t>(start_ + 2);
    return {first, first + static_cast<std::ptrdiff_t>(what_.position_bits + 2)};
  }

  Positions checksum_right(Positions positions) const {
    const AffineBits expected = affine_checksum(checksum_of(crc_bits, true, 0), data());
    for (std::size_t i = 0; i < crc_bits; ++i) {
      const AffineBit& read = line_[start_ + 2 + what_.position_bits + 2 + i];
      positions = positions.with(read + expected[i], false);
    }
    return positions;
  }

  void accept(const Positions& positions) {
    const AffineBits read = data();
    const AffineBits true_position = position_of(what_);
    put(untrusted, positions.with(read[what_.position_bits], false));
    const Positions trusted = positions.with(read[what_.position_bits], true);
    Positions same = trusted;
    for (std::size_t i = 0; i < true_position.size(); ++i) {
      const Positions other = same.with(read[i] + true_position[i], true);
      put(wrong, other);
      same = same.with(read[i] + true_position[i], false);
    }
    put(right, same);
  }

  const Case& what_;
  const AffineBits& line_;
  std::size_t ack_;
  std::size_t start_ = 0;
  Verdict& verdict_;
};

std::string percent(std::uint64_t count, std::uint64_t total) {
  std::array<char, 32> text{};
  const double share = 100.0 * static_cast<double>(count) / static_cast<double>(total);
  std::snprintf(text.data(), text.size(), "%.4g %%", share);
  const std::string rounded = text.data();
  return rounded == "100 %" ? "> 99.99 %" : rounded;
}

std::string cell(std::uint64_t count, std::uint64_t total) {
  if (count == 0) return "";
  return count == total ? "100 %" : percent(count, total);
}

// One format in front of one reader. `bits` may name several widths.
struct TableLine {
  std::string reader;
  std::string bits;
  std::string cds0;
  Tally tally{};
};

using Shares = std::array<std::string, outcome_count>;

Shares shares_of(const Tally& tally) {
  const std::uint64_t total = std::accumulate(tally.begin(), tally.end(), std::uint64_t{0});
  Shares shares;
  for (std::size_t i = 0; i < tally.size(); ++i) shares[i] = cell(tally[i], total);
  return shares;
}

// Adds the format of `line` to the row if the reader and the result are the same.
bool joined(TableLine& row, const TableLine& line) {
  if (row.reader != line.reader || shares_of(row.tally) != shares_of(line.tally)) return false;
  if (row.bits == line.bits) {
    row.cds0 = "any";
  } else if (row.cds0 == line.cds0) {
    row.bits += ", " + line.bits;
  } else {
    return false;
  }
  return true;
}

// First joins the two rows of each width, with CDS known to be 0 and not, then the widths.
std::vector<TableLine> merged(const std::vector<TableLine>& lines) {
  std::vector<TableLine> formats;
  for (const TableLine& line : lines) {
    if (formats.empty() || !joined(formats.back(), line)) formats.push_back(line);
  }
  std::vector<TableLine> rows;
  for (const TableLine& line : formats) {
    const bool done =
        std::any_of(rows.begin(), rows.end(), [&](TableLine& row) { return joined(row, line); });
    if (!done) rows.push_back(line);
  }
  return rows;
}

std::string table_of(const std::string& title, const std::string& reader_columns,
                     const std::string& reader_rule, const std::vector<TableLine>& lines) {
  const std::vector<TableLine> rows = merged(lines);
  const auto seen = [&](std::size_t i) {
    return std::any_of(rows.begin(), rows.end(),
                       [i](const TableLine& row) { return row.tally[i] != 0; });
  };
  std::string head = "| " + reader_columns + " | bits | `cds0` |";
  std::string rule = "|" + reader_rule + "---|---|";
  for (std::size_t i = 0; i < outcome_count; ++i) {
    if (!seen(i)) continue;
    head += " " + name_of(static_cast<Outcome>(i)) + " |";
    rule += "---:|";
  }
  std::string text = "### " + title + "\n\n" + head + "\n" + rule + "\n";
  for (const TableLine& row : rows) {
    const Shares shares = shares_of(row.tally);
    text += "| " + row.reader + " | " + row.bits + " | " + row.cds0 + " |";
    for (std::size_t i = 0; i < outcome_count; ++i) {
      if (seen(i)) text += " " + shares[i] + (shares[i].empty() ? "|" : " |");
    }
    text += "\n";
  }
  return text + "\n";
}

Tally tally_of(const std::vector<Case>& cases) {
  Tally sum{};
  for (const Case& what : cases) {
    const Verdict verdict = judge_all(what);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += verdict.tally[i];
  }
  return sum;
}

const char* title_of(Fault fault) {
  constexpr std::array<const char*, fault_count> titles{
      "The first bit of ACK reads 1",
      "A bit inside ACK reads 1 (mean over all but the first and the last two)",
      "The last bit but one of ACK reads 1",
      "The last bit of ACK reads 1",
      "START reads 0, the clock stops at STOP",
      "START reads 0, the clock continues after STOP",
      "CDS reads 1",
      "STOP reads 1"};
  return titles[static_cast<std::size_t>(fault)];
}

std::string table_of(Fault fault) {
  std::vector<TableLine> lines;
  for (const Setting& setting : settings()) {
    const std::string reader = setting.limits + (" | " + std::to_string(setting.ack_clocks));
    for (const unsigned width : table_widths) {
      for (const bool cds0 : {true, false}) {
        lines.push_back({reader, std::to_string(width), cds0 ? "yes" : "no",
                         tally_of(cases_of(fault, setting, width, cds0))});
      }
    }
  }
  return table_of(title_of(fault), "ACK limits | ACK", "---|---:|", lines);
}

std::string lone_ack_table() {
  std::vector<TableLine> lines;
  for (const bool goes_on : {false, true}) {
    for (const unsigned width : table_widths) {
      for (const bool cds0 : {true, false}) {
        lines.push_back({goes_on ? "continues after STOP" : "stops at STOP", std::to_string(width),
                         cds0 ? "yes" : "no", tally_of({lone_ack_case(width, cds0, goes_on)})});
      }
    }
  }
  return table_of("ACK is a single bit and reads 1 (ACK limits 1…400)", "clock", "---|", lines);
}

}  // namespace

std::string name_of(Outcome outcome) {
  if (outcome == right) return "right";
  if (outcome == wrong) return "**wrong**";
  if (outcome == untrusted) return "nE = 0";
  return "`" + std::string(biss::name_of(static_cast<biss::FrameError>(outcome))) + "`";
}

AffineBits affine_line(const Case& what) {
  AffineBits line(Case::lead_clocks, one);
  line.resize(what.start_bit(), zero);
  line.push_back(one);
  line.push_back(zero);
  AffineBits data = position_of(what);
  data.push_back(one);
  data.push_back(one);
  const AffineBits crc = affine_checksum(checksum_of(crc_bits, true, 0), data);
  line.insert(line.end(), data.begin(), data.end());
  line.insert(line.end(), crc.begin(), crc.end());
  line.push_back(zero);
  line[what.flip] = line[what.flip] + one;
  if (what.clock_goes_on) line.resize(2 * line.size(), zero);
  return line;
}

Verdict judge_all(const Case& what) {
  Verdict verdict;
  const AffineBits line = affine_line(what);
  // Until ACK begins no bit depends on the position.
  std::size_t ack = 0;
  while (line[ack].constant) ++ack;
  Judge judge(what, line, ack, verdict);
  Positions open(what.position_bits);
  for (std::size_t i = ack; i < line.size() && open.count() != 0; ++i) {
    const Positions here = open.with(line[i], true);
    if (here.count() != 0) judge.start_at(i, here);
    open = open.with(line[i], false);
  }
  judge.put(outcome(biss::FrameError::no_start), open);
  return verdict;
}

const std::array<Setting, 4>& settings() {
  static const std::array<Setting, 4> all = [] {
    biss::DeviceTiming renishaw;
    renishaw.start_min = biss::nanoseconds(3'225);
    renishaw.ack_max = biss::microseconds(16);
    const biss::AckBounds ack = biss::ack_bounds(renishaw, biss::period_of(biss::megahertz(10)));
    biss::FrameBounds bounds;
    bounds.ack_min_clocks = ack.min_clocks;
    bounds.ack_max_clocks = ack.max_clocks;
    return std::array<Setting, 4>{{{"1…400", {}, 96},
                                   {"32…160", bounds, 32},
                                   {"32…160", bounds, 96},
                                   {"32…160", bounds, 160}}};
  }();
  return all;
}

std::vector<Case> cases_of(Fault fault, const Setting& setting, unsigned position_bits, bool cds0) {
  Case what{position_bits, cds0, setting.bounds, setting.ack_clocks, Case::lead_clocks, false};
  const std::size_t start = what.start_bit();
  switch (fault) {
    case Fault::ack_first:
      return {what};
    case Fault::ack_between: {
      std::vector<Case> cases;
      for (what.flip = Case::lead_clocks + 1; what.flip < start - 2; ++what.flip) {
        cases.push_back(what);
      }
      return cases;
    }
    case Fault::ack_last_but_one:
      what.flip = start - 2;
      return {what};
    case Fault::ack_last:
      what.flip = start - 1;
      return {what};
    case Fault::start:
    case Fault::start_clock_goes_on:
      what.flip = start;
      what.clock_goes_on = fault == Fault::start_clock_goes_on;
      return {what};
    case Fault::cds:
      what.flip = start + 1;
      return {what};
    case Fault::stop:
      what.flip = what.stop_bit();
      return {what};
  }
  return {};
}

Case lone_ack_case(unsigned position_bits, bool cds0, bool clock_goes_on) {
  return {position_bits, cds0, {}, 1, Case::lead_clocks, clock_goes_on};
}

std::string flip_tables() {
  std::string text;
  for (std::size_t i = 0; i < fault_count; ++i) text += table_of(static_cast<Fault>(i));
  text += lone_ack_table();
  text.pop_back();  // the empty line after the last table
  return text;
}

}  // namespace exhaustive
