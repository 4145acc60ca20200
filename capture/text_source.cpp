#include "capture/text_source.hpp"

namespace biss::capture {

void TextSource::fill_window() {
  switch (window_.next(in_comment())) {
    case TextWindow::Fill::ready:
      return;
    case TextWindow::Fill::failed:
      return fail(window_.error());
    case TextWindow::Fill::ended:
      state_ = State::ended;
      return finish();
  }
}

Result<std::span<const wire::Edge>, CaptureError> TextSource::next_block() {
  block_.grow();
  block_.prepare(lines_.size());
  while (state_ == State::reading && block_.empty()) {
    if (window_.begin() == window_.end()) {
      fill_window();
    } else {
      parse();
    }
  }
  if (block_.empty() && state_ == State::failed) return failure(error_);
  return block_.edges();
}

}  // namespace biss::capture
