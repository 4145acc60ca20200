// `biss decode`: a capture in, one row per request cycle out.
#include <memory>

#include "verbs/common/verb.hpp"
#include "verbs/decode/decode_run.hpp"

namespace biss::verbs {

namespace {

void add_row_options(Verb verb, DecodeOptions& options) {
  verb.add_option("--columns", options.columns, "Write these columns only, in this order")
      .delimiter(',')
      .type_name("NAME,...");
  verb.add_flag("--only-errors", options.only_errors,
                "Write only rows with an error: a status other than ok, unchecked, cut_start and "
                "cut_end, nE = 0, a limit or a fault in the column safety");
  add_count_option(
      verb, "--every",
      [&options](std::uint64_t count) {
        if (count == 0) wrong_value("--every", "'0' is not 1 or more");
        options.every = count;
      },
      "Write the first and then every N-th of the rows");
}

}  // namespace

VerbText decode_text() {
  return {.name = "decode",
          .purpose = "Read the positions in a capture of MA and SLO, one row per request cycle",
          .examples = {
              "biss decode capture.vcd -f pos26,nE,nW,crc6",
              "biss decode capture.csv -f resolute-32 --to csv -o rows.csv",
              "biss decode capture.sr -f resolute-26 --to hdf5 -o rows.h5",
              "biss decode capture.sr -f resolute-26 --scale deg --velocity --to vcd -o motion.vcd",
              "biss decode ma.csv slo.csv --ma ma.csv:D0 --slo slo.csv:D1 -f fs-36-28",
              "biss decode samples.bin --raw-rate 100MHz --ma D0 --slo D3 -f resolute-26",
              "biss decode --words adapter.log --payload -f resolute-26 -o rows.csv"}};
}

void add_decode_options(Verb verb, DecodeOptions& options) {
  options.capture.identify = true;
  add_capture_options(verb, options.capture);
  add_safety_options(verb, options.safety);
  verb.scope(Scope::judging)
      .add_flag("--no-compensation", options.capture.no_compensation,
                "Compute the column marginal for a master that samples half a period after its own "
                "edges of MA; positions are unaffected");
  add_range_options(verb, options.capture);
  const Verb own = verb.scope(Scope::command);
  own.add_flag("--no-verify", options.capture.no_verify,
               "Do not verify the checksums of compressed samples (.sr, .dsl)");
  add_count_option(own, "--threads", into(options.capture.threads),
                   "Worker threads; by default one per core. The rows do not depend on it", 1024);
  add_judged_row_options(verb, options);
}

void add_judged_row_options(Verb verb, DecodeOptions& options) {
  const Verb own = verb.scope(Scope::command);
  own.add_option("--fail-on", options.fail_on,
                 "Exit with 1 if a row has one of these: nE, nW, marginal, safety (a fault in that "
                 "column), one of its verdicts, limits, one limit such as clock_max, a status such "
                 "as crc, or any: nE, limits and every status but ok, cut_start and cut_end")
      .delimiter(',')
      .type_name("CAUSE,...");
  add_row_options(verb.scope(Scope::rows), options);
  add_motion_options(verb.section("Motion"), options.motion);
  add_output_option(verb, options.output,
                    "Output file; standard output (-) by default, but --to hdf5 needs a file");
  add_to_option(verb, options.to,
                {report::Format::table, report::Format::csv, report::Format::jsonl,
                 report::Format::vcd, report::Format::hdf5});
}

void add_decode(Command& command) {
  const auto options = std::make_shared<DecodeOptions>();
  Verb verb = command.add_verb(decode_text(),
                               [options](Host& host) { return DecodeRun(*options, host).run(); });
  add_decode_options(verb, *options);
  Option& words =
      verb.add_option("--words", options->capture.words.file,
                      "A log instead of a capture: one frame per line, in digits; a time such as "
                      "12.5us or a number may come first; # begins a comment, - is standard input")
          .file(FileUse::read)
          .type_name("TEXT");
  for (const char* const name : {"FILE",         "--ma",           "--slo",
                                 "--invert-ma",  "--invert-slo",   "--each",
                                 "--resolution", "--ack-max",      "--ack-clocks",
                                 "--timeout",    "--release",      "--clock-max",
                                 "--cycle-min",  "--raw-rate",     "--raw-bytes",
                                 "--threshold",  "--differential", "--no-compensation",
                                 "--no-verify",  "--threads"}) {
    words.excludes(verb.get_option(name));
  }
  add_word_options(verb, options->capture.words.reading, words);
}

}  // namespace biss::verbs
