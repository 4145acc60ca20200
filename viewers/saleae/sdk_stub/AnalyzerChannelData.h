// Stands in for the header of Saleae's SDK in our test: see LogicPublicTypes.h.
#pragma once

#include <LogicPublicTypes.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

/// Thrown at the end of the data, when Logic ends the worker thread.
struct EndOfData {};

/// A channel in memory: the samples at which it changes.
class AnalyzerChannelData {
 public:
  AnalyzerChannelData(bool level, std::vector<U64> changes, U64 samples)
      : level_(level), changes_(std::move(changes)), samples_(samples) {}

  U64 GetSampleNumber() const { return now_; }
  BitState GetBitState() const { return level_ ? BIT_HIGH : BIT_LOW; }

  void AdvanceToNextEdge() {
    if (next_ == changes_.size()) throw EndOfData{};
    AdvanceToAbsPosition(changes_[next_]);
  }
  U32 AdvanceToAbsPosition(U64 sample) {
    need(sample);
    if (sample < now_) throw std::string("the channel is asked to go back");
    U32 count = 0;
    for (; next_ < changes_.size() && changes_[next_] <= sample; ++next_) {
      level_ = !level_;
      ++count;
    }
    now_ = sample;
    return count;
  }
  bool WouldAdvancingToAbsPositionCauseTransition(U64 sample) const {
    const bool changes = next_ < changes_.size() && changes_[next_] <= sample;
    if (!changes) need(sample);
    return changes;
  }
  bool DoMoreTransitionsExistInCurrentData() const { return next_ < changes_.size(); }

 private:
  void need(U64 sample) const {
    if (sample >= samples_) throw EndOfData{};
  }

  bool level_;
  std::vector<U64> changes_;
  U64 samples_;
  std::size_t next_ = 0;
  U64 now_ = 0;
};
