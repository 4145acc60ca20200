// biss eds: electronic data sheets.
#include "verbs/eds/source.hpp"

namespace biss::verbs {

void add_eds(Command& command) {
  add_verb_group(
      command,
      {.name = "eds",
       .purpose = "Show, check, build and compare electronic data sheets",
       .examples = {"biss eds show registers.hex", "biss eds check registers.hex",
                    "biss eds build encoder.eds -o encoder.hex"}},
      {{{"show",
         "Print the fields of a data sheet, and the frame that it describes",
         {"biss eds show registers.hex", "biss eds show eeprom.bin --bank 2 --to jsonl",
          "biss eds show registers.hex --to description -o encoder.eds"}},
        add_eds_show},
       {{"check",
         "Check a data sheet and list the findings",
         {"biss eds check registers.hex", "biss eds check bank3.bin --id 0x621E --to jsonl",
          "biss eds check registers.hex --override MT_LEN=12"}},
        add_eds_check},
       {{"build",
         "Build the banks of a data sheet from a description",
         {"biss eds build encoder.eds -o encoder.hex", "biss eds build encoder.eds -o encoder.bin",
          "biss eds build encoder.eds --to c --bank 1"}},
        add_eds_build},
       {{"diff",
         "Compare two data sheets symbol by symbol",
         {"biss eds diff encoder.eds registers.hex", "biss eds diff old.bin new.bin --to jsonl"}},
        add_eds_diff},
       {{"advise",
         "Recommend a frame for a new encoder: data length, CRC, alignment, request rate",
         {"biss eds advise --resolution 18 --turns 12 --rate 16kHz --clock 10MHz",
          "biss eds advise --resolution 20 --to description", "biss eds advise encoder.eds"}},
        add_eds_advise}});
}

}  // namespace biss::verbs
