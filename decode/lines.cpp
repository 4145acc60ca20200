#include "decode/lines.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <optional>
#include <tuple>

#include "decode/polarity.hpp"

namespace biss::decode {

namespace {

using Names = std::vector<std::string>;
using Edges = std::span<const wire::Edge>;

// Usual names in order of preference; the first `own_names` of each are names of BiSS itself, the
// others are common names of a clock and its data.
constexpr std::array<std::string_view, 12> ma_names{
    "ma", "ma+", "ma_p", "map", "ma_clk", "mclk", "clk", "clock", "sck", "sclk", "clk+", "clk_p"};
constexpr std::array<std::string_view, 14> slo_names{"slo",   "sl",     "slo+", "sl+", "slo_p",
                                                     "sl_p",  "data",   "dat",  "sdo", "miso",
                                                     "data+", "data_p", "sdat", "do"};
constexpr std::size_t own_names = 6;

constexpr std::size_t busiest_lines = 8;
constexpr std::size_t contents_kept = 256;
constexpr std::uint64_t points_of_structure = 20;

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

// A line that may be MA, or SLO, by its name.
struct Named {
  wire::LineIndex line = 0;
  std::string scope;     // the part of the name before the last dot
  std::string tag;       // `1` of MA1, `enc2` of enc2_MA
  std::size_t rank = 0;  // in the list of usual names

  // Names of BiSS itself belong together, and so do names of a clock and its data.
  std::size_t family() const { return rank < own_names ? 0 : 1; }
};

std::string scope_of(std::string_view name) {
  const std::size_t dot = name.find_last_of(".:");
  return lower(name.substr(0, dot == std::string_view::npos ? 0 : dot));
}

// The tag of `base` when it is `usual` with a number or a letter after it or, for BiSS's own names,
// with a prefix before it. The letters p and n name the two wires of one line.
std::optional<std::string> tag_of(std::string_view base, std::string_view usual, bool own) {
  if (base.starts_with(usual)) {
    std::string_view rest = base.substr(usual.size());
    const bool separate = rest.starts_with('_');
    if (separate) rest.remove_prefix(1);
    const bool letter = separate && rest.size() == 1 && rest != "n" && rest != "p" &&
                        std::isalpha(static_cast<unsigned char>(rest.front())) != 0;
    if (letter) return std::string(rest);
    if (!rest.empty() && rest.find_first_not_of("0123456789") == std::string_view::npos) {
      return std::string(rest);
    }
  }
  if (own && base.size() > usual.size() + 1 && base.ends_with(usual) &&
      base[base.size() - usual.size() - 1] == '_') {
    return std::string(base.substr(0, base.size() - usual.size() - 1));
  }
  return std::nullopt;
}

std::optional<Named> classify(wire::LineIndex line, std::string_view name,
                              std::span<const std::string_view> usual) {
  const std::string base = lower(name.substr(name.find_last_of(".:") + 1));
  Named named{.line = line, .scope = scope_of(name), .tag = {}, .rank = 0};
  for (const bool exact : {true, false}) {
    for (named.rank = 0; named.rank < usual.size(); ++named.rank) {
      const std::string_view wanted = usual[named.rank];
      if (exact && base == wanted) return named;
      const auto tag = exact ? std::nullopt : tag_of(base, wanted, named.rank < own_names);
      if (!tag) continue;
      named.tag = *tag;
      return named;
    }
  }
  return std::nullopt;
}

std::vector<Named> usual(const Names& names, std::span<const std::string_view> wanted) {
  std::vector<Named> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (auto named = classify(static_cast<wire::LineIndex>(i), names[i], wanted)) {
      found.push_back(std::move(*named));
    }
  }
  return found;
}

// The lines that match a name given by the user; more than one if several scopes have this name.
std::vector<Named> given(const Names& names, std::string_view wanted,
                         std::span<const std::string_view> usual) {
  const std::string key = lower(wanted);
  std::vector<Named> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string name = lower(names[i]);
    const bool whole = names[i] == wanted;
    const bool at_end = name.ends_with('.' + key) || name.ends_with(':' + key);
    if (name != key && !at_end) continue;
    const auto line = static_cast<wire::LineIndex>(i);
    Named named{.line = line, .scope = scope_of(names[i]), .tag = {}, .rank = 0};
    if (const auto known = classify(line, names[i], usual)) named.tag = known->tag;
    if (whole) return {named};
    found.push_back(std::move(named));
  }
  return found;
}

