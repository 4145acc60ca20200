#include "verbs/report/packed.hpp"

#include <libdeflate.h>
#include <openssl/evp.h>

#include <memory>
#include <new>

namespace biss::verbs {

namespace {

// Without a name and a time.
std::string gzip_of(std::string_view bytes) {
  // As in archives of samples.
  constexpr int level = 6;
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
      libdeflate_alloc_compressor(level), libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  std::string out(libdeflate_gzip_compress_bound(compressor.get(), bytes.size()), '\0');
  out.resize(libdeflate_gzip_compress(compressor.get(), bytes.data(), bytes.size(), out.data(),
                                      out.size()));
  return out;
}

std::string base64_of(std::string_view bytes) {
  std::string out((bytes.size() + 2) / 3 * 4 + 1, '\0');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                  reinterpret_cast<const unsigned char*>(bytes.data()),
                  static_cast<int>(bytes.size()));
  out.pop_back();  // the zero that it writes
  return out;
}

}  // namespace

std::string packed(std::string_view bytes) { return base64_of(gzip_of(bytes)); }

}  // namespace biss::verbs
