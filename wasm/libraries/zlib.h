// The functions of zlib that the reader of gzip uses: a stream of one member at a time.
#pragma once

#include <cstdint>

using Bytef = unsigned char;
using uInt = unsigned int;

struct GzipStreamState;

struct z_stream {
  const Bytef* next_in;
  uInt avail_in;
  Bytef* next_out;
  uInt avail_out;
  GzipStreamState* state;
};

constexpr int Z_NO_FLUSH = 0;
constexpr int Z_OK = 0;
constexpr int Z_STREAM_END = 1;
constexpr int Z_DATA_ERROR = -3;
constexpr int Z_MEM_ERROR = -4;
constexpr int Z_BUF_ERROR = -5;

/// \pre window_bits selects gzip
int inflateInit2(z_stream* stream, int window_bits);
int inflateReset(z_stream* stream);
int inflate(z_stream* stream, int flush);
int inflateEnd(z_stream* stream);
