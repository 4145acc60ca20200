// Stands in for the header of Saleae's SDK in our test: see LogicPublicTypes.h.
#pragma once

#include <LogicPublicTypes.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#define DISPLAY_AS_ERROR_FLAG (1 << 7)

struct Frame {
  S64 mStartingSampleInclusive = 0;
  S64 mEndingSampleInclusive = 0;
  U64 mData1 = 0;
  U64 mData2 = 0;
  U8 mType = 0;
  U8 mFlags = 0;
};

class FrameV2 {
 public:
  void AddString(const char* key, const char* value) { values[key] = value; }
  void AddDouble(const char* key, double value) { values[key] = value; }
  void AddInteger(const char* key, S64 value) { values[key] = value; }
  void AddBoolean(const char* key, bool value) { values[key] = value; }

  // Only of this stub.
  nlohmann::ordered_json values;
};

class AnalyzerResults {
 public:
  virtual ~AnalyzerResults() = default;
  virtual void GenerateBubbleText(U64 frame, Channel& channel, DisplayBase base) = 0;
  virtual void GenerateExportFile(const char* file, DisplayBase base, U32 type) = 0;
  virtual void GenerateFrameTabularText(U64 frame, DisplayBase base) = 0;
  virtual void GeneratePacketTabularText(U64 packet, DisplayBase base) = 0;
  virtual void GenerateTransactionTabularText(U64 transaction, DisplayBase base) = 0;

  U64 AddFrame(const Frame& frame) {
    frames.push_back(frame);
    return frames.size() - 1;
  }
  void AddFrameV2(const FrameV2& frame, const char*, U64 first, U64 last) {
    table.push_back(frame.values);
    if (first > last) throw std::string("a frame ends before it begins");
  }
  void CommitResults() { delivered = frames.size(); }
  void AddChannelBubblesWillAppearOn(const Channel&) {}
  U64 GetNumFrames() const { return frames.size(); }
  void ClearResultStrings() { result_strings.clear(); }
  void AddResultString(const char* text) { result_strings.emplace_back(text); }
  void ClearTabularText() { result_strings.clear(); }
  void AddTabularText(const char* text) { result_strings.emplace_back(text); }
  bool UpdateExportProgressAndCheckForCancel(U64, U64) { return false; }

  // Only of this stub.
  std::vector<Frame> frames;
  std::vector<nlohmann::ordered_json> table;
  std::vector<std::string> result_strings;
  std::size_t delivered = 0;
};