// How well two names fit together as a pair; lower is better. Empty if they do not belong together.
using Fit = std::tuple<bool, int, std::size_t, std::size_t, bool>;

std::optional<Fit> fit_of(const Named& ma, const Named& slo) {
  const bool same_tag = ma.tag == slo.tag;
  if (ma.line == slo.line || (!same_tag && !ma.tag.empty() && !slo.tag.empty())) {
    return std::nullopt;
  }
  const bool tagged = !ma.tag.empty() || !slo.tag.empty();
  const int scopes = ma.scope == slo.scope ? 0 : ma.scope.empty() || slo.scope.empty() ? 1 : 2;
  return Fit{tagged, scopes, ma.rank, slo.rank, !same_tag};
}

// The pairs that names allow and that fit best.
std::vector<Lines> best_fits(std::span<const Named> mas, std::span<const Named> slos) {
  std::vector<Lines> best;
  std::optional<Fit> best_fit;
  for (const Named& ma : mas) {
    for (const Named& slo : slos) {
      const auto fit = fit_of(ma, slo);
      if (!fit || (best_fit && *fit > *best_fit)) continue;
      if (best_fit && *fit < *best_fit) best.clear();
      best_fit = fit;
      best.push_back({ma.line, slo.line});
    }
  }
  return best;
}

// The result of decoding a pair.
struct Trial {
  Lines lines;
  // Good frames count most, then cycles with a START.
  std::uint64_t points = 0;
  std::uint64_t cycles = 0;
  // Hashes of the bits received in the first good cycles, sorted.
  std::vector<std::uint64_t> contents = {};

  bool carries_same(const Trial& other) const {
    std::vector<std::uint64_t> common;
    std::set_intersection(contents.begin(), contents.end(), other.contents.begin(),
                          other.contents.end(), std::back_inserter(common));
    return common.size() >= 2 &&
           4 * common.size() >= 3 * std::min(contents.size(), other.contents.size());
  }
  // Whether the pair is nearly as good as the best one, so that the user may mean it.
  bool rivals(const Trial& best) const {
    const bool swapped = lines.ma == best.lines.slo && lines.slo == best.lines.ma;
    return !swapped && points != 0 && 100 * points >= best.points &&
           5 * points * best.cycles >= 4 * best.points * cycles;
  }
};

std::uint64_t hash_of(BitView bits) {
  std::uint64_t hash = bits.size_bits();
  for (std::size_t at = 0; at < bits.size_bits(); at += 32) {
    const std::size_t count = std::min<std::size_t>(32, bits.size_bits() - at);
    hash = (hash ^ bits.word(at, static_cast<unsigned>(count))) * 0x9E37'79B9'7F4A'7C15U;
  }
  return hash;
}

Trial try_lines(const Lines& lines, Edges edges, const CycleReader& reader) {
  Trial trial{.lines = lines};
  Decoder decoder(reader, [&](const Cycle& cycle) {
    ++trial.cycles;
    if (cycle.status == CycleStatus::crc) trial.points += 10;
    if (cycle.ack) ++trial.points;
    if (!is_good(cycle.status)) return;
    trial.points += cycle.frame ? 1000U : points_of_structure;
    if (trial.contents.size() < contents_kept) trial.contents.push_back(hash_of(cycle.raw.view()));
  });
  const std::vector<wire::Edge> pair = first_edges(lines, edges);
  decoder.push(pair, lines);
  decoder.finish(pair.empty() ? Picoseconds{} : pair.back().time);
  auto& contents = trial.contents;
  std::sort(contents.begin(), contents.end());
  contents.erase(std::unique(contents.begin(), contents.end()), contents.end());
  return trial;
}

// The pairs that the user may mean, the best one first; empty if none behaves like MA and SLO.
std::vector<Trial> plausible(std::span<const Lines> pairs, Edges edges, const CycleReader& reader) {
  std::vector<Trial> trials;
  for (const Lines& lines : pairs) trials.push_back(try_lines(lines, edges, reader));
  const auto best_one = [&] {
    return std::max_element(trials.begin(), trials.end(),
                            [](const Trial& a, const Trial& b) { return a.points < b.points; });
  };
  auto best = best_one();
  if (best == trials.end()) return {};
  if (best->points < points_of_structure * best->cycles / 2) {
    for (Trial& trial : trials) {
      trial = try_lines(find_polarity(trial.lines, edges, reader), edges, reader);
    }
    best = best_one();
  }
  if (best->points == 0) return {};
  std::rotate(trials.begin(), best, best + 1);
  std::erase_if(trials, [first = trials.front()](const Trial& t) { return !t.rivals(first); });
  return trials;
}

