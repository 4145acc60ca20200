// biss eds: electronic data sheets, read, judged, written, compared and planned.
#include "tools/eds.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tools/verb.hpp"
#include "tools/verbs.hpp"

namespace biss::tools {
namespace {

struct EdsVerb {
  const char* name;
  const char* purpose;
  EdsRun (*add)(CLI::App&);
  std::vector<std::string> examples;
};

const std::vector<EdsVerb>& eds_verbs() {
  static const std::vector<EdsVerb> verbs = {
      {"show",
       "Print a data sheet field by field, and the frame it describes",
       add_eds_show,
       {"biss eds show registers.hex", "biss eds show eeprom.bin --bank 2 --to jsonl",
        "biss eds show registers.hex --to description -o encoder.eds"}},
      {"check",
       "Name what is wrong with a data sheet",
       add_eds_check,
       {"biss eds check registers.hex", "biss eds check bank3.bin --id 0x621E --to jsonl",
        "biss eds check registers.hex --override MT_LEN=12"}},
      {"build",
       "Make the banks of a data sheet from a description",
       add_eds_build,
       {"biss eds build encoder.eds -o encoder.hex", "biss eds build encoder.eds -o encoder.bin",
        "biss eds build encoder.eds --to c --bank 1"}},
      {"diff",
       "Compare two data sheets symbol by symbol",
       add_eds_diff,
       {"biss eds diff encoder.eds registers.hex", "biss eds diff old.bin new.bin --to jsonl"}},
      {"advise",
       "Say which data length, CRC and alignment fit, and how often such a frame can come",
       add_eds_advise,
       {"biss eds advise --resolution 18 --turns 12 --rate 16kHz --clock 10MHz",
        "biss eds advise --resolution 20 --to description", "biss eds advise encoder.eds"}}};
  return verbs;
}

}  // namespace

void add_eds(Command& command) {
  using Chosen = std::vector<std::pair<CLI::App*, EdsRun>>;
  const auto runs = std::make_shared<Chosen>();
  CLI::App& eds = command.add_verb(
      {.name = "eds",
       .purpose = "Read, judge, write and compare electronic data sheets",
       .examples = {"biss eds show registers.hex", "biss eds check registers.hex",
                    "biss eds build encoder.eds -o encoder.hex"}},
      [runs] {
        for (const auto& [app, run] : *runs) {
          if (app->parsed()) return run();
        }
        return fail(ExitStatus::usage, "no verb of eds given (see 'biss eds --help')");
      });
  eds.require_subcommand(1);
  for (const EdsVerb& verb : eds_verbs()) {
    CLI::App* app = eds.add_subcommand(verb.name, verb.purpose);
    app->group("Verbs");
    std::string footer = "Examples:";
    for (const std::string& example : verb.examples) footer += "\n  " + example;
    app->footer(footer);
    runs->emplace_back(app, verb.add(*app));
  }
}

}  // namespace biss::tools
