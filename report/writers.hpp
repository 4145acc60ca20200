// Within the room: one maker a format, and what the machine formats share.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "report/table.hpp"

namespace biss::report {

std::unique_ptr<TableWriter> make_csv_writer(std::span<const Column> columns, TextSink& sink);
std::unique_ptr<TableWriter> make_jsonl_writer(std::span<const Column> columns, TextSink& sink);
std::unique_ptr<TableWriter> make_eye_writer(std::span<const Column> columns, TextSink& sink,
                                             TableOptions options);

/// Collects lines and hands them to the sink in large blocks; remembers a failure.
class BlockWriter {
 public:
  explicit BlockWriter(TextSink& sink) : sink_(sink) { block_.reserve(block_bytes + 4096); }

  /// Lines are appended here, then line_done() is called.
  std::string& block() { return block_; }
  bool line_done() { return block_.size() < block_bytes ? good_ : flush(); }
  bool flush() {
    good_ = good_ && sink_.write(block_);
    block_.clear();
    return good_;
  }
  bool good() const { return good_; }

 private:
  static constexpr std::size_t block_bytes = 64U * 1024U;

  TextSink& sink_;
  std::string block_;
  bool good_ = true;
};

}  // namespace biss::report
