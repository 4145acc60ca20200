// Mutations that leave most of an input readable.
#pragma once

#include "fuzz/target.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace biss::fuzz {

/// SplitMix64: numbers that look random, from any seed, without a large state to set up.
struct SplitMix {
  std::uint64_t state;

  std::uint64_t operator()() {
    state += 0x9E37'79B9'7F4A'7C15U;
    std::uint64_t z = state;
    z = (z ^ (z >> 30U)) * 0xBF58'476D'1CE4'E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D0'49BB'1331'11EBU;
    return z ^ (z >> 31U);
  }
};

/// Changed by libFuzzer, at most `growth` bytes longer.
inline std::string changed_bytes(std::string bytes, std::size_t growth) {
  const std::size_t size = bytes.size();
  bytes.resize(size + growth);
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(bytes.data()), size, bytes.size()));
  return bytes;
}

/// Changes tokens of a text instead of bytes, which leaves most of it readable. The cost hardly
/// depends on the length of the text.
class TokenMutator {
 public:
  /// `delimiters` end tokens; `words` are separated by '|' and inserted as tokens.
  TokenMutator(std::string text, std::string_view delimiters, std::string_view words,
               SplitMix& random)
      : text_(std::move(text)), delimiters_(delimiters), words_(words), random_(random) {}

  /// The text with one to `most` changes.
  std::string mutate(std::size_t most = 3) {
    const std::size_t times = 1 + below(most);
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

  std::string_view any_word() {
    const auto words = static_cast<std::size_t>(std::count(words_.begin(), words_.end(), '|')) + 1;
    std::string_view rest = words_;
    for (std::size_t i = below(words); i > 0; --i) rest.remove_prefix(rest.find('|') + 1);
    return rest.substr(0, rest.find('|'));
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
        return replace(any_token(), any_word());
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
  std::string_view words_;
  SplitMix& random_;
};

/// The body of a custom mutator: mostly `mutate`, sometimes bytes, and a new seed if the input is too
/// small to be a capture. A result that is too large is cut off, or `whole` and then not used.
template <class MakeSeed, class Mutate>
std::size_t mutate_input(std::span<std::uint8_t> space, std::size_t size, unsigned seed,
                         MakeSeed make_seed, Mutate mutate, bool whole = false) {
  constexpr std::size_t smallest_capture = 64;
  SplitMix random{seed};
  if (size != 0 && random() % 16 == 0) {
    return LLVMFuzzerMutate(space.data(), size, space.size());
  }
  const std::string before(reinterpret_cast<const char*>(space.data()), size);
  const bool fresh = size < smallest_capture || random() % 8 == 0;
  // The seeds 1, 9, 17 … have a good frame of the usual format and are short.
  std::string after =
      mutate(fresh ? make_seed((random() & ~std::uint64_t{7}) | 1U) : before, random);
  if (whole && after.size() > space.size()) after = before;
  const std::size_t kept = std::min(after.size(), space.size());
  std::copy_n(after.begin(), kept, space.begin());
  return kept;
}

}  // namespace biss::fuzz
