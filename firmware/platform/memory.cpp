// The functions that a compiler may call even in a freestanding program. No other part of a C
// library is linked.
#include <cstddef>
#include <cstdint>

// Without this, the compiler replaces the loop in memcpy by a call of memcpy.
#pragma GCC optimize("no-tree-loop-distribute-patterns")

namespace {

bool all_aligned(const void* a, const void* b) {
  return ((reinterpret_cast<std::uintptr_t>(a) | reinterpret_cast<std::uintptr_t>(b)) & 3U) == 0;
}

struct [[gnu::may_alias]] Word {
  std::uint32_t value;
};

}  // namespace

extern "C" {

void* memcpy(void* __restrict to, const void* __restrict from, std::size_t size) {
  auto* out = static_cast<std::uint8_t*>(to);
  const auto* in = static_cast<const std::uint8_t*>(from);
  if (all_aligned(to, from)) {
    for (; size >= 4; size -= 4, out += 4, in += 4) {
      reinterpret_cast<Word*>(out)->value = reinterpret_cast<const Word*>(in)->value;
    }
  }
  for (; size > 0; --size) *out++ = *in++;
  return to;
}

void* memmove(void* to, const void* from, std::size_t size) {
  auto* out = static_cast<std::uint8_t*>(to);
  const auto* in = static_cast<const std::uint8_t*>(from);
  if (out < in) {
    for (; size > 0; --size) *out++ = *in++;
  } else {
    while (size-- > 0) out[size] = in[size];
  }
  return to;
}

void* memset(void* to, int value, std::size_t size) {
  auto* out = static_cast<std::uint8_t*>(to);
  const auto byte = static_cast<std::uint8_t>(value);
  if (all_aligned(to, to)) {
    const std::uint32_t word = 0x01010101U * byte;
    for (; size >= 4; size -= 4, out += 4) reinterpret_cast<Word*>(out)->value = word;
  }
  for (; size > 0; --size) *out++ = byte;
  return to;
}

int memcmp(const void* a, const void* b, std::size_t size) {
  const auto* left = static_cast<const std::uint8_t*>(a);
  const auto* right = static_cast<const std::uint8_t*>(b);
  for (std::size_t i = 0; i < size; ++i) {
    if (left[i] != right[i]) return left[i] - right[i];
  }
  return 0;
}

void* memchr(const void* bytes, int value, std::size_t size) {
  const auto* in = static_cast<const std::uint8_t*>(bytes);
  for (std::size_t i = 0; i < size; ++i) {
    if (in[i] == static_cast<std::uint8_t>(value)) return const_cast<std::uint8_t*>(in + i);
  }
  return nullptr;
}

std::size_t strlen(const char* text) {
  std::size_t size = 0;
  while (text[size] != '\0') ++size;
  return size;
}

}  // extern "C"
