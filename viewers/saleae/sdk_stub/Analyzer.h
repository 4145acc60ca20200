// Stands in for the header of Saleae's SDK in our test: see LogicPublicTypes.h.
#pragma once

#include <AnalyzerResults.h>
#include <AnalyzerSettings.h>
#include <LogicPublicTypes.h>
#include <SimulationChannelDescriptor.h>

class AnalyzerChannelData;

class Analyzer {
 public:
  virtual ~Analyzer() = default;
  virtual void WorkerThread() = 0;
  virtual U32 GenerateSimulationData(U64 newest, U32 rate, SimulationChannelDescriptor** out) = 0;
  virtual U32 GetMinimumSampleRateHz() = 0;
  virtual const char* GetAnalyzerName() const = 0;
  virtual bool NeedsRerun() = 0;

  void SetAnalyzerSettings(AnalyzerSettings* given) { settings = given; }
  void SetAnalyzerResults(AnalyzerResults* given) { results = given; }
  void UseFrameV2() {}
  void KillThread() {}
  void ReportProgress(U64) {}
  void CheckIfThreadShouldExit() {}
  U32 GetSampleRate() const { return sample_rate; }
  AnalyzerChannelData* GetAnalyzerChannelData(Channel& channel) {
    return channels.at(channel.mChannelIndex);
  }

  // Only of this stub.
  AnalyzerSettings* settings = nullptr;
  AnalyzerResults* results = nullptr;
  U32 sample_rate = 0;
  std::vector<AnalyzerChannelData*> channels;
};

class Analyzer2 : public Analyzer {
 public:
  virtual void SetupResults() {}
};
