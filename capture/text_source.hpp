// What every reader of text shares: the window, the edges of a block, and how reading ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "capture/edge_block.hpp"
#include "capture/edge_source.hpp"
#include "capture/text_window.hpp"

namespace biss::capture {

/// An EdgeSource over text. A format adds parse() and finish().
class TextSource : public EdgeSource {
 public:
  const std::vector<std::string>& lines() const final { return lines_; }
  Picoseconds end_time() const final { return end_time_; }
  Result<std::span<const wire::Edge>, CaptureError> next_block() final;

 protected:
  TextSource(std::unique_ptr<ByteSource> bytes, TextWindow::Cut cut)
      : window_(std::move(bytes), cut) {}

  /// Reads on from the window's begin until the window is used up, the block is full or fail() was
  /// called; advances the window.
  virtual void parse() = 0;
  /// The text has ended; may call fail().
  virtual void finish() = 0;
  /// Inside text whose words may have any length.
  virtual bool in_comment() const { return false; }

  /// Ends reading with an error, to be returned after the edges that came before it.
  void fail(const CaptureError& error) {
    error_ = error;
    state_ = State::failed;
  }
  bool failed() const { return state_ == State::failed; }
  const CaptureError& error() const { return error_; }

  TextWindow window_;
  EdgeBlock block_;
  std::vector<std::string> lines_;
  Picoseconds end_time_;

 private:
  enum class State : std::uint8_t { reading, ended, failed };

  void fill_window();

  State state_ = State::reading;
  CaptureError error_;
};

}  // namespace biss::capture
