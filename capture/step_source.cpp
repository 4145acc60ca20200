#include "capture/step_source.hpp"

namespace biss::capture {

Result<std::span<const wire::Edge>, CaptureError> StepSource::next_block() {
  block_.grow();
  block_.prepare(lines_.size());
  while (state_ == State::reading && !block_.full()) step();
  if (block_.empty() && failed()) return failure(error_);
  return block_.edges();
}

}  // namespace biss::capture
