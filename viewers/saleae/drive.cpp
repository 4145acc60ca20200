// The analyzer as Logic drives it, with the SDK of sdk_stub: samples in, the rows of its data table out.
//
//   drive EXPORT RATE FORMAT MA_INVERTED SLO_INVERTED FILE
//   drive EXPORT RATE FORMAT MA_INVERTED SLO_INVERTED
//
// FILE has samples of a byte each: bit 0 is MA, bit 1 SLO. Without it, the analyzer reads its own
// simulation. Prints an object of JSON for each row, and the bubbles; EXPORT is the file exported.
#include <Analyzer.h>
#include <AnalyzerChannelData.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>

extern "C" {
Analyzer* __cdecl CreateAnalyzer();
void __cdecl DestroyAnalyzer(Analyzer* analyzer);
}

namespace {

struct Line {
  bool level = false;
  std::vector<U64> changes;
};

struct Samples {
  Line ma;
  Line slo;
  U64 count = 0;
};

Samples read_samples(const char* name) {
  std::ifstream in(name, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.empty()) throw std::string("no samples");
  Samples samples;
  samples.count = bytes.size();
  unsigned bit = 0;
  for (Line* line : {&samples.ma, &samples.slo}) {
    line->level = (bytes[0] >> bit & 1) != 0;
    for (std::size_t i = 1; i < bytes.size(); ++i) {
      if (((bytes[i] ^ bytes[i - 1]) >> bit & 1) != 0) line->changes.push_back(i);
    }
    ++bit;
  }
  return samples;
}

Samples simulated(Analyzer& analyzer) {
  constexpr U64 count = 50'000;
  SimulationChannelDescriptor* channels = nullptr;
  if (analyzer.GenerateSimulationData(count, analyzer.sample_rate, &channels) != 2) {
    throw std::string("the simulation does not have two channels");
  }
  const auto line = [](const SimulationChannelDescriptor& channel) {
    return Line{channel.initial == BIT_HIGH, channel.changes};
  };
  return {line(channels[0]), line(channels[1]), channels[0].GetCurrentSampleNumber()};
}

void set(AnalyzerSettings& settings, const char* format, bool ma_inverted, bool slo_inverted) {
  const auto channel = [&](std::size_t i) {
    return static_cast<AnalyzerSettingInterfaceChannel*>(settings.fields.at(i));
  };
  const auto box = [&](std::size_t i) {
    return static_cast<AnalyzerSettingInterfaceBool*>(settings.fields.at(i));
  };
  channel(0)->SetChannel(Channel(0, 0, DIGITAL_CHANNEL));
  channel(1)->SetChannel(Channel(0, 1, DIGITAL_CHANNEL));
  static_cast<AnalyzerSettingInterfaceText*>(settings.fields.at(2))->SetText(format);
  box(3)->SetValue(ma_inverted);
  box(4)->SetValue(slo_inverted);
  if (!settings.SetSettingsFromInterfaces()) throw settings.error;
  // As Logic does with a stored analyzer.
  const std::string saved = settings.SaveSettings();
  settings.LoadSettings("");
  settings.LoadSettings(saved.c_str());
}

void print(AnalyzerResults& results, const char* exported) {
  for (const auto& row : results.table) std::cout << row.dump() << '\n';
  S64 end = -1;
  for (const Frame& frame : results.frames) {
    if (frame.mStartingSampleInclusive <= end) throw std::string("frames overlap");
    end = frame.mEndingSampleInclusive;
  }
  if (results.delivered != results.table.size()) throw std::string("not delivered");
  Channel slo(0, 1, DIGITAL_CHANNEL);
  for (U64 i = 0; i < results.GetNumFrames(); ++i) {
    results.GenerateBubbleText(i, slo, Decimal);
    std::cout << "bubble " << results.result_strings.at(1) << '\n';
  }
  results.GenerateBubbleText(results.GetNumFrames(), slo, Decimal);
  results.GenerateExportFile(exported, Decimal, 0);
}

void run(int count, char** words) {
  const std::unique_ptr<Analyzer, void (*)(Analyzer*)> analyzer(CreateAnalyzer(), &DestroyAnalyzer);
  analyzer->sample_rate = static_cast<U32>(std::strtoul(words[2], nullptr, 10));
  set(*analyzer->settings, words[3], words[4][0] == '1', words[5][0] == '1');
  const Samples samples = count == 7 ? read_samples(words[6]) : simulated(*analyzer);
  AnalyzerChannelData ma(samples.ma.level, samples.ma.changes, samples.count);
  AnalyzerChannelData slo(samples.slo.level, samples.slo.changes, samples.count);
  analyzer->channels = {&ma, &slo};
  static_cast<Analyzer2&>(*analyzer).SetupResults();
  try {
    analyzer->WorkerThread();
  } catch (const EndOfData&) {
    print(*analyzer->results, words[1]);
  }
}

}  // namespace

int main(int count, char** words) {
  try {
    if (count != 6 && count != 7) throw std::string("wrong number of arguments");
    run(count, words);
  } catch (const std::string& error) {
    std::fprintf(stderr, "drive: %s\n", error.c_str());
    return 1;
  }
  return 0;
}
