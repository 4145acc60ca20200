// Prints the tables of lab/reports/identify.md about frame formats.
//   biss_format_table [TRIALS [FIRST]]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <string>

#include "biss/frame/format_text.hpp"
#include "tests/identify/format_trial.hpp"

namespace {

struct Row {
  unsigned trials = 0;
  unsigned judged = 0;
  unsigned found = 0;
  unsigned sure = 0;
  unsigned wrong = 0;
};

using Table = std::map<std::string, Row>;

void print(const std::string& heading, const Table& table) {
  fmt::print(
      "| {} | captures | judged | found | sure | sure and wrong "
      "|\n|---|---:|---:|---:|---:|---:|\n",
      heading);
  for (const auto& [name, row] : table) {
    fmt::print("| {} | {} | {} | {:.1f} % | {} | {} |\n", name, row.trials, row.judged,
               row.judged == 0 ? 0.0 : 100.0 * row.found / row.judged, row.sure, row.wrong);
  }
  fmt::print("\n");
}

}  // namespace

int main(int argc, char** argv) {
  using namespace biss;
  const unsigned long trials = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 10'000;
  const unsigned long first = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1'000'001;
  Table by_frames;
  Table by_motion;
  Table by_damage;
  Table all;
  struct Bin {
    double below;
    const char* name;
    unsigned captures = 0;
    double stated = 0;
    unsigned right = 0;
  };
  std::array<Bin, 7> bins{{{0.2, "below 0.2"},
                           {0.4, "0.2 to 0.4"},
                           {0.6, "0.4 to 0.6"},
                           {0.8, "0.6 to 0.8"},
                           {0.9, "0.8 to 0.9"},
                           {0.97, "0.9 to 0.97"},
                           {2, "above"}}};
  for (unsigned long i = 0; i < trials; ++i) {
    const trial::FormatTrial one = trial::random_trial(first + i);
    const trial::TrialResult result = trial::run(one);
    const bool judged = result.moved >= 8;
    const bool wrong = result.sure && !result.mistake.empty();
    if (!result.finding.candidates.empty()) {
      const double confidence = result.finding.candidates.front().confidence;
      Bin& bin = *std::find_if(bins.begin(), bins.end(),
                               [&](const Bin& each) { return confidence < each.below; });
      ++bin.captures;
      bin.stated += confidence;
      bin.right += result.mistake.empty() && !result.other_coding ? 1U : 0U;
    }
    if (wrong) {
      fmt::print(stderr, "trial {}: sure and wrong: {}: {} read as {}\n", first + i, result.mistake,
                 one.text, format_text(result.finding.candidates.front().format).view());
    }
    const unsigned low = one.cycles < 50    ? 20
                         : one.cycles < 100 ? 50
                         : one.cycles < 200 ? 100
                                            : 200;
    const std::string frames = low == 20    ? "  20 to 49"
                               : low == 50  ? " 50 to 99"
                               : low == 100 ? "100 to 199"
                                            : "200 to 400";
    const std::string damage = one.damage == 0      ? "none"
                               : one.damage < 0.03  ? "up to 3 %"
                               : one.damage < 0.065 ? "up to 6.5 %"
                                                    : "up to 9.99 %";
    const std::string motion(sim::motion_names[static_cast<std::size_t>(one.setup.motion)]);
    for (auto* row : {&by_frames[frames], &by_motion[motion], &by_damage[damage]}) {
      ++row->trials;
      row->sure += result.sure ? 1U : 0U;
      row->wrong += wrong ? 1U : 0U;
      if (!judged || one.cycles < (row == &by_frames[frames] ? 0U : 100U)) continue;
      ++row->judged;
      row->found += result.mistake.empty() ? 1U : 0U;
    }
    Row& total = all["all, 100 cycles or more"];
    ++total.trials;
    total.sure += result.sure ? 1U : 0U;
    total.wrong += wrong ? 1U : 0U;
    if (!judged || one.cycles < 100) continue;
    ++total.judged;
    total.found += result.mistake.empty() ? 1U : 0U;
  }
  print("cycles", by_frames);
  print("motion", by_motion);
  print("damaged cycles", by_damage);
  print("sum", all);
  fmt::print("| confidence | captures | mean | right |\n|---|---:|---:|---:|\n");
  for (const Bin& bin : bins) {
    const double count = std::max(1U, bin.captures);
    fmt::print("| {} | {} | {:.3f} | {:.3f} |\n", bin.name, bin.captures, bin.stated / count,
               bin.right / count);
  }
}
