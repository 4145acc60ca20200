// The control communication, during the position frames and before the first one.
#include <algorithm>

#include "sim/line.hpp"

namespace biss::sim {

// Switches the data channels as commanded.
void Line::switch_channels() {
  if (registers_.empty() && !schedule_.empty()) {
    for (Node& node : nodes_) node.slave.set_channels_active(true);
  }
  for (std::size_t k = 0; k < registers_.size(); ++k) {
    nodes_[k].slave.set_channels_active(registers_[k].channels_active());
  }
}

// Once CDS is known: CDM may depend on it.
void Line::answer_cds() {
  if (answered_ || master_.done() || !master_.reading().cds) return;
  answered_ = true;
  const CdsBit cds = *master_.reading().cds ? CdsBit::one : CdsBit::zero;
  master_.set_cdm(control_->step(number_, begin_, now_, cds));
}

// Without CDS, CDM is unknown: the master stopped before it.
void Line::end_control() {
  if (!answered_) control_->step(number_, begin_, now_, CdsBit::missing);
}

void Line::begin_configuration(const ConfigureOptions& options, Hertz clock) {
  configurer_ = std::make_unique<ConfigureCycle>(options, clock);
  master_due_ = configurer_->begin(now_).deadline;
}

const std::vector<wire::Edge>& Line::configure_next() {
  cycle_.edges.clear();
  const std::uint32_t made = configurer_->configurator().requests();
  while (!configurer_->done() && configurer_->configurator().requests() == made) {
    now_ = std::min(master_due_, next_event<true>());
    const bool slo_changed = step_line<true>();
    if (!slo_changed && now_ < master_due_) continue;
    switch_channels();
    const StepOutput out = configurer_->step(now_, slo_);
    master_due_ = out.deadline;
    if (out.level == ma_) continue;
    ma_ = out.level;
    put_ma<true>();
  }
  if (configurer_->done()) end_configuration();
  return cycle_.edges;
}

// MA is high, and SLO gets time to become high.
void Line::end_configuration() {
  configuration_ = configurer_->result();
  if (configuration_->ok()) {
    MasterSetup found = (*configuration_)->master_setup(period_);
    found.compensate = master_.setup().compensate;
    found.trust_cycle_time = master_.setup().trust_cycle_time;
    found.low_time = master_.setup().low_time;
    found.cdm = master_.setup().cdm;
    found.no_error_flag = found.unchecked = true;
    found.timing.clock_max = hertz_max;
    master_ = RequestCycle<Codec>(Codec((*configuration_)->format), found);
  }
  run_rest<true>(now_ + common_cycle, false);
  begin_ = now_;
}

}  // namespace biss::sim
