// Memory that is used again and again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <utility>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace biss::capture {

/// Numbers that have any value until they are set: a vector that grows does not fill them with zeros.
template <class T>
class Unfilled : public std::allocator<T> {
 public:
  template <class Other>
  struct rebind {
    using other = Unfilled<Other>;
  };

  Unfilled() = default;
  template <class Other>
  explicit(false) Unfilled(const Unfilled<Other>&) {}

  void construct(T* at) { ::new (static_cast<void*>(at)) T; }
  template <class Value>
  void construct(T* at, Value&& value) {
    ::new (static_cast<void*>(at)) T(std::forward<Value>(value));
  }
};

/// Bytes that are not filled with zeros first.
class Buffer {
 public:
  /// `bytes` bytes of any content, valid until the next call.
  std::span<std::uint8_t> take(std::size_t bytes) {
    if (bytes > capacity_) {
      bytes_.reset();
      capacity_ = 0;  // also if there is no memory
      bytes_.reset(bytes < large_page ? allocated(bytes, alignof(std::max_align_t))
                                      : in_large_pages(bytes));
      capacity_ = bytes;
    }
    return {bytes_.get(), bytes};
  }

 private:
  struct Free {
    void operator()(std::uint8_t* bytes) const { std::free(bytes); }
  };

  static constexpr std::size_t large_page = std::size_t{2} << 20U;

  static std::uint8_t* allocated(std::size_t bytes, std::size_t alignment) {
    const std::size_t whole = (bytes + alignment - 1) / alignment * alignment;
    void* const got = std::aligned_alloc(alignment, whole);
    if (got == nullptr) throw std::bad_alloc();
    return static_cast<std::uint8_t*>(got);
  }

  // Inflating and scanning spend up to a third of their time on small pages.
  static std::uint8_t* in_large_pages(std::size_t bytes) {
    std::uint8_t* const got = allocated(bytes, large_page);
#ifdef MADV_HUGEPAGE
    // A part of a large page stays in small ones. If the system has no large pages, nothing
    // changes.
    static_cast<void>(madvise(got, bytes / large_page * large_page, MADV_HUGEPAGE));
#endif
    return got;
  }

  std::unique_ptr<std::uint8_t, Free> bytes_;
  std::size_t capacity_ = 0;
};

}  // namespace biss::capture
