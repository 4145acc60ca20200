// What the Deflate of Boost.Beast leaves to its caller at the end of the data.
#pragma once

#include <array>
#include <boost/beast/zlib/inflate_stream.hpp>
#include <cstddef>
#include <cstdint>

namespace biss::wasm {

/// Whole bytes that the stream has taken from its input and not used. \pre it has ended
inline std::size_t unused_bytes(const boost::beast::zlib::z_params& step) {
  constexpr int bits = 63;
  return static_cast<std::size_t>(step.data_type & bits) / 8;
}

/// The last code of a stream may be shorter than what the stream wants to see before it reads a code:
/// gives it more, after all input. The error is `end_of_stream` where it has ended without the bytes
/// added.
inline void inflate_last_code(boost::beast::zlib::inflate_stream& stream,
                              boost::beast::zlib::z_params& step,
                              boost::system::error_code& result) {
  namespace zlib = boost::beast::zlib;
  constexpr std::array<std::uint8_t, 4> more{};
  step.next_in = more.data();
  step.avail_in = more.size();
  stream.write(step, zlib::Flush::finish, result);
  const std::size_t taken = more.size() - step.avail_in;
  if (result == zlib::error::end_of_stream && unused_bytes(step) < taken) {
    result = zlib::error::need_buffers;
  }
  // Of the input none is left, and the bytes added are not counted.
  step.data_type -= static_cast<int>(8 * taken);
  step.avail_in = 0;
}

}  // namespace biss::wasm
