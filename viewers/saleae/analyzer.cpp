// The low-level analyzer of BiSS C for Saleae Logic 2.
#include <Analyzer.h>
#include <AnalyzerChannelData.h>

#include <memory>
#include <optional>

#include "viewers/saleae/results.hpp"
#include "viewers/saleae/settings.hpp"
#include "viewers/saleae/simulated_line.hpp"

namespace logic {

namespace {

using biss::saleae::Row;
using biss::saleae::RowReader;

constexpr const char* analyzer_name = "BiSS C";

// MA that rests for this long ends a request: longer than ACK may take (40 µs).
constexpr std::uint64_t rests_per_second = 20'000;

bool is_high(AnalyzerChannelData& line) { return line.GetBitState() == BIT_HIGH; }

// Gives the changes of both lines to a reader, in the order of time. Only MA leads: SLO may never
// change again, and Logic waits forever for a change that does not come.
class Follower {
 public:
  Follower(AnalyzerChannelData& ma, AnalyzerChannelData& slo, RowReader& reader, U32 rate)
      : ma_(ma), slo_(slo), reader_(reader), rest_(rate / rests_per_second + 1) {
    reader_.push_ma(ma_.GetSampleNumber(), is_high(ma_));
    reader_.push_slo(slo_.GetSampleNumber(), is_high(slo_));
  }

  void next() {
    const U64 rested = ma_.GetSampleNumber() + rest_;
    // The last request of a capture, or of the data so far in a live capture.
    if (!ma_.DoMoreTransitionsExistInCurrentData() &&
        !ma_.WouldAdvancingToAbsPositionCauseTransition(rested)) {
      push_slo_until(rested);
      reader_.rest_until(rested);
    }
    ma_.AdvanceToNextEdge();
    push_slo_until(ma_.GetSampleNumber());
    reader_.push_ma(ma_.GetSampleNumber(), is_high(ma_));
  }

 private:
  void push_slo_until(U64 sample) {
    if (sample <= slo_.GetSampleNumber()) return;
    while (slo_.WouldAdvancingToAbsPositionCauseTransition(sample)) {
      slo_.AdvanceToNextEdge();
      reader_.push_slo(slo_.GetSampleNumber(), is_high(slo_));
    }
    slo_.AdvanceToAbsPosition(sample);
  }

  AnalyzerChannelData& ma_;
  AnalyzerChannelData& slo_;
  RowReader& reader_;
  U64 rest_;
};

class BissAnalyzer final : public Analyzer2 {
 public:
  BissAnalyzer() {
    SetAnalyzerSettings(&settings_);
    UseFrameV2();
  }
  ~BissAnalyzer() override { KillThread(); }

  void SetupResults() override {
    results_ = std::make_unique<Results>(settings_);
    SetAnalyzerResults(results_.get());
    results_->AddChannelBubblesWillAppearOn(settings_.slo());
  }

  void WorkerThread() override {
    const U32 rate = GetSampleRate();
    if (rate == 0) return;
    RowReader reader(settings_.rows(), biss::hertz(rate), [&](const Row& row) {
      results_->add(row);
      ReportProgress(row.last_sample);
    });
    Follower follower(*GetAnalyzerChannelData(settings_.ma()),
                      *GetAnalyzerChannelData(settings_.slo()), reader, rate);
    // Logic ends this thread from within a call.
    for (;;) {
      follower.next();
      CheckIfThreadShouldExit();
    }
  }

  U32 GenerateSimulationData(U64 newest_sample, U32 rate,
                             SimulationChannelDescriptor** lines) override {
    if (!simulated_) simulated_.emplace(settings_, rate);
    return simulated_->run_until(newest_sample, lines);
  }

  // Clocks begin at 80 kHz; four samples a clock are the least that can be read.
  U32 GetMinimumSampleRateHz() override { return 320'000; }
  const char* GetAnalyzerName() const override { return analyzer_name; }
  bool NeedsRerun() override { return false; }

 private:
  Settings settings_;
  std::unique_ptr<Results> results_;
  std::optional<SimulatedLine> simulated_;
};

}  // namespace
}  // namespace logic

extern "C" {
ANALYZER_EXPORT const char* __cdecl GetAnalyzerName() { return logic::analyzer_name; }
ANALYZER_EXPORT Analyzer* __cdecl CreateAnalyzer() { return new logic::BissAnalyzer; }
ANALYZER_EXPORT void __cdecl DestroyAnalyzer(Analyzer* analyzer) { delete analyzer; }
}
