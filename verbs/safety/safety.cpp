// biss safety: the verbs that calculate and measure the strength of the checks of a frame.
#include "verbs/safety/safety.hpp"

#include "verbs/common/verb.hpp"

namespace biss::verbs {

void add_safety(Command& command) {
  add_verb_group(
      command,
      {.name = "safety",
       .purpose = "Calculate and measure how strong the checks of a frame are",
       .examples = {"biss safety analyse -f fs-36-28 --ber 1e-4"}},
      {
          {{"analyse",
            "Calculate the undetected errors of a format and their probability",
            {"biss safety analyse -f fs-36-28 --ber 1e-4 --rate 32kHz",
             "biss safety analyse -f pos26,nE,nW,crc6 --ber 1e-2 --ber 1e-3 --to jsonl",
             "biss safety analyse -f mt12,st24,nE,nW,crc6+mt12,st16,nE,nW,lc6,crc16 --compare 13"}},
           add_safety_analyse},
#ifndef __EMSCRIPTEN__
          // Verbs that run for hours and write folders.
          {{"campaign",
            "Inject faults into frames and count undetected errors",
            {"biss safety campaign -f fs-36-28 --frames 1000000000 --state run.json",
             "biss safety campaign -f fs-36-28 --fault flips:0.01 --fault burst:16 --to csv",
             "biss safety campaign -f fs-36-28 --shard 1/7 --state part1.json",
             "biss safety campaign merge part1.json part2.json --to csv",
             "biss safety campaign -f fs-36-28 --fault flips:0.01 --replay 123456"}},
           add_safety_campaign},
          {{"sequences",
            "Run the monitor on long sequences of frames, undamaged and with every error",
            {"biss safety sequences -f fs-36-28 --frames 1000000000 --faults 1000000",
             "biss safety sequences -f fs-36-28 --kind undamaged --motion steps --to csv",
             "biss safety sequences -f fs-36-28 --counter count_0_63 --encoder-counter count_1_63",
             "biss safety sequences -f fs-36-28 --kind addressing --variant one_frame --replay "
             "17"}},
           add_safety_sequences},
          {{"line",
            "Inject every fault of the line model and count undetected faults",
            {"biss safety line -f fs-36-28 --cycles 2000"}},
           add_safety_line},
          {{"evidence",
            "Run the other safety verbs for one configuration and write their results and hashes "
            "to a "
            "folder",
            {"biss safety evidence -f fs-36-28 -o evidence",
             "biss safety evidence --check evidence"}},
           add_safety_evidence},
#endif
      });
}

}  // namespace biss::verbs
