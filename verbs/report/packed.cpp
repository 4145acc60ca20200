#include "verbs/report/packed.hpp"

#include <openssl/evp.h>

#include "capture/zip.hpp"

namespace biss::verbs {

namespace {

std::string base64_of(std::string_view bytes) {
  std::string out((bytes.size() + 2) / 3 * 4 + 1, '\0');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                  reinterpret_cast<const unsigned char*>(bytes.data()),
                  static_cast<int>(bytes.size()));
  out.pop_back();  // the zero that it writes
  return out;
}

}  // namespace

std::string packed(std::string_view bytes) { return base64_of(capture::Deflater().gzip(bytes)); }

}  // namespace biss::verbs
