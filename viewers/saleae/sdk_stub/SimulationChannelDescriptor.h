// Stands in for the header of Saleae's SDK in our test: see LogicPublicTypes.h.
#pragma once

#include <LogicPublicTypes.h>

#include <vector>

class SimulationChannelDescriptor {
 public:
  void Transition() {
    level_ = level_ == BIT_HIGH ? BIT_LOW : BIT_HIGH;
    changes.push_back(now_);
  }
  void TransitionIfNeeded(BitState level) {
    if (level != level_) Transition();
  }
  void Advance(U32 samples) { now_ += samples; }
  BitState GetCurrentBitState() const { return level_; }
  U64 GetCurrentSampleNumber() const { return now_; }

  // Only of this stub.
  void begin(BitState level) { level_ = initial = level; }
  BitState initial = BIT_LOW;
  std::vector<U64> changes;

 private:
  BitState level_ = BIT_LOW;
  U64 now_ = 0;
};

class SimulationChannelDescriptorGroup {
 public:
  SimulationChannelDescriptorGroup() { channels_.reserve(8); }
  SimulationChannelDescriptor* Add(Channel&, U32, BitState level) {
    channels_.emplace_back().begin(level);
    return &channels_.back();
  }
  void AdvanceAll(U32 samples) {
    for (SimulationChannelDescriptor& channel : channels_) channel.Advance(samples);
  }
  SimulationChannelDescriptor* GetArray() { return channels_.data(); }
  U32 GetCount() { return static_cast<U32>(channels_.size()); }

 private:
  std::vector<SimulationChannelDescriptor> channels_;
};
