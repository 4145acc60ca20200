// The reader of a campaign's state on hostile files: an error with a cause, or possible counts.
#include "fuzz/mutate.hpp"
#include "fuzz/target.hpp"
#include "lab/campaign.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;
using namespace biss::lab;

void check_row(const CampaignState& state, std::size_t n) {
  const auto& row = state.rows[n];
  require(row.blocks.size == state.plan.frames_of(state.plan.faults[n]));
  require(row.counts.frames <= row.blocks.size);
  for (std::size_t what = 0; what < acceptance_count; ++what) {
    require(row.counts.total(static_cast<Acceptance>(what)) <= row.counts.frames);
  }
  require(row.counts.total(Acceptance::wrong) <= row.counts.total(Acceptance::monitor));
  for (const std::uint64_t index : row.counts.missed) {
    require(contains(row.done, row.blocks.block_of(index)));
  }
}

constexpr std::string_view words =
    "-1|1e308|18446744073709551615|18446744073709551616|[[0,1]]|flips:0.1|flips:0.1:fitting|[|]|"
    "null";

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  const std::string before(reinterpret_cast<const char*>(data), size);
  SplitMix random{seed};
  const std::string after = TokenMutator(before, ",:[]{}\"", words, random).mutate();
  const std::size_t taken = std::min(after.size(), max_size);
  std::copy_n(after.begin(), taken, data);
  return taken;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto state = read_state({reinterpret_cast<const char*>(data), size});
  if (!state) {
    require(!state.error().empty() && state.error().find('\n') == std::string::npos);
    return 0;
  }
  for (std::size_t n = 0; n < state->rows.size(); ++n) check_row(*state, n);
  require(read_state(state_text(*state)) == *state);
  const CampaignState copy = *state;
  const bool empty = std::all_of(state->rows.begin(), state->rows.end(),
                                 [](const auto& row) { return row.done.size() == 0; });
  require(state->merge(copy) == empty);
  return 0;
}
