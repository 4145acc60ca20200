// The destination of finished text: a file, a pipe, a string in a test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace biss::report {

/// Takes text in order. After the first failure every further call fails too.
class TextSink {
 public:
  virtual ~TextSink() = default;

  /// False if the text was not written; the owner of the sink has the cause.
  virtual bool write(std::string_view text) = 0;
  /// Each line is wanted at once, and not in blocks.
  virtual bool wants_lines() const { return false; }
  /// The same as write() for text that contains no part of a file that could control a terminal.
  virtual bool write_printable(std::string_view text) { return write(text); }
};

/// A file that is written at any place. After the first failure every further call fails too.
class FileSink {
 public:
  virtual ~FileSink() = default;

  /// False if the bytes were not written; the owner of the sink has the cause.
  virtual bool write_at(std::uint64_t offset, std::span<const std::byte> bytes) = 0;
  /// Reads bytes that were written before; zeros past the end of the file.
  virtual bool read_at(std::uint64_t offset, std::span<std::byte> bytes) = 0;
  /// Fails with a cause of the writer.
  virtual void fail(std::string_view cause) = 0;
};

/// Collects the text in memory.
class StringSink final : public TextSink {
 public:
  bool write(std::string_view text) override {
    text_.append(text);
    return true;
  }
  const std::string& text() const { return text_; }
  /// The text so far; afterwards there is none.
  std::string take() { return std::exchange(text_, {}); }

 private:
  std::string text_;
};

}  // namespace biss::report
