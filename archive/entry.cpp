#include "archive/entry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <compare>

#include "report/text.hpp"

namespace biss::archive {

namespace {

// A share of cycles; 0 of 0 is 0.
struct Share {
  std::uint64_t part = 0;
  std::uint64_t whole = 0;
};

std::strong_ordering compare(const Share& a, const Share& b) {
  if (a.part == 0 || b.part == 0) return (a.part != 0) <=> (b.part != 0);
  using Product = unsigned __int128;
  return Product{a.part} * b.whole <=> Product{b.part} * a.whole;
}

// The shares of the cycles of a link that make it bad, the worst first. The last one is not a
// finding: without a frame format the checksums cannot be judged.
constexpr std::size_t share_count = 6;
using Shares = std::array<Share, share_count>;

Shares shares_of(const Counts& counts) {
  return {{{counts.faults(), counts.cycles},
           {counts.errors, counts.cycles},
           {counts.limited, counts.cycles},
           {counts.marginal, counts.margin_judged},
           {counts.warnings, counts.cycles},
           {counts.count(CycleStatus::unchecked), counts.cycles}}};
}

bool is_damaged(const FileEntry& entry) { return !entry.cause.empty() && !is_foreign(entry.cause); }

// The highest share of any link.
Shares worst_shares(const FileEntry& entry) {
  Shares worst{};
  for (const LinkEntry& link : entry.links) {
    const auto shares = shares_of(link.counts);
    for (std::size_t i = 0; i < worst.size(); ++i) {
      if (compare(shares[i], worst[i]) > 0) worst[i] = shares[i];
    }
  }
  return worst;
}

// 0 comes first.
int rank_of(const FileEntry& entry) {
  if (entry.links.empty()) return entry.has_finding() ? 1 : 4;
  if (entry.has_finding()) return 0;
  return worst_shares(entry).back().part != 0 ? 2 : 3;
}

}  // namespace

bool is_foreign(std::string_view cause) {
  constexpr std::array<std::string_view, 7> foreign{
      "unknown_format", "layout_missing", "no_lines", "other_protocol",
      "no_such_line",   "not_a_file",     "link"};
  return std::find(foreign.begin(), foreign.end(), cause) != foreign.end();
}

bool FileEntry::has_finding() const {
  if (is_damaged(*this)) return true;
  return std::any_of(links.begin(), links.end(), [](const LinkEntry& link) {
    const auto shares = shares_of(link.counts);
    return std::any_of(shares.begin(), std::prev(shares.end()),
                       [](const Share& share) { return share.part != 0; });
  });
}

bool is_worse(const FileEntry& a, const FileEntry& b) {
  if (rank_of(a) != rank_of(b)) return rank_of(a) < rank_of(b);
  const auto of_a = worst_shares(a);
  const auto of_b = worst_shares(b);
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    const auto order = compare(of_a[i], of_b[i]);
    if (order != 0) return order > 0;
  }
  if (is_damaged(a) != is_damaged(b)) return is_damaged(a);
  return a.path < b.path;
}

std::string utf8_text(std::string_view text) {
  std::string escaped;
  bool valid = text.find("\\x") == std::string_view::npos;
  for (std::string_view rest = text; !rest.empty();) {
    const report::CodePoint point = report::front_code_point(rest);
    valid = valid && point.valid;
    if (point.valid && rest.front() != '\\') {
      escaped.append(rest.substr(0, point.bytes));
    } else {
      escaped += fmt::format("\\x{:02X}", static_cast<unsigned char>(rest.front()));
    }
    rest.remove_prefix(point.bytes);
  }
  return valid ? std::string(text) : escaped;
}

}  // namespace biss::archive