std::vector<Lines> lines_of(std::span<const Trial> trials) {
  std::vector<Lines> lines;
  for (const Trial& trial : trials) lines.push_back(trial.lines);
  return lines;
}

using Choice = tl::expected<std::vector<Lines>, LineError>;

// One of several pairs.
Choice choose_one(std::span<const Lines> pairs, Edges edges, const CycleReader& reader,
                  LineProblem when_none) {
  const auto trials = plausible(pairs, edges, reader);
  if (trials.empty()) {
    LineError error{when_none, {}};
    if (when_none == LineProblem::ambiguous) error.candidates.assign(pairs.begin(), pairs.end());
    return tl::unexpected(error);
  }
  const bool one = std::all_of(trials.begin() + 1, trials.end(), [&](const Trial& trial) {
    return trial.carries_same(trials.front());
  });
  if (!one) return tl::unexpected(LineError{LineProblem::ambiguous, lines_of(trials)});
  return std::vector{trials.front().lines};
}

// Empty unless two SLO share one MA, and an MA that is in none of the pairs fits one of them too:
// the data does not decide which MA belongs to which SLO. The result is then these pairs and the
// others that fit.
std::vector<Lines> unsettled_pairs(const std::vector<Lines>& each, std::span<const Named> mas,
                                   Edges edges, const CycleReader& reader) {
  const auto pairs_with = [&](wire::LineIndex ma) {
    return std::count_if(each.begin(), each.end(), [ma](const Lines& a) { return a.ma == ma; });
  };
  std::vector<Lines> all = each;
  for (const Named& ma : mas) {
    if (pairs_with(ma.line) != 0) continue;
    for (const Lines& lines : each) {
      const Lines other{ma.line, lines.slo};
      if (pairs_with(lines.ma) > 1 && try_lines(other, edges, reader).points != 0) {
        all.push_back(other);
      }
    }
  }
  return all.size() == each.size() ? std::vector<Lines>() : all;
}

// The MA of each SLO.
Choice choose_each(std::span<const Named> mas, std::span<const Named> slos, Edges edges,
                   const CycleReader& reader) {
  std::vector<Lines> each;
  for (const Named& slo : slos) {
    std::vector<Named> family;
    std::copy_if(mas.begin(), mas.end(), std::back_inserter(family),
                 [&](const Named& ma) { return ma.family() == slo.family(); });
    const auto pairs = best_fits(family, {&slo, 1});
    if (pairs.size() == 1) each.push_back(pairs.front());
    if (pairs.size() < 2) continue;
    const auto one = choose_one(pairs, edges, reader, LineProblem::ambiguous);
    if (!one) return one;
    each.push_back(one->front());
  }
  if (auto unsettled = unsettled_pairs(each, mas, edges, reader); !unsettled.empty()) {
    return tl::unexpected(LineError{LineProblem::ambiguous, std::move(unsettled)});
  }
  return each;
}

// The lines that change, busiest first.
std::vector<wire::LineIndex> moving_lines(std::size_t lines, Edges edges) {
  std::vector<std::size_t> moves(lines, 0);
  for (const wire::Edge& edge : edges) ++moves[edge.line];
  std::vector<wire::LineIndex> moving;
  for (std::size_t i = 0; i < lines; ++i) {
    // The first edge of a line is its initial level.
    if (moves[i] > 1) moving.push_back(static_cast<wire::LineIndex>(i));
  }
  std::stable_sort(moving.begin(), moving.end(),
                   [&](auto a, auto b) { return moves[a] > moves[b]; });
  moving.resize(std::min(moving.size(), busiest_lines));
  return moving;
}

