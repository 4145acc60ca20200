// The control communication beside the position frames.
#include "sim/line.hpp"

namespace biss::sim {

// As the encoders were commanded.
void Line::switch_channels() {
  for (std::size_t k = 0; k < registers_.size(); ++k) {
    nodes_[k].slave.set_channels_active(registers_[k].channels_active());
  }
}

// CDS has come, and CDM may depend on it.
void Line::answer_cds() {
  if (answered_ || master_.done() || !master_.reading().cds) return;
  answered_ = true;
  const CdsBit cds = *master_.reading().cds ? CdsBit::one : CdsBit::zero;
  master_.set_cdm(control_->step(number_, begin_, now_, cds));
}

// CDS did not come, and what CDM was is open: the master stopped where it could.
void Line::end_control() {
  if (!answered_) control_->step(number_, begin_, now_, CdsBit::missing);
}

}  // namespace biss::sim
