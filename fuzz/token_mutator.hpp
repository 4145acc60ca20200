// Mutations of text that leave most of it readable: they change tokens instead of bytes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "fuzz/capture_seeds.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace biss::fuzz {

/// Changes a few tokens of a text at random places; the cost hardly depends on its length.
class TokenMutator {
 public:
  /// `delimiters` end tokens; `words` are inserted as tokens.
  TokenMutator(std::string text, std::string_view delimiters,
               std::span<const std::string_view> words, std::uint64_t seed)
      : text_(std::move(text)), delimiters_(delimiters), words_(words), random_{seed} {}

  std::string mutate() {
    const std::size_t times = 1 + below(3);
    for (std::size_t i = 0; i < times && !text_.empty(); ++i) change_one();
    return std::move(text_);
  }

 private:
  // Bytes first…end of the text.
  struct Range {
    std::size_t first;
    std::size_t end;
    std::size_t size() const { return end - first; }
  };

  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(random_() % limit); }

  Range any_token() {
    const std::size_t at = below(text_.size());
    const std::size_t before = text_.find_last_of(delimiters_, at);
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    return {first, std::max(first, std::min(text_.find_first_of(delimiters_, at), text_.size()))};
  }

  // Several consecutive tokens with their delimiters.
  Range any_span() {
    Range span = any_token();
    for (std::size_t more = below(16); more > 0 && span.end < text_.size(); --more) {
      span.end = std::min(text_.find_first_of(delimiters_, span.end + 1), text_.size());
    }
    span.end = std::min(span.end + 1, text_.size());
    return span;
  }

  std::string text_of(Range range) const { return text_.substr(range.first, range.size()); }

  void change_one() {
    switch (below(8)) {
      case 0:
        return change_digit(any_token());
      case 1:
      case 2:
        return change_number(any_token());
      case 3:
        return drop(any_token());
      case 4:
        return duplicate(any_token());
      case 5:
        return swap();
      case 6:
        return duplicate(any_span());
      default:
        return replace(any_token(), words_[below(words_.size())]);
    }
  }

  void replace(Range range, std::string_view by) { text_.replace(range.first, range.size(), by); }
  void drop(Range range) { text_.erase(range.first, range.size()); }
  void duplicate(Range range) { text_.insert(any_token().first, text_of(range)); }

  void swap() {
    Range a = any_token();
    Range b = any_token();
    if (b.first < a.first) std::swap(a, b);
    if (b.first < a.end) return;
    const std::string first = text_of(a);
    const std::string second = text_of(b);
    replace(b, first);
    replace(a, second);
  }

  void change_digit(Range range) {
    if (range.size() == 0) return;
    char& c = text_[range.first + below(range.size())];
    if (c >= '0' && c <= '9') c = static_cast<char>('0' + below(10));
  }

  // Adds a little to the last number of the token, so that times move but mostly stay in order.
  void change_number(Range range) {
    const std::string token = text_of(range);
    const std::size_t last = token.find_last_of("0123456789");
    if (last == std::string::npos) return;
    std::size_t first = last;
    while (first > 0 && token[first - 1] >= '0' && token[first - 1] <= '9') --first;
    if (last - first > 17) return;
    std::uint64_t value = std::stoull(token.substr(first, last - first + 1));
    const std::uint64_t step = random_() >> (44 + below(20));
    value = below(2) == 0 && value >= step ? value - step : value + step;
    replace({range.first + first, range.first + last + 1}, std::to_string(value));
  }

  std::string text_;
  std::string_view delimiters_;
  std::span<const std::string_view> words_;
  SplitMix random_;
};

/// The body of a custom mutator: mostly tokens, sometimes bytes, and a new seed if the text is too
/// small to be a capture.
template <class MakeSeed>
std::size_t mutate_capture(std::span<std::uint8_t> space, std::size_t size, unsigned seed,
                           std::string_view delimiters, std::span<const std::string_view> words,
                           MakeSeed make_seed) {
  constexpr std::size_t smallest_capture = 64;
  if (seed % 16 == 0 && size != 0) return LLVMFuzzerMutate(space.data(), size, space.size());
  const std::string_view text(reinterpret_cast<const char*>(space.data()), size);
  const bool fresh = size < smallest_capture || seed % 8 == 1;
  std::string begin = fresh ? make_seed(std::uint64_t{seed}) : std::string(text);
  const std::string result = TokenMutator(std::move(begin), delimiters, words, seed).mutate();
  const std::size_t kept = std::min(result.size(), space.size());
  std::memcpy(space.data(), result.data(), kept);
  return kept;
}

}  // namespace biss::fuzz
