// biss safety: how strong the checks of a frame are, counted and measured.
#include "tools/safety.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tools/verb.hpp"
#include "tools/verbs.hpp"

namespace biss::tools {
namespace {

struct SafetyVerb {
  const char* name;
  const char* purpose;
  SafetyRun (*add)(CLI::App&);
  std::vector<std::string> examples;
};

const std::vector<SafetyVerb>& safety_verbs() {
  static const std::vector<SafetyVerb> verbs = {
      {"analyse",
       "Say exactly which errors a format's checksums do not see, and how often they come",
       add_safety_analyse,
       {"biss safety analyse -f fs-36-28 --ber 1e-4 --rate 32kHz",
        "biss safety analyse -f pos26,nE,nW,crc6 --ber 1e-2 --ber 1e-3 --to jsonl",
        "biss safety analyse -f mt12,st24,nE,nW,crc6+mt12,st16,nE,nW,lc6,crc16 --compare 13"}},
      {"campaign",
       "Damage frames by the billion and count what is accepted all the same",
       add_safety_campaign,
       {"biss safety campaign -f fs-36-28 --frames 1000000000 --state run.json",
        "biss safety campaign -f fs-36-28 --fault flips:0.01 --fault burst:16 --to csv",
        "biss safety campaign -f fs-36-28 --shard 1/7 --state part1.json",
        "biss safety campaign merge part1.json part2.json --to csv",
        "biss safety campaign -f fs-36-28 --fault flips:0.01 --replay 123456"}},
      {"sequences",
       "Show the monitor long runs of frames, undamaged and with every kind of fault",
       add_safety_sequences,
       {"biss safety sequences -f fs-36-28 --frames 1000000000 --faults 1000000",
        "biss safety sequences -f fs-36-28 --kind undamaged --motion steps --to csv",
        "biss safety sequences -f fs-36-28 --counter count_0_63 --encoder-counter count_1_63",
        "biss safety sequences -f fs-36-28 --kind addressing --variant one_frame --replay 17"}},
      {"evidence",
       "Put all that can be shown of a configuration into a folder, with hashes",
       add_safety_evidence,
       {"biss safety evidence -f fs-36-28 -o evidence", "biss safety evidence --check evidence"}}};
  return verbs;
}

}  // namespace

void add_safety(Command& command) {
  using Chosen = std::vector<std::pair<CLI::App*, SafetyRun>>;
  const auto runs = std::make_shared<Chosen>();
  CLI::App& safety = command.add_verb(
      {.name = "safety",
       .purpose = "Say how strong the checks of a frame are",
       .examples = {"biss safety analyse -f fs-36-28 --ber 1e-4"}},
      [runs] {
        for (const auto& [app, run] : *runs) {
          if (app->parsed()) return run();
        }
        return fail(ExitStatus::usage, "no verb of safety given (see 'biss safety --help')");
      });
  safety.require_subcommand(1);
  for (const SafetyVerb& verb : safety_verbs()) {
    CLI::App* app = safety.add_subcommand(verb.name, verb.purpose);
    app->group("Verbs");
    std::string footer = "Examples:";
    for (const std::string& example : verb.examples) footer += "\n  " + example;
    app->footer(footer);
    runs->emplace_back(app, verb.add(*app));
  }
}

}  // namespace biss::tools
