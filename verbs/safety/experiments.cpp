#include "verbs/safety/experiments.hpp"

#include "verbs/common/verb.hpp"

namespace biss::verbs {

void add_seed_option(Verb verb, std::uint64_t& seed) {
  add_count_option(verb, "--seed", into(seed), "Random seed; 1 by default");
}

void add_threads_option(Verb verb, unsigned& threads) {
  add_count_option(verb, "--threads", into(threads), "Worker threads; by default one per core",
                   1024);
}

SafetyFormat monitored_by(const std::string& format) {
  auto known = parse_safety_format(format);
  if (!known) throw wrong_format(format);
  return *std::move(known);
}

VerbError wrong_format(const std::string& format) {
  return {ExitStatus::usage, safety_format_error(format)};
}

ExitStatus print_rows(const std::vector<FieldRow>& rows, const ExperimentOptions& options,
                      Host& host) {
  return write_output(host, options.output,
                      [&](Output& output) { return write_rows(rows, options.to, output); });
}

}  // namespace biss::verbs
