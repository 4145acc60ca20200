// Where finished text goes: a file, a pipe, a string in a test.
#pragma once

#include <string>
#include <string_view>

namespace biss::report {

/// Takes text in order. After the first failure every further call fails too.
class TextSink {
 public:
  virtual ~TextSink() = default;

  /// False when the text could not be taken; the owner of the sink knows the cause.
  virtual bool write(std::string_view text) = 0;
};

/// Collects the text in memory.
class StringSink final : public TextSink {
 public:
  bool write(std::string_view text) override {
    text_.append(text);
    return true;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace biss::report
