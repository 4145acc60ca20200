#include "capture/byte_sink.hpp"

#include <ostream>

namespace biss::capture {

bool FileSink::write(std::string_view bytes) {
  return std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size();
}

bool FileSink::flush() { return std::fflush(file_) == 0; }

bool StreamSink::write(std::string_view bytes) {
  stream_->write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return stream_->good();
}

bool StreamSink::flush() {
  stream_->flush();
  return stream_->good();
}

bool StringSink::write(std::string_view bytes) {
  text_->append(bytes);
  return true;
}

}  // namespace biss::capture