Choice by_behaviour(const Names& names, Edges edges, std::span<const Named> mas,
                    std::span<const Named> slos, bool each, const CycleReader& reader) {
  const std::vector<wire::LineIndex> moving = moving_lines(names.size(), edges);
  if (moving.size() < 2 && (mas.empty() || slos.empty())) {
    return tl::unexpected(LineError{LineProblem::too_few_lines, {}});
  }
  const auto lines_or_moving = [&](std::span<const Named> named) {
    std::vector<wire::LineIndex> lines;
    for (const Named& line : named) lines.push_back(line.line);
    return lines.empty() ? moving : lines;
  };
  std::vector<Lines> pairs;
  for (const wire::LineIndex ma : lines_or_moving(mas)) {
    for (const wire::LineIndex slo : lines_or_moving(slos)) {
      if (ma != slo) pairs.push_back({ma, slo});
    }
  }
  if (!each) return choose_one(pairs, edges, reader, LineProblem::nothing_behaves);
  const auto found = lines_of(plausible(pairs, edges, reader));
  if (found.empty()) return tl::unexpected(LineError{LineProblem::nothing_behaves, {}});
  for (const Lines& a : found) {
    // Pairs that share SLO do not show whose answer it is.
    const bool shared = std::any_of(found.begin(), found.end(), [&](const Lines& b) {
      return a.ma != b.ma && (a.slo == b.slo || a.slo == b.ma);
    });
    if (shared) return tl::unexpected(LineError{LineProblem::ambiguous, found});
  }
  return found;
}

}  // namespace

tl::expected<std::vector<FoundLines>, LineError> find_lines(const Names& names, Edges beginning,
                                                            const LineRequest& request,
                                                            const CycleReader& reader) {
  const bool ma_given = !request.ma.empty();
  const bool slo_given = !request.slo.empty();
  const auto mas = ma_given ? given(names, request.ma, ma_names) : usual(names, ma_names);
  const auto slos = slo_given ? given(names, request.slo, slo_names) : usual(names, slo_names);
  if (ma_given && mas.empty()) return tl::unexpected(LineError{LineProblem::no_such_ma, {}});
  if (slo_given && slos.empty()) return tl::unexpected(LineError{LineProblem::no_such_slo, {}});
  if (mas.size() == 1 && slos.size() == 1 && mas.front().line == slos.front().line) {
    return tl::unexpected(LineError{LineProblem::same_line, {}});
  }
  LineOrigin origin = ma_given && slo_given ? LineOrigin::given : LineOrigin::by_name;
  const std::vector<Lines> fits = best_fits(mas, slos);
  Choice chosen;
  if (request.each && !fits.empty()) chosen = choose_each(mas, slos, beginning, reader);
  if (!request.each && !fits.empty()) {
    chosen = fits.size() == 1 ? Choice(fits)
                              : choose_one(fits, beginning, reader, LineProblem::ambiguous);
  }
  if (chosen && chosen->empty()) {
    if (origin == LineOrigin::by_name) origin = LineOrigin::by_behaviour;
    // If names of both kinds exist but no two belong together, names are ignored.
    const bool use_names = mas.empty() || slos.empty();
    chosen = by_behaviour(
        names, beginning, ma_given || use_names ? std::span(mas) : std::span<const Named>(),
        slo_given || use_names ? std::span(slos) : std::span<const Named>(), request.each, reader);
  }
  if (!chosen) {
    LineError error = chosen.error();
    if (error.problem == LineProblem::ambiguous && !request.each) {
      error.each_helps =
          find_lines(names, beginning, {request.ma, request.slo, true}, reader).has_value();
    }
    return tl::unexpected(error);
  }
  std::vector<FoundLines> found;
  for (const Lines& lines : *chosen) {
    found.push_back({.lines = lines, .origin = origin});
    if (origin == LineOrigin::by_behaviour) continue;
    found.back().look_swapped = try_lines(lines, beginning, reader).points == 0 &&
                                try_lines({lines.slo, lines.ma}, beginning, reader).points != 0;
  }
  if (!request.each && !ma_given && !slo_given && !fits.empty()) {
    const auto each = choose_each(mas, slos, beginning, reader);
    found.front().further_pairs = !each || each->size() > 1;
  }
  return found;
}

tl::expected<wire::LineIndex, LineError> find_ma(const Names& names, Edges beginning,
                                                 std::string_view ma, const CycleReader& reader) {
  auto mas = given(names, ma.empty() ? ma_names.front() : ma, ma_names);
  if (!ma.empty() && mas.empty()) return tl::unexpected(LineError{LineProblem::no_such_ma, {}});
  if (mas.empty() && names.size() == 1) return wire::LineIndex{0};
  if (mas.size() == 1) return mas.front().line;
  const auto found = find_lines(names, beginning, {ma, {}, false}, reader);
  if (found) return found->front().lines.ma;
  if (mas.empty()) return tl::unexpected(found.error());
  LineError error{LineProblem::ambiguous, {}};
  for (const Named& named : mas) error.candidates.push_back({named.line, named.line});
  return tl::unexpected(error);
}

}  // namespace biss::decode
