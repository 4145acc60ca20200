// What the bundle was made for, and by which program: configuration.json and version.json.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"
#include "cli/safety/campaign_plan.hpp"
#include "cli/safety/evidence.hpp"

namespace biss::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string_view name_of_counter(CounterMode mode) {
  constexpr std::array<std::string_view, 3> names{"count_1_63", "count_0_63", "learned"};
  return names[static_cast<std::size_t>(mode)];
}

// Places from the word's first bit on the line.
Json field(const ChannelFormat& word, const char* name, unsigned shift, unsigned bits) {
  return {{"field", name}, {"first_bit", word.data_bits - shift - bits}, {"bits", bits}};
}

Json fields_of(const ChannelFormat& word) {
  Json fields = Json::array();
  const auto add = [&](const char* name, const Field& each) {
    if (each.present()) fields.push_back(field(word, name, each.shift, each.bits));
  };
  add("position", word.position);
  add("multiturn", word.multiturn);
  add("singleturn", word.singleturn);
  if (word.error.present) fields.push_back(field(word, "nE", word.error.shift, 1));
  if (word.warning.present) fields.push_back(field(word, "nW", word.warning.shift, 1));
  add("life_counter", word.life_counter);
  return fields;
}

Json word_json(const EvidenceQuestion& question, std::size_t k) {
  const ChannelFormat& word = question.format.channel_list[k];
  return {{"word", k == question.setup.cpw ? "CPW" : "SPW"},
          {"data_bits", word.data_bits},
          {"fields", fields_of(word)},
          {"crc",
           {{"bits", word.crc.width_bits},
            {"polynomial", fmt::format("0x{:X}", word.crc.polynomial)},
            {"start", fmt::format("0x{:X}", word.crc.start)},
            {"inverted", word.crc.inverted}}}};
}

// Every field of SafetySetup under its own name; times in picoseconds.
Json setup_json(const SafetySetup& setup) {
  const FrameBounds& bounds = setup.bounds;
  return {{"cpw", setup.cpw},
          {"spw", setup.spw},
          {"start_frames", setup.start_frames},
          {"latch", setup.latch},
          {"comparison",
           {{"compare_bits", setup.comparison.compare_bits},
            {"tolerance_lsb", setup.comparison.tolerance_lsb},
            {"multiturn",
             setup.comparison.multiturn == MultiturnRule::ignored ? "ignored" : "with_carry"}}},
          {"counter",
           {{"mode", name_of_counter(setup.counter.mode)},
            {"missed", setup.counter.missed == MissedFrames::perhaps ? "perhaps" : "counted"},
            {"near_frames", setup.counter.near_frames},
            {"learn_rollovers", setup.counter.learn_rollovers}}},
          {"cycle_min_ps", setup.cycle_min.count},
          {"frame_gap_max_ps", setup.frame_gap_max.count},
          {"frame_gap_min_ps", setup.frame_gap_min.count},
          {"budget", {{"faults", setup.budget.faults}, {"window_ps", setup.budget.window.count}}},
          {"bounds",
           {{"lead_min_clocks", bounds.lead_min_clocks},
            {"lead_max_clocks", bounds.lead_max_clocks},
            {"ack_min_clocks", bounds.ack_min_clocks},
            {"ack_max_clocks", bounds.ack_max_clocks},
            {"late_max_clocks", bounds.late_max_clocks}}}};
}

}  // namespace

std::string campaign_name(const EvidenceQuestion& question) {
  if (find_safety_configuration(question.configuration) != nullptr) return question.configuration;
  return std::string(format_text(question.format).view());
}

EvidenceFile evidence_configuration(const EvidenceQuestion& question) {
  const auto alignment =
      safety_detail::alignment_of(question.cpw(), question.spw(), question.setup.comparison);
  const UncheckedBits unchecked = unchecked_bits(question);
  const auto* known = find_safety_configuration(question.configuration);
  const Json json = {{"options", Json::parse(options_json(question.options))},
                     {"configuration", question.configuration},
                     {"source", known != nullptr ? Json(known->source) : Json()},
                     {"resolution", known != nullptr ? Json(known->resolution) : Json()},
                     {"format", format_text(question.format).view()},
                     {"cds0", question.format.cds0},
                     {"words", {word_json(question, 0), word_json(question, 1)}},
                     {"setup", setup_json(question.setup)},
                     {"compared_bits", alignment.bits},
                     {"compared_turns_bits", alignment.bits - alignment.singleturn_bits},
                     {"cpw_bits_not_compared",
                      {{"below_spw_resolution", unchecked.below_resolution},
                       {"by_compare_bits", unchecked.not_compared},
                       {"turns", unchecked.turns}}},
                     {"counter_period_frames", counter_period(question.setup.counter.mode)},
                     {"rate_hz", question.rate.count},
                     {"ber", question.bit_error_rates},
                     {"seed", question.options.seed},
                     {"frames_per_fault_and_run", question.options.frames},
                     {"campaign_faults", usual_campaign_faults()},
                     {"sequence_faults_per_kind", question.options.faults},
                     {"line_cycles_per_fault", question.options.cycles}};
  return {"configuration.json", json.dump(2) + "\n"};
}

EvidenceFile evidence_version() {
  const std::string_view commit = build_commit;
  const Json json = {{"program", "biss"},
                     {"version", BISS_VERSION},
                     {"commit", commit.empty() ? Json() : Json(commit)},
                     {"compiler", BISS_COMPILER},
                     {"build_type", BISS_BUILD_TYPE}};
  return {"version.json", json.dump(2) + "\n"};
}

}  // namespace biss::cli
