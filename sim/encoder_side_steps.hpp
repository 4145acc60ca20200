// The work of EncoderSide at each edge, for the files that run it.
#pragma once

#include <algorithm>

#include "sim/encoder_side.hpp"

namespace biss::sim {

template <bool Full>
Picoseconds EncoderSide::next_event() const {
  Picoseconds next = ma_pipe_.front();
  if constexpr (Full) next = std::min({next, schedule_.next(), filter_due_});
  const std::size_t count = Full ? nodes_.size() : 1;
  for (std::size_t k = 0; k < count; ++k) {
    next = std::min({next, nodes_[k].due, nodes_[k].slo.front()});
  }
  return next;
}

// The edge that arrives now, if there is one.
inline bool EncoderSide::take(Pipe& pipe, bool& level) const {
  if (pipe.front() > now_) return false;
  pipe.pop();
  level = !level;
  return true;
}

template <bool Full>
bool EncoderSide::step() {
  const bool slo_before = slo_;
  if constexpr (Full) {
    if (schedule_.next() <= now_) act();
  }
  bool ma_changed = take(ma_pipe_, ma_raw_);
  if constexpr (Full) {
    if (ma_changed) filter_due_ = ma_raw_ == ma_slave_ ? never : now_ + ma_filter_;
    ma_changed = filter_due_ <= now_;
    if (ma_changed) filter_due_ = never;
  }
  if (ma_changed) {
    ma_slave_ = ma_raw_;
    if (setup_.record_at_slave) record(ma_at_slave_line, ma_slave_);
  }
  const std::size_t count = Full ? nodes_.size() : 1;
  for (std::size_t k = 0; k < count && !(Full && foreign_level_); ++k) {
    const bool sli_changed = k != 0 && take(nodes_[k - 1U].slo, nodes_[k].sli);
    if (ma_changed || sli_changed || nodes_[k].due <= now_) step_node<Full>(k, ma_changed);
  }
  if (take(nodes_[count - 1U].slo, slo_arrived_)) put_slo<Full>();
  return slo_ != slo_before;
}

template <bool Full>
void EncoderSide::step_node(std::size_t k, bool ma_changed) {
  Node& node = nodes_[k];
  if constexpr (Full) {
    if (k == 0 && start_ && ma_changed && !ma_slave_) apply_start();
    waiting_ = false;
  }
  const SlaveState before = node.slave.state();
  const StepOutput out = node.slave.step(now_, ma_slave_, node.sli);
  node.due = out.deadline;
  if constexpr (Full) {
    const SlaveState after = node.slave.state();
    node.slave.source().follow(after);
    // A bit of the payload follows each rising edge of MA.
    if (k + 1U == nodes_.size() && ma_changed && ma_slave_ && after >= SlaveState::data &&
        after <= SlaveState::stop) {
      payload_bit_ = before == SlaveState::start ? 0U - 1U : payload_bit_ + 1U;
    }
  }
  put_node<Full>(k, out.level);
}

template <bool Full>
bool EncoderSide::level_at(Place place, bool level) const {
  return Full ? disturbance_.level(place, level) : level;
}

template <bool Full>
void EncoderSide::put_ma() {
  const bool wire = level_at<Full>(Place::ma_master, ma_);
  if (wire != ma_wire_) {
    ma_wire_ = wire;
    record(ma_line, wire);
  }
  const bool level = level_at<Full>(Place::ma_slave, wire);
  if (level == ma_sent_) return;
  ma_sent_ = level;
  ma_pipe_.send(now_, setup_.ma_delay, setup_.ma_jitter, random_);
}

template <bool Full>
void EncoderSide::put_node(std::size_t k, bool level) {
  Node& node = nodes_[k];
  const bool last = !Full || k + 1U == nodes_.size();
  if (Full && last && disturbance_.active() != 0) {
    const SlaveState state = node.slave.state();
    const bool sends = state == SlaveState::data || state == SlaveState::stop;
    level = disturbance_.level(Place::slo_slave,
                               level != (sends && disturbance_.inverts(payload_bit_)));
  }
  if (level == node.level) return;
  node.level = level;
  if (!last) return node.slo.send(now_, setup_.internal_delay, {}, random_);
  if (setup_.record_at_slave) record(slo_at_slave_line, level);
  node.slo.send(now_, setup_.internal_delay + slo_delay_, setup_.slo_jitter, random_);
}

template <bool Full>
void EncoderSide::put_slo() {
  const bool level = level_at<Full>(Place::slo_master, slo_arrived_);
  if (level == slo_) return;
  slo_ = level;
  record(slo_line, level);
}

}  // namespace biss::sim
