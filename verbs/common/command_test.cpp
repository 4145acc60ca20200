#include <gtest/gtest.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "cli/command_line.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {
namespace command_test {

struct Options {
  std::string format;
  std::string output;
  report::Format to = report::Format::table;
  std::optional<Hertz> clock;
  std::optional<Picoseconds> since;
  Millimetres cable{1'000};
  std::uint32_t cycles = 10;
  std::vector<std::string> positions;
  std::vector<std::string> columns;
};

// The command with verbs that do nothing, or fail as their name says.
class CommandTest : public testing::Test {
 protected:
  CommandTest() {
    Verb verb = command_.add_verb({.name = "frame",
                                   .purpose = "Show a frame",
                                   .examples = {"biss frame -f pos26 1", "biss frame 2"}},
                                  [this](Host& /*host*/) {
                                    ++runs_;
                                    return result_;
                                  });
    verb.add_option("-f,--format", options_.format, "Frame format").required();
    verb.add_option("POSITION", options_.positions, "Positions");
    verb.add_option("--columns", options_.columns, "Columns").delimiter(',');
    add_output_option(verb, options_.output);
    add_to_option(verb, options_.to, {report::Format::table, report::Format::jsonl});
    add_rate_option(verb, "--clock", into(options_.clock), "Clock");
    add_duration_option(verb, "--since", into(options_.since), "From here on");
    add_length_option(verb, "--cable", into(options_.cable), "Cable");
    add_count_option(verb, "--cycles", into(options_.cycles), "Cycles", 1'000);
    command_.add_verb({.name = "memory", .purpose = "Fail", .examples = {"biss memory"}},
                      [](Host& /*host*/) -> ExitStatus { throw std::bad_alloc(); });
    command_.add_verb({.name = "throw", .purpose = "Fail", .examples = {"biss throw"}},
                      [](Host& /*host*/) -> ExitStatus { throw std::runtime_error("two\nlines"); });
  }

  ExitStatus run(const std::vector<const char*>& arguments) {
    std::vector<const char*> all = {"biss"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const ExitStatus status =
        cli::run_command_line(command_, static_cast<int>(all.size()), all.data());
    out_ = testing::internal::GetCapturedStdout();
    err_ = testing::internal::GetCapturedStderr();
    return status;
  }

  void expect_usage(const std::vector<const char*>& arguments, const std::string& line) {
    EXPECT_EQ(run(arguments), ExitStatus::usage);
    EXPECT_EQ(err_, "biss: " + line + "\n");
    EXPECT_EQ(out_, "");
    EXPECT_EQ(runs_, 0);
  }

  Options options_;
  ProcessHost host_;
  Command command_{host_};
  ExitStatus result_ = ExitStatus::done;
  int runs_ = 0;
  std::string out_;
  std::string err_;
};

TEST_F(CommandTest, GoodLine_RunsTheVerbWithItsOptions) {
  EXPECT_EQ(run({"frame", "-f", "pos26,nE,nW,crc6;cds0", "12", "0x5", "-o", "-", "--to", "jsonl",
                 "--clock", "10MHz", "--cable=50m", "--cycles", "7"}),
            ExitStatus::done);
  EXPECT_EQ(runs_, 1);
  EXPECT_EQ(options_.format, "pos26,nE,nW,crc6;cds0");
  EXPECT_EQ(options_.output, "-");
  EXPECT_EQ(options_.to, report::Format::jsonl);
  EXPECT_EQ(options_.clock, megahertz(10));
  EXPECT_EQ(options_.cable.count, 50'000);
  EXPECT_EQ(options_.cycles, 7U);
  EXPECT_EQ(options_.since, std::nullopt);
  EXPECT_EQ(options_.positions, (std::vector<std::string>{"12", "0x5"}));
  EXPECT_EQ(out_ + err_, "");
}

TEST_F(CommandTest, ListInOneValue_IsSplitForEachShell) {
  EXPECT_EQ(run({"frame", "-f", "x", "--columns", "cycle,status", "--columns", "raw"}),
            ExitStatus::done);
  EXPECT_EQ(options_.columns, (std::vector<std::string>{"cycle", "status", "raw"}));
  EXPECT_EQ(command_.run({"frame"}, {{"--format", {"x"}}, {"--columns", {"cycle,status", "raw"}}}),
            ExitStatus::done);
  EXPECT_EQ(options_.columns, (std::vector<std::string>{"cycle", "status", "raw"}));
}

TEST_F(CommandTest, StatusOfTheVerb_IsTheStatusOfTheCommand) {
  for (const ExitStatus status : {ExitStatus::done, ExitStatus::data_failed, ExitStatus::io}) {
    result_ = status;
    EXPECT_EQ(run({"frame", "-f", "x"}), status);
  }
}

TEST_F(CommandTest, NegativeNumber_ReachesTheVerb) {
  EXPECT_EQ(run({"frame", "-f", "x", "-5"}), ExitStatus::done);
  EXPECT_EQ(options_.positions, (std::vector<std::string>{"-5"}));
}

TEST_F(CommandTest, NegativeQuantity_IsWrongUsage) {
  expect_usage({"frame", "-f", "x", "--since", "-5us"},
               "--since: '-5us': negative; the range is 0 to 1000 s in steps of 1 ps"
               " (see 'biss frame --help')");
}

TEST_F(CommandTest, DashAsPositional_ReachesTheVerb) {
  EXPECT_EQ(run({"frame", "-f", "x", "-"}), ExitStatus::done);
  EXPECT_EQ(options_.positions, (std::vector<std::string>{"-"}));
}

TEST_F(CommandTest, AfterTwoDashes_AllIsPositional) {
  EXPECT_EQ(run({"frame", "-f", "x", "--", "-o", "--to"}), ExitStatus::done);
  EXPECT_EQ(options_.positions, (std::vector<std::string>{"-o", "--to"}));
}

TEST_F(CommandTest, NameOfAVerbAsArgument_IsAnArgument) {
  EXPECT_EQ(run({"frame", "-f", "x", "memory"}), ExitStatus::done);
  EXPECT_EQ(options_.positions, (std::vector<std::string>{"memory"}));
}

TEST_F(CommandTest, NothingGiven_IsWrongUsage) {
  expect_usage({}, "no verb given (see 'biss --help')");
}

TEST_F(CommandTest, UnknownVerb_SuggestsTheNearest) {
  expect_usage({"fraem", "-f", "x"},
               "unknown verb 'fraem'; did you mean 'frame'? (see 'biss --help')");
  expect_usage({"quite-another"}, "unknown verb 'quite-another' (see 'biss --help')");
  expect_usage({""}, "unknown verb '' (see 'biss --help')");
}

TEST_F(CommandTest, UnknownOption_SuggestsTheNearest) {
  expect_usage({"frame", "-f", "x", "--clok", "10MHz"},
               "unknown option '--clok'; did you mean '--clock'? (see 'biss frame --help')");
  expect_usage({"frame", "-f", "x", "--zzzzzzzz=1"},
               "unknown option '--zzzzzzzz' (see 'biss frame --help')");
  expect_usage({"--verbose"}, "unknown option '--verbose' (see 'biss --help')");
}

TEST_F(CommandTest, MissingOption_IsNamed) {
  expect_usage({"frame", "1"}, "--format is required (see 'biss frame --help')");
}

TEST_F(CommandTest, MissingValue_IsNamed) {
  expect_usage({"frame", "-f"}, "--format needs a value (see 'biss frame --help')");
  expect_usage({"frame", "-f", "x", "--clock"}, "--clock needs a value (see 'biss frame --help')");
}

TEST_F(CommandTest, OptionGivenTwice_IsNamed) {
  expect_usage({"frame", "-f", "x", "-f", "y"},
               "--format is given more than once (see 'biss frame --help')");
  expect_usage({"frame", "-f", "x", "--clock", "1MHz", "--clock", "2MHz"},
               "--clock is given more than once (see 'biss frame --help')");
}

TEST_F(CommandTest, WrongQuantity_PointsAtTheCharacter) {
  expect_usage({"frame", "-f", "x", "--clock", "10mhz"},
               "--clock: '10mhz': at character 3: unknown unit (did you mean MHz?); use Hz, kHz, "
               "MHz or GHz (see 'biss frame --help')");
  expect_usage({"frame", "-f", "x", "--cycles", "1001"},
               "--cycles: '1001': too large; the range is 0 to 1000"
               " (see 'biss frame --help')");
}

TEST_F(CommandTest, FormatTheVerbDoesNotWrite_IsNamedWithTheOthers) {
  expect_usage({"frame", "-f", "x", "--to", "csv"},
               "--to: 'csv' is not one of table, jsonl (see 'biss frame --help')");
}

TEST_F(CommandTest, LineBreaksInAnArgument_StayOneLine) {
  EXPECT_EQ(run({"a\nb\x1b[31m"}), ExitStatus::usage);
  EXPECT_EQ(std::count(err_.begin(), err_.end(), '\n'), 1) << err_;
  EXPECT_EQ(err_.find('\x1b'), std::string::npos);
}

TEST_F(CommandTest, Help_ShowsAnExampleOfEveryVerb) {
  EXPECT_EQ(run({"--help"}), ExitStatus::done);
  for (const char* part : {"biss frame -f pos26 1", "biss memory", "biss throw", "Show a frame"}) {
    EXPECT_NE(out_.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(err_, "");
}

TEST_F(CommandTest, HelpOfAVerb_ShowsItsExamplesWithoutRunningIt) {
  EXPECT_EQ(run({"frame", "--help"}), ExitStatus::done);
  for (const char* part : {"biss frame -f pos26 1", "biss frame 2", "--clock", "table|jsonl"}) {
    EXPECT_NE(out_.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(runs_, 0);
}

TEST_F(CommandTest, Version_IsPrinted) {
  EXPECT_EQ(run({"--version"}), ExitStatus::done);
  EXPECT_TRUE(out_.starts_with("biss ")) << out_;
}

TEST_F(CommandTest, ExceptionsOfAVerb_AreOneLineAndIo) {
  EXPECT_EQ(run({"memory"}), ExitStatus::io);
  EXPECT_EQ(err_, "biss: out of memory\n");
  EXPECT_EQ(run({"throw"}), ExitStatus::io);
  EXPECT_EQ(std::count(err_.begin(), err_.end(), '\n'), 1) << err_;
}

}  // namespace command_test
}  // namespace biss::verbs
