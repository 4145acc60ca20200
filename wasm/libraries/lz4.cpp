#include <lz4.h>

#include <algorithm>
#include <cstddef>
#include <span>

namespace {

// A block: tokens, each with literals and, but for the last one, a match.
class Lz4Block {
 public:
  Lz4Block(std::span<const unsigned char> in, std::span<unsigned char> out) : in_(in), out_(out) {}

  // The bytes made; -1 where the block is damaged.
  std::ptrdiff_t unpack() {
    for (;;) {
      std::size_t token = 0;
      if (!next(token)) return -1;
      if (!copy_literals(token >> 4U)) return -1;
      if (at_ == in_.size()) return static_cast<std::ptrdiff_t>(made_);
      if (!copy_match(token & 15U)) return -1;
    }
  }

 private:
  bool next(std::size_t& byte) {
    if (at_ == in_.size()) return false;
    byte = in_[at_++];
    return true;
  }

  // A length of 15 goes on in further bytes.
  bool extend(std::size_t& length) {
    std::size_t more = 255;
    if (length != 15) return true;
    while (more == 255) {
      if (!next(more)) return false;
      length += more;
    }
    return true;
  }

  bool copy_literals(std::size_t count) {
    if (!extend(count)) return false;
    if (count > in_.size() - at_ || count > out_.size() - made_) return false;
    std::copy_n(in_.data() + at_, count, out_.data() + made_);
    at_ += count;
    made_ += count;
    return true;
  }

  bool copy_match(std::size_t count) {
    std::size_t low = 0;
    std::size_t high = 0;
    if (!next(low) || !next(high) || !extend(count)) return false;
    const std::size_t distance = high << 8U | low;
    count += 4;
    if (distance == 0 || distance > made_ || count > out_.size() - made_) return false;
    // Byte by byte: a match may overlap what it makes.
    for (; count != 0; --count, ++made_) out_[made_] = out_[made_ - distance];
    return true;
  }

  std::span<const unsigned char> in_;
  std::span<unsigned char> out_;
  std::size_t at_ = 0;
  std::size_t made_ = 0;
};

}  // namespace

int LZ4_decompress_safe(const char* in, char* out, int in_bytes, int out_bytes) {
  const std::span<const unsigned char> from(reinterpret_cast<const unsigned char*>(in),
                                            static_cast<std::size_t>(in_bytes));
  const std::span<unsigned char> to(reinterpret_cast<unsigned char*>(out),
                                    static_cast<std::size_t>(out_bytes));
  return static_cast<int>(Lz4Block(from, to).unpack());
}
