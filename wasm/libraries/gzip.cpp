// A gzip member as a stream.
#include <libdeflate.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <boost/beast/zlib/inflate_stream.hpp>
#include <new>
#include <vector>

#include "wasm/libraries/gzip_header.hpp"
#include "wasm/libraries/inflate.hpp"

namespace beast_zlib = boost::beast::zlib;

struct GzipStreamState {
  enum class Part : std::uint8_t { header, data, trailer, ended, wrong };

  beast_zlib::inflate_stream stream;
  // One call later: where `stream` fails, the library does not count the bytes that it made.
  beast_zlib::inflate_stream later;
  std::vector<std::uint8_t> later_bytes;
  biss::wasm::GzipHeader header;
  Part part = Part::header;
  // The last bytes of the data.
  std::array<std::uint8_t, 8> last{};
  std::uint32_t checksum = 0;
  std::uint32_t size_bytes = 0;
  std::uint64_t trailer = 0;
  unsigned trailer_bytes = 0;
};

namespace {

using Part = GzipStreamState::Part;

void read_header(z_stream& stream, GzipStreamState& gzip) {
  using State = biss::wasm::GzipHeader::State;
  while (stream.avail_in != 0 && gzip.part == Part::header) {
    const State state = gzip.header.take(*stream.next_in++);
    --stream.avail_in;
    if (state == State::complete) gzip.part = Part::data;
    if (state == State::wrong) gzip.part = Part::wrong;
  }
}

bool is_fault(const boost::system::error_code& result) {
  return result && result != beast_zlib::error::end_of_stream &&
         result != beast_zlib::error::need_buffers;
}

beast_zlib::z_params whole_step(const z_stream& stream) {
  beast_zlib::z_params step;
  step.next_in = stream.next_in;
  step.avail_in = stream.avail_in;
  step.next_out = stream.next_out;
  step.avail_out = stream.avail_out;
  return step;
}

// Byte by byte up to the fault. Leaves in `step` what is not used.
void inflate_to_fault(const z_stream& stream, GzipStreamState& gzip, beast_zlib::z_params& step) {
  step = whole_step(stream);
  std::size_t room = step.avail_out;
  for (boost::system::error_code result; !is_fault(result) && room != 0;) {
    step.avail_out = 1;
    gzip.later.write(step, beast_zlib::Flush::none, result);
    if (step.avail_out == 1) break;
    --room;
  }
  step.avail_out = room;
}

void read_data(z_stream& stream, GzipStreamState& gzip) {
  beast_zlib::z_params step = whole_step(stream);
  boost::system::error_code result;
  gzip.stream.write(step, beast_zlib::Flush::none, result);
  if (is_fault(result)) {
    inflate_to_fault(stream, gzip, step);
  } else {
    beast_zlib::z_params again = whole_step(stream);
    gzip.later_bytes.resize(stream.avail_out);
    again.next_out = gzip.later_bytes.data();
    boost::system::error_code same;
    gzip.later.write(again, beast_zlib::Flush::none, same);
  }
  const auto made = stream.avail_out - static_cast<uInt>(step.avail_out);
  gzip.checksum = libdeflate_crc32(gzip.checksum, stream.next_out, made);
  gzip.size_bytes += made;
  const std::uint8_t* const end = stream.next_in + (stream.avail_in - step.avail_in);
  for (; stream.next_in != end; ++stream.next_in) {
    if (end - stream.next_in > static_cast<std::ptrdiff_t>(gzip.last.size())) {
      stream.next_in = end - gzip.last.size();
    }
    std::rotate(gzip.last.begin(), gzip.last.begin() + 1, gzip.last.end());
    gzip.last.back() = *stream.next_in;
  }
  stream.avail_in = static_cast<uInt>(step.avail_in);
  stream.next_out += made;
  stream.avail_out = static_cast<uInt>(step.avail_out);
  if (result == beast_zlib::error::end_of_stream) {
    gzip.part = Part::trailer;
    // Bytes that the stream took of what follows it.
    const std::size_t unused = biss::wasm::unused_bytes(step);
    for (std::size_t i = gzip.last.size() - unused; i < gzip.last.size(); ++i) {
      gzip.trailer |= std::uint64_t{gzip.last[i]} << 8U * gzip.trailer_bytes++;
    }
  } else if (is_fault(result)) {
    gzip.part = Part::wrong;
  }
}

void read_trailer(z_stream& stream, GzipStreamState& gzip) {
  constexpr unsigned bytes = 8;
  while (stream.avail_in != 0 && gzip.trailer_bytes != bytes) {
    gzip.trailer |= std::uint64_t{*stream.next_in++} << 8U * gzip.trailer_bytes++;
    --stream.avail_in;
  }
  if (gzip.trailer_bytes != bytes) return;
  const std::uint64_t expected = std::uint64_t{gzip.size_bytes} << 32U | gzip.checksum;
  gzip.part = gzip.trailer == expected ? Part::ended : Part::wrong;
}

}  // namespace

int inflateInit2(z_stream* stream, int /*window_bits*/) {
  stream->state = new (std::nothrow) GzipStreamState;
  return stream->state != nullptr ? Z_OK : Z_MEM_ERROR;
}

int inflateReset(z_stream* stream) {
  GzipStreamState& gzip = *stream->state;
  gzip.stream.reset();
  gzip.later.reset();
  gzip.header = {};
  gzip.part = Part::header;
  gzip.checksum = 0;
  gzip.size_bytes = 0;
  gzip.trailer = 0;
  gzip.trailer_bytes = 0;
  return Z_OK;
}

int inflate(z_stream* stream, int /*flush*/) {
  GzipStreamState& gzip = *stream->state;
  const uInt in = stream->avail_in;
  const uInt out = stream->avail_out;
  if (gzip.part == Part::header) read_header(*stream, gzip);
  if (gzip.part == Part::data) read_data(*stream, gzip);
  if (gzip.part == Part::trailer) read_trailer(*stream, gzip);
  if (gzip.part == Part::ended) return Z_STREAM_END;
  if (gzip.part == Part::wrong) return Z_DATA_ERROR;
  return in == stream->avail_in && out == stream->avail_out ? Z_BUF_ERROR : Z_OK;
}

int inflateEnd(z_stream* stream) {
  delete stream->state;
  stream->state = nullptr;
  return Z_OK;
}
