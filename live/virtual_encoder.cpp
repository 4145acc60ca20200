#include "live/virtual_encoder.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <tuple>
#include <utility>

#include "biss/base/bits.hpp"
#include "sim/fault_text.hpp"

namespace biss::live {

namespace {

// Decimal, with a sign if `Number` has one.
template <class Number>
std::optional<Number> number_of(std::string_view text) {
  Number number{};
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || problem != std::errc{} || end != text.data() + text.size()) return {};
  return number;
}

}  // namespace

VirtualEncoder::VirtualEncoder(const sim::FarEndSetup& setup, OnRequest on_request)
    : far_(setup),
      on_request_(std::move(on_request)),
      rules_(setup.line.faults),
      position_bits_(sim::position_word(setup.line.format).position_bits()) {}

void VirtualEncoder::put_ma(Picoseconds now, bool ma) {
  if (ma == ma_) return;
  ma_ = ma;
  far_.step(now, ma, true);
  if (far_.requests() == seen_) return;
  seen_ = far_.requests();
  if (far_.previous() != nullptr) put_request(*far_.previous());
}

void VirtualEncoder::finish(Picoseconds now) {
  far_.step(now, ma_, true);
  if (far_.cycle() != nullptr) put_request(*far_.cycle());
}

void VirtualEncoder::put_request(const sim::FarEndCycle& request) {
  if (request.faults != 0) {
    ++damaged_;
    last_faults_ = request.faults;
  }
  if (on_request_) on_request_(request);
}

std::string VirtualEncoder::command(std::string_view line, Picoseconds now) {
  const std::size_t blank = std::min(line.find(' '), line.size());
  const std::string_view verb = line.substr(0, blank);
  const std::string_view value = line.substr(std::min(blank + 1, line.size()));
  if (verb == "fault") return set_fault(std::string(value));
  if (verb == "at" || verb == "move") return set_position(value, verb == "move", now);
  if (verb == "nE") return set_flag(nE_, value);
  if (verb == "nW") return set_flag(nW_, value);
  if (verb == "status" && value.empty()) return status(now);
  if (verb == "motion") {
    const auto& names = sim::motion_names;
    const auto* const motion = std::find(names.begin(), names.end(), value);
    if (motion == names.end()) {
      return fmt::format("error: motion '{}' is not one of {}", value, fmt::join(names, ", "));
    }
    far_.set_motion(static_cast<sim::MotionKind>(motion - names.begin()));
    return fmt::format("ok motion {}", value);
  }
  for (const auto& [on, off, flag, fault] :
       {std::tuple("plug", "unplug", &plugged_, sim::FaultKind::cut),
        std::tuple("power on", "power off", &powered_, sim::FaultKind::brown_out)}) {
    if (line != on && line != off) continue;
    *flag = line == on;
    far_.set_lasting(fault, !*flag, now);
    return fmt::format("ok {}", line);
  }
  return fmt::format(
      "error: no command '{}'; the commands are fault KIND@next, fault KIND:RATE, fault off, at N, "
      "move N, motion KIND, nE 0|1, nW 0|1, unplug, plug, power off|on, status, quit",
      line);
}

std::string VirtualEncoder::set_fault(const std::string& text) {
  if (text == "off") {
    rules_.clear();
    far_.set_faults(rules_);
    return "ok no faults";
  }
  std::string numbered = text;
  constexpr std::string_view next = "@next";
  if (const std::size_t at = text.find(next); at != std::string::npos) {
    numbered.replace(at, next.size(), fmt::format("@{}", far_.requests()));
  }
  const auto rule = sim::parse_fault(numbered);
  if (!rule && rule.error() == sim::FaultTextError::form) {
    return fmt::format("error: '{}' is not KIND@next or KIND:RATE with a rate of 0 to 1, nor off",
                       text);
  }
  if (!rule || !is_of_far_end(rule->kind)) {
    return fmt::format("error: no kind of fault for '{}'; the kinds are {}", text,
                       fmt::join(sim::names_of(sim::is_of_far_end), ", "));
  }
  if (rule->place &&
      !places_of(rule->kind, rule->place->unit, far_.nominal()).contains(*rule->place)) {
    return fmt::format("error: '{}' has no such place on this line", text);
  }
  if (rule->cycle.value_or(far_.requests()) < far_.requests()) {
    return fmt::format("error: request {} has passed; the next one is {}", *rule->cycle,
                       far_.requests());
  }
  std::erase_if(rules_, [&](const sim::FaultRule& other) {
    const bool same = other.kind == rule->kind && other.cycle == rule->cycle;
    return same || (other.cycle && *other.cycle < far_.requests());
  });
  constexpr std::size_t most_rules = 1000;
  if (rules_.size() >= most_rules) return "error: 1000 faults are waiting; give fault off";
  rules_.push_back(*rule);
  far_.set_faults(rules_);
  return fmt::format("ok fault {}", numbered);
}

std::string VirtualEncoder::set_position(std::string_view text, bool relative, Picoseconds now) {
  const std::uint64_t most = low_mask(position_bits_);
  if (position_bits_ == 0) return "error: the format has no position";
  auto position = number_of<std::uint64_t>(text);
  if (relative) {
    const auto counts = number_of<std::int64_t>(text);
    if (!counts) return fmt::format("error: '{}' is not a number of counts", text);
    position = (far_.encoder().position_at(now) + static_cast<std::uint64_t>(*counts)) & most;
  }
  if (!position || *position > most) return fmt::format("error: '{}': give 0 to {}", text, most);
  far_.encoder().hold(*position);
  return fmt::format("ok at {}", *position);
}

std::string VirtualEncoder::set_flag(bool& flag, std::string_view text) {
  if (text != "0" && text != "1") return "error: give 0 (active) or 1";
  flag = text == "1";
  far_.set_flags(nE_, nW_);
  return fmt::format("ok nE {:d} nW {:d}", nE_, nW_);
}

std::string VirtualEncoder::status(Picoseconds now) {
  std::uint64_t damaged = damaged_;
  sim::FaultSet last = last_faults_;
  if (const auto* current = far_.cycle(); current != nullptr && current->faults != 0) {
    ++damaged;
    last = current->faults;
  }
  // JSON integers above 2^53 are strings.
  const std::uint64_t position = far_.encoder().position_at(now);
  const std::string_view quote = position >> 53U == 0 ? "" : "\"";
  return fmt::format(
      "ok {{\"requests\":{},\"faults\":{},\"position\":{}{}{},\"nE\":{:d},\"nW\":{:d},"
      "\"plugged\":{},\"powered\":{},\"last_cause\":{},\"time_ns\":{}}}",
      far_.requests(), damaged, quote, position, quote, nE_, nW_, plugged_, powered_,
      last == 0 ? "null" : '"' + sim::text_of(last) + '"', now.count / 1000);
}

}  // namespace biss::live
