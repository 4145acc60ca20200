// The low-level analyzer of BiSS C for Saleae Logic 2.
#pragma once

#include <Analyzer.h>

#include <memory>

#include "viewers/saleae/results.hpp"
#include "viewers/saleae/settings.hpp"
#include "viewers/saleae/simulated_line.hpp"

namespace logic {

class BissAnalyzer final : public Analyzer2 {
 public:
  BissAnalyzer();
  ~BissAnalyzer() override;

  void SetupResults() override;
  void WorkerThread() override;
  U32 GenerateSimulationData(U64 newest_sample, U32 rate,
                             SimulationChannelDescriptor** lines) override;
  U32 GetMinimumSampleRateHz() override;
  const char* GetAnalyzerName() const override;
  bool NeedsRerun() override;

 private:
  Settings settings_;
  std::unique_ptr<Results> results_;
  std::unique_ptr<SimulatedLine> simulated_;
};

}  // namespace logic

extern "C" {
ANALYZER_EXPORT const char* __cdecl GetAnalyzerName();
ANALYZER_EXPORT Analyzer* __cdecl CreateAnalyzer();
ANALYZER_EXPORT void __cdecl DestroyAnalyzer(Analyzer* analyzer);
}
