// Where written bytes go: a file, a stream, a string.
#pragma once

#include <cstdio>
#include <iosfwd>
#include <string>
#include <string_view>

namespace biss::capture {

class ByteSink {
 public:
  virtual ~ByteSink() = default;

  /// Takes all of `bytes`; false when that failed, after which nothing more need be tried.
  virtual bool write(std::string_view bytes) = 0;
  /// Hands on what the sink has held back; false when that failed.
  virtual bool flush() = 0;
};

/// Writes to a C stream that somebody else opens and closes.
class FileSink final : public ByteSink {
 public:
  explicit FileSink(std::FILE* file) : file_(file) {}
  bool write(std::string_view bytes) override;
  bool flush() override;

 private:
  std::FILE* file_;
};

/// Writes to a C++ stream that outlives the sink.
class StreamSink final : public ByteSink {
 public:
  explicit StreamSink(std::ostream& stream) : stream_(&stream) {}
  bool write(std::string_view bytes) override;
  bool flush() override;

 private:
  std::ostream* stream_;
};

/// Appends to a string that outlives the sink.
class StringSink final : public ByteSink {
 public:
  explicit StringSink(std::string& text) : text_(&text) {}
  bool write(std::string_view bytes) override;
  bool flush() override { return true; }

 private:
  std::string* text_;
};

}  // namespace biss::capture
