// Fault campaigns against BiSS Safety: a frame is drawn, damaged, and judged by both checksums and
// by the complete monitor.
#include "bench/rows.hpp"
#include "biss/safety/configurations.hpp"
#include "lab/campaign_block.hpp"

namespace biss::bench {

namespace {

using Count = lab::CampaignCounts (*)(const lab::CampaignFrame&, const lab::FaultSequence&,
                                      std::uint64_t, std::uint64_t);

void count(benchmark::State& state, const char* fault, std::uint64_t frames, Count blocks) {
  const SafetyConfiguration& known = *find_safety_configuration("fs-36-28");
  const auto frame = lab::CampaignFrame::make(known.frame_format(), known.setup);
  const lab::FaultSequence sequence{*lab::parse_fault(fault), 1};
  if (blocks(*frame, sequence, 0, frames) !=
      lab::count_block_plainly(*frame, sequence, 0, frames)) {
    return state.SkipWithError("the counts differ");
  }
  std::uint64_t block = 0;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(blocks(*frame, sequence, block++, frames));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames));
}

void add(Table& table, const std::string& fault) {
  const std::string name = "safety campaign, " + fault + ", a frame";
  const std::string plain = name + " by itself";
  // 20 million frames a second on a core.
  table.add({.name = name, .reference = plain, .target = 50}, [fault](benchmark::State& state) {
    count(state, fault.c_str(), lab::block_frames, lab::count_block);
  });
  table.add({.name = plain, .reference = {}}, [fault](benchmark::State& state) {
    count(state, fault.c_str(), 4096, lab::count_block_plainly);
  });
}

}  // namespace

void add_campaign_rows(Table& table) {
  add(table, "flips:0.1");
  add(table, "flips:0.01");
}

}  // namespace biss::bench
