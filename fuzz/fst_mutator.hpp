// Mutations of an FST that mostly leave one that can be read: it is taken apart, a part is changed,
// and it is put together again with the sizes that follow. Nothing in the result is compressed.
#pragma once

#include <lz4.h>

#include "capture/fst_file.hpp"
#include "capture/test_fst.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/mutate.hpp"

namespace biss::fuzz {

class FstMutator {
 public:
  explicit FstMutator(SplitMix& random) : random_(random) {}

  std::string mutate(const std::string& file) {
    if (!take_apart(file)) take_apart(fst_seed(random_()));
    change(below(24));
    return capture::fst_of(parts_);
  }

 private:
  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(random_() % limit); }

  // Only files of fst_of(); any other is not taken apart.
  bool take_apart(std::string_view file) {
    parts_ = {};
    std::size_t at = 0;
    while (file.size() - at >= 9) {
      const auto kind = static_cast<std::uint8_t>(file[at]);
      const std::uint64_t size = big_endian(file.substr(at + 1, 8));
      if (size < 8 || size > file.size() - at - 1) return false;
      const std::string_view content = file.substr(at + 9, static_cast<std::size_t>(size) - 8);
      at += static_cast<std::size_t>(size) + 1;
      if (!take_section(kind, content)) return false;
    }
    return !parts_.blocks.empty() && !parts_.hierarchy.empty();
  }

  bool take_section(std::uint8_t kind, std::string_view content) {
    if (kind == 0 && content.size() > 64) parts_.exponent = static_cast<std::int8_t>(content[64]);
    if (kind == 2) parts_.blackouts = content;
    if (kind == 3 && content.size() >= 16) {
      parts_.handles = big_endian(content.substr(8, 8));
      parts_.geometry = content.substr(16);
    }
    if (kind == 6 && content.size() >= 8) return take_hierarchy(content);
    if (kind == 1 || kind == 5 || kind == 8) return take_block(kind, content);
    return true;
  }

  bool take_hierarchy(std::string_view content) {
    const std::uint64_t size = big_endian(content.substr(0, 8));
    if (size > 4'096) return false;
    parts_.hierarchy.resize(static_cast<std::size_t>(size));
    const int made =
        LZ4_decompress_safe(content.data() + 8, parts_.hierarchy.data(),
                            static_cast<int>(content.size() - 8), static_cast<int>(size));
    return made == static_cast<int>(size);
  }

  bool take_block(std::uint8_t kind, std::string_view content) {
    capture::FstPartsBlock block;
    block.kind = kind;
    capture::FstCursor cursor(
        {reinterpret_cast<const std::uint8_t*>(content.data()), content.size()});
    block.begin = cursor.fixed64();
    cursor.fixed64();
    cursor.fixed64();
    const std::uint64_t frame = cursor.varint();
    cursor.varint();
    cursor.varint();
    if (cursor.failed() || content.size() < cursor.at() + 34 ||
        frame > content.size() - cursor.at() - 34) {
      return false;
    }
    block.frame = content.substr(cursor.at(), static_cast<std::size_t>(frame));
    content.remove_prefix(cursor.at() + block.frame.size() + 1);  // the number of variables is 0
    block.packing = content[0];
    content.remove_prefix(1);
    block.times_count = big_endian(content.substr(content.size() - 8));
    const std::uint64_t times = big_endian(content.substr(content.size() - 24, 8));
    content.remove_suffix(24);
    if (times > content.size() - 8) return false;
    block.times = content.substr(content.size() - static_cast<std::size_t>(times));
    content.remove_suffix(block.times.size());
    const std::uint64_t index = big_endian(content.substr(content.size() - 8));
    content.remove_suffix(8);
    if (index > content.size()) return false;
    block.index = content.substr(content.size() - static_cast<std::size_t>(index));
    block.chains = content.substr(0, content.size() - block.index.size());
    parts_.blocks.push_back(std::move(block));
    return true;
  }

  static std::uint64_t big_endian(std::string_view bytes) {
    std::uint64_t value = 0;
    for (const char byte : bytes) value = value << 8U | static_cast<unsigned char>(byte);
    return value;
  }

  void change(std::size_t kind) {
    capture::FstPartsBlock& block = parts_.blocks[below(parts_.blocks.size())];
    if (kind < 8) return change_number(block.times);
    if (kind < 14) return change_number(block.chains);
    switch (kind) {
      case 14:
        block.chains = changed_bytes(block.chains, 16);
        return;
      case 15:
        block.index = changed_bytes(block.index, 4);
        return;
      case 16:
        block.times_count = random_() >> below(64);
        return;
      case 17:
        block.frame = changed_bytes(block.frame, 4);
        return;
      case 18:
        parts_.hierarchy = changed_bytes(parts_.hierarchy, 32);
        return;
      case 19:
        change_geometry();
        return;
      case 20:
        parts_.blackouts = changed_bytes(parts_.blackouts, 8);
        return;
      case 21:
        parts_.exponent = static_cast<std::int8_t>(below(26) - 23);
        return;
      case 22:
        change_blocks(block);
        return;
      default:
        change_packing(block);
    }
  }

  void change_geometry() {
    if (below(4) == 0) parts_.handles = random_() >> below(64);
    parts_.geometry = changed_bytes(parts_.geometry, 4);
    if (below(2) == 0) parts_.handles = parts_.geometry.size();
  }

  void change_blocks(capture::FstPartsBlock& block) {
    if (below(2) == 0 && parts_.blocks.size() < 6) {
      parts_.blocks.push_back(capture::FstPartsBlock(block));
    } else if (parts_.blocks.size() > 1) {
      parts_.blocks.erase(parts_.blocks.begin());
    }
    parts_.blocks.back().begin = random_() >> below(64);
  }

  void change_packing(capture::FstPartsBlock& block) {
    static constexpr std::array<std::uint8_t, 3> kinds{1, 5, 8};
    block.kind = kinds[below(kinds.size())];
    block.packing = "4FZ!x"[below(5)];
    // A chain that is said to be packed.
    if (!block.chains.empty() && below(2) == 0) block.chains[0] = static_cast<char>(below(256));
  }

  // A number of one byte becomes another one, is doubled, or goes.
  void change_number(std::string& numbers) {
    if (numbers.empty()) return;
    const std::size_t at = below(numbers.size());
    switch (below(4)) {
      case 0:
        if (numbers.size() < 4'096) numbers.insert(at, 1, numbers[at]);
        return;
      case 1:
        numbers.erase(at, 1);
        return;
      default:
        numbers[at] = static_cast<char>(numbers[at] ^ (1 << below(8)));
    }
  }

  capture::FstParts parts_;
  SplitMix& random_;
};

}  // namespace biss::fuzz
