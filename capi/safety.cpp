// biss_safety: the core's SafetyMonitor.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/safety/configurations.hpp"
#include "biss/safety/monitor.hpp"
#include "biss/safety/plan.hpp"
#include "capi/biss_c_safety.h"
#include "capi/frame.hpp"

namespace biss::capi {

namespace {

using Plan = SafetyPlan<max_channels>;
using Monitor = SafetyMonitor<Plan>;

static_assert(BISS_VERDICT_INVALID == safety_verdict_count);
static_assert(index_of(SafetyVerdict::stimulus) == BISS_VERDICT_STIMULUS);
static_assert(index_of(SafetyVerdict::watchdog) == BISS_VERDICT_WATCHDOG);
static_assert(index_of(SafetyVerdict::comparison) == BISS_VERDICT_COMPARISON);
static_assert(static_cast<bool>(MultiturnRule::ignored) &&
              static_cast<bool>(MissedFrames::perhaps));
static_assert(BISS_COUNT_LEARNED == static_cast<int>(CounterMode::learned));
static_assert(BISS_ANY_COUNTER == any_first_value);

// The members of both setups, next to each other: for both directions.
template <class C, class Core, class Pair>
void each_member(C& c, Core& core, const Pair& pair) {
  pair(c.cpw, core.cpw);
  pair(c.spw, core.spw);
  pair(c.start_frames, core.start_frames);
  pair(c.latch, core.latch);
  pair(c.compare_bits, core.comparison.compare_bits);
  pair(c.tolerance_lsb, core.comparison.tolerance_lsb);
  pair(c.ignore_turns, core.comparison.multiturn);
  pair(c.counter, core.counter.mode);
  pair(c.perhaps_missed, core.counter.missed);
  pair(c.near_frames, core.counter.near_frames);
  pair(c.learn_rollovers, core.counter.learn_rollovers);
  pair(c.counter_first, core.counter.first);
  pair(c.cycle_min_ps, core.cycle_min.count);
  pair(c.frame_gap_max_ps, core.frame_gap_max.count);
  pair(c.frame_gap_min_ps, core.frame_gap_min.count);
  pair(c.clock_tolerance_ps, core.clocks.tolerance.count);
  pair(c.still_requests, core.clocks.still_requests);
  pair(c.bit_period_ps, core.clocks.bit_period.count);
  pair(c.budget_faults, core.budget.faults);
  pair(c.budget_window_ps, core.budget.window.count);
  pair(c.residual_max_e15, core.residual_max_e15);
  pair(c.rating_words, core.rating.words);
  pair(c.rating_residual_e24, core.rating.residual_e24);
  pair(c.rating_check, core.rating.check);
}

biss_safety_setup as_setup(const biss_format* format, const SafetySetup& from) {
  biss_safety_setup setup{};
  setup.format = format;
  each_member(setup, from, []<class C>(C& c, const auto& core) { c = static_cast<C>(core); });
  setup.bounds = std::bit_cast<biss_bounds>(from.bounds);
  return setup;
}

// \return whether each number fits its member; check_safety() judges the values
bool put(const biss_safety_setup& from, SafetySetup& to) {
  bool fits = from.counter <= BISS_COUNT_LEARNED;
  each_member(from, to, [&fits]<class C, class Core>(const C& c, Core& core) {
    core = static_cast<Core>(c);
    fits = fits && static_cast<C>(core) == c;
  });
  to.bounds = std::bit_cast<FrameBounds>(from.bounds);
  return fits;
}

struct Wanted {
  biss_status status = BISS_OK;
  FrameFormat format{};
  SafetySetup setup{};
  bool unrated = false;
  /// Why these frames cannot be monitored: BISS_BAD_SAFETY.
  std::optional<SafetySetupError> mistake{};
};

Wanted read_setup(const biss_safety_setup* setup) {
  if (setup == nullptr) return {.status = BISS_NULL_ARGUMENT};
  Described device;
  if (const auto wrong = read(setup->format, device)) return {.status = wrong};
  Wanted wanted{.format = device.format, .unrated = setup->unrated};
  if (!put(*setup, wanted.setup)) return {.status = BISS_BAD_SETUP};
  wanted.mistake = setup->unrated ? check_safety(wanted.format, UnratedSafetySetup(wanted.setup))
                                  : check_safety(wanted.format, wanted.setup);
  if (wanted.mistake) wanted.status = BISS_BAD_SAFETY;
  return wanted;
}

TwoClocks from_c(const biss_safety_time& time) {
  return {picoseconds(time.now_ps), picoseconds(time.second_ps),
          Transfer{picoseconds(time.transfer_ps), 0}};
}

biss_judgement as_judgement(const Monitor& monitor, const SafetyJudgement& from) {
  const GuardedPosition& position = from.position;
  const std::uint64_t none = from.verdict == SafetyVerdict::safe ? BISS_NO_POSITION : 0;
  return {.verdict = static_cast<biss_verdict>(index_of(from.verdict)),
          .state = name_of(from.state).data(),
          .tolerated = from.tolerated,
          .cpw_nW = from.cpw_nW,
          .spw_nW = from.spw_nW,
          .life_counter = from.life_counter,
          .difference_lsb = from.difference_lsb,
          .has_position = position.has_value(),
          .position = position ? position->value : none,
          .low = position ? position->low : none,
          .high = position ? position->high : none,
          .control_position = position ? control_position(monitor.plan(), *position) : none};
}

Plan plan_of(const Wanted& wanted) {
  if (wanted.unrated) return Plan(wanted.format, UnratedSafetySetup(wanted.setup));
  return Plan(wanted.format, wanted.setup);
}

biss_status put_setup(const biss_format* format, const SafetySetup& usual, std::int64_t cycle_ps,
                      biss_safety_setup* setup) {
  if (format == nullptr || setup == nullptr) return BISS_NULL_ARGUMENT;
  if (cycle_ps < 0) return BISS_BAD_SETUP;
  *setup = as_setup(format, cycle_ps == 0 ? usual : at_cycle(usual, picoseconds(cycle_ps)));
  return BISS_OK;
}

}  // namespace

extern "C" {

biss_status biss_safety_defaults(const biss_format* format, int64_t cycle_ps,
                                 biss_safety_setup* setup) {
  return put_setup(format, SafetySetup{}, cycle_ps, setup);
}

const char* biss_safety_problem(const biss_safety_setup* setup) {
  const auto wanted = read_setup(setup);
  return wanted.mistake ? name_of(*wanted.mistake).data() : nullptr;
}

biss_status biss_safety_parse(const char* text, int64_t cycle_ps, biss_format* format,
                              biss_safety_setup* setup) {
  if (text == nullptr) return BISS_NULL_ARGUMENT;
  const SafetyConfiguration* found = find_safety_configuration(text);
  const auto wrong =
      put_setup(format, found == nullptr ? SafetySetup{} : found->setup, cycle_ps, setup);
  return wrong == BISS_OK ? biss_format_parse(text, format) : wrong;
}

biss_status biss_safety_init(biss_safety* safety, const biss_safety_setup* setup) {
  if (const auto wrong = begin_init(safety)) return wrong;
  const auto wanted = read_setup(setup);
  return wanted.status == BISS_OK ? make<Monitor>(safety, plan_of(wanted)) : wanted.status;
}

biss_status biss_safety_self_test(biss_safety* safety, const biss_safety_setup* expected,
                                  bool* passed) {
  if (passed == nullptr) return BISS_NULL_ARGUMENT;
  *passed = false;
  if (const auto wrong = check_call(safety)) return wrong;
  const auto wanted = read_setup(expected);
  if (wanted.status != BISS_OK) return wanted.status;
  *passed = thing<Monitor>(safety).self_test(
      SafetyFingerprint(wanted.format, wanted.setup, wanted.unrated ? 0 : 1));
  return BISS_OK;
}

const char* biss_verdict_name(biss_verdict verdict) {
  const bool known = verdict >= BISS_VERDICT_SAFE && verdict < BISS_VERDICT_INVALID;
  return known ? name_of(verdict_of(static_cast<std::size_t>(verdict))).data() : "invalid";
}

biss_status biss_safety_step(biss_safety* safety, const biss_safety_time* time,
                             const uint8_t* bytes, size_t byte_count, size_t first_bit,
                             size_t bit_count, biss_judgement* judgement) {
  if (const auto wrong = check_call(safety, time, judgement, given(bytes, byte_count)))
    return wrong;
  const BitView bits(std::span(bytes, byte_count), first_bit, bit_count);
  *judgement =
      as_judgement(thing<Monitor>(safety), thing<Monitor>(safety).step(from_c(*time), bits));
  return BISS_OK;
}

biss_status biss_safety_watch(biss_safety* safety, const biss_safety_time* time,
                              biss_judgement* judgement) {
  if (const auto wrong = check_call(safety, time, judgement)) return wrong;
  *judgement = as_judgement(thing<Monitor>(safety), thing<Monitor>(safety).watch(from_c(*time)));
  return BISS_OK;
}

biss_status biss_safety_deadline(const biss_safety* safety, bool* is_expected,
                                 int64_t* deadline_ps) {
  if (const auto wrong = check_call(safety, is_expected, deadline_ps)) return wrong;
  const auto deadline = thing<Monitor>(safety).deadline();
  *is_expected = deadline.has_value();
  *deadline_ps = deadline ? deadline->count : BISS_NEVER;
  return BISS_OK;
}

biss_status biss_safety_expect(biss_safety* safety, uint64_t low, uint64_t high) {
  return with<Monitor>(safety, [=](auto& monitor) { monitor.expect_position(low, high); });
}

biss_status biss_safety_acknowledge(biss_safety* safety, biss_verdict cause) {
  if (const auto wrong = check_call(safety)) return wrong;
  if (cause < BISS_VERDICT_SAFE || cause >= BISS_VERDICT_INVALID) return BISS_NO_READING;
  const auto verdict = verdict_of(static_cast<std::size_t>(cause));
  return thing<Monitor>(safety).acknowledge(verdict) ? BISS_OK : BISS_NO_READING;
}

biss_status biss_safety_cause(const biss_safety* safety, biss_verdict* cause) {
  if (const auto wrong = check_call(safety, cause)) return wrong;
  const SafetyState state = thing<Monitor>(safety).state();
  if (state != SafetyState::latched && state != SafetyState::failed) {
    return BISS_NO_READING;
  }
  *cause = static_cast<biss_verdict>(index_of(thing<Monitor>(safety).latched_cause()));
  return BISS_OK;
}

biss_status biss_safety_encoder_restarted(biss_safety* safety) {
  return with<Monitor>(safety, [](auto& monitor) { monitor.encoder_restarted(); });
}

}  // extern "C"

}  // namespace biss::capi
