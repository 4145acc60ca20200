#include "capture/inflate.hpp"

#include <libdeflate.h>

#include <new>

namespace biss::capture {
namespace {

// Captures repeat themselves: beyond this the files get no smaller, only later.
constexpr int compression_level = 6;

template <class T>
T* or_throw(T* allocated) {
  if (allocated == nullptr) throw std::bad_alloc();
  return allocated;
}

}  // namespace

void Inflater::Free::operator()(libdeflate_decompressor* decompressor) const {
  libdeflate_free_decompressor(decompressor);
}

void Deflater::Free::operator()(libdeflate_compressor* compressor) const {
  libdeflate_free_compressor(compressor);
}

Inflater::Inflater() : decompressor_(or_throw(libdeflate_alloc_decompressor())) {}

Deflater::Deflater() : compressor_(or_throw(libdeflate_alloc_compressor(compression_level))) {}

bool Inflater::inflate(std::span<const std::uint8_t> deflated, std::span<std::uint8_t> into) {
  std::size_t used = 0;
  std::size_t made = 0;
  const auto result =
      libdeflate_deflate_decompress_ex(decompressor_.get(), deflated.data(), deflated.size(),
                                       into.data(), into.size(), &used, &made);
  return result == LIBDEFLATE_SUCCESS && used == deflated.size() && made == into.size();
}

void Deflater::deflate(std::span<const std::uint8_t> bytes, std::string& out) {
  const std::size_t before = out.size();
  out.resize(before + libdeflate_deflate_compress_bound(compressor_.get(), bytes.size()));
  const std::size_t made = libdeflate_deflate_compress(
      compressor_.get(), bytes.data(), bytes.size(), out.data() + before, out.size() - before);
  out.resize(before + made);
}

std::uint32_t zip_checksum(std::span<const std::uint8_t> bytes) {
  return libdeflate_crc32(0, bytes.data(), bytes.size());
}

}  // namespace biss::capture
