// `biss registers`: the control communication in a capture, one row per access.
#include <fmt/format.h>

#include <array>
#include <map>

#include "decode/control_listener.hpp"
#include "decode/seen_registers.hpp"
#include "dump/register_dump.hpp"
#include "dump/write.hpp"
#include "report/summary.hpp"
#include "verbs/common/decoded_capture.hpp"
#include "verbs/common/table_output.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/registers/access_rows.hpp"

namespace biss::verbs {

namespace {

using decode::AccessOutcome;
using decode::SeenAccess;

struct RegistersOptions {
  CaptureArguments capture;
  std::string dump;
  std::optional<std::uint64_t> id;
  std::optional<std::uint8_t> bank;
  bool fail_on_any = false;
  std::string output;
  report::Format to = report::Format::table;
};

class RegistersRun {
 public:
  RegistersRun(const RegistersOptions& options, Host& host) : options_(options), host_(host) {}

  ExitStatus run() {
    if (options_.dump.empty() && (options_.id || options_.bank)) {
      return host_.fail(ExitStatus::usage,
                        options_.id ? "--id: needs --dump" : "--bank: needs --dump");
    }
    const ExitStatus opened = capture_.open(options_.capture);
    if (opened != ExitStatus::done) return opened;
    if (!options_.dump.empty() && capture_.several()) {
      return host_.fail(ExitStatus::usage, "--dump: only for one capture and one pair of lines");
    }
    const ExitStatus status =
        write_captures(capture_, options_.output, options_.to, access_columns,
                       options_.fail_on_any || !options_.dump.empty(),
                       [&](report::TableWriter& writer, RunMessages& messages) {
                         return write_rows(writer, messages);
                       });
    return status == ExitStatus::done && !options_.dump.empty() ? write_dump() : status;
  }

 private:
  // The rows of one capture.
  ExitStatus write_rows(report::TableWriter& writer, RunMessages& messages) {
    counts_ = {};
    accesses_ = 0;
    bytes_and_commands_ = 0;
    decode::ControlListener listener([&](const SeenAccess& access) {
      take(access);
      ++counts_[static_cast<std::size_t>(access.outcome)];
      ++bytes_and_commands_;
      if (!access.continues) ++accesses_;
      write_access(writer, access);
    });
    std::uint64_t cycles = 0;
    const bool read = capture_.read([&](std::uint64_t number, const decode::Cycle& cycle) {
      ++cycles;
      listener.push(number, cycle);
      return true;
    });
    listener.finish();
    if (!read) return messages.fail(ExitStatus::io, capture_.input().error());
    if (cycles == 0) return messages.fail(ExitStatus::data_failed, capture_.no_request());
    messages.add_summary(summary(listener));
    const bool failed = bytes_and_commands_ != counts_[0];
    return options_.fail_on_any && failed ? ExitStatus::data_failed : ExitStatus::done;
  }

  void take(const SeenAccess& access) {
    if (!access.header_sent || access.kind == SeenAccess::Kind::command) return;
    // An access of unknown kind does not prove that the slave exists.
    if (access.kind == SeenAccess::Kind::unknown && !slaves_.contains(access.id)) return;
    slaves_.try_emplace(access.id, options_.bank).first->second.take(access);
  }

  std::string summary(const decode::ControlListener& listener) const {
    report::Summary out;
    out.title(fmt::format("{}: {} access{} ({} bytes or commands)", capture_.input().name(),
                          accesses_, accesses_ == 1 ? "" : "es", bytes_and_commands_));
    std::string counted;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      report::append_count(counted, counts_[i], name_of(static_cast<AccessOutcome>(i)));
    }
    if (!counted.empty()) out.entry("outcome", counted);
    if (listener.stray_cds() != 0) {
      out.entry("CDS", fmt::format("{} cycles with CDS = 1 and no access", listener.stray_cds()));
    }
    if (listener.stray_cdm() != 0) {
      out.entry("CDM", fmt::format("{} cycles with CDM = 1 after fewer than {} zeros",
                                   listener.stray_cdm(), control_reset_zeros));
    }
    if (accesses_ == 0) {
      out.entry("try", "a capture with control communication; unidirectional encoders have none");
    }
    return out.text();
  }

  ExitStatus write_dump() const {
    if (slaves_.size() > 1 && !options_.id) {
      return host_.fail(ExitStatus::usage,
                        "--dump: several slaves were accessed; name one with --id");
    }
    const auto slave =
        options_.id ? slaves_.find(static_cast<unsigned>(*options_.id)) : slaves_.begin();
    if (slave == slaves_.end()) {
      return host_.fail(ExitStatus::data_failed, "--dump: no register of this slave was accessed");
    }
    const dump::RegisterDump* const found = &slave->second.registers();
    const bool banks_only = dump::holds_banks_only(dump::format_of(options_.dump));
    const bool direct = found->direct() != dump::DumpedBytes{};
    const bool lost = found->without_bank != 0;
    if (lost) {
      host_.warn(fmt::format("--dump: {}; --bank gives the bank at the beginning of the capture",
                             text_without_bank(*found)));
    }
    if (!found->banks() && !direct) {
      return host_.fail(ExitStatus::data_failed, lost ? "--dump: no other register was read"
                                                      : "--dump: no register was read");
    }
    if (!found->banks() && banks_only) {
      return host_.fail(
          ExitStatus::data_failed,
          fmt::format("--dump: no register of a {}bank was read; this format has no place "
                      "for the registers from 0x40 on",
                      lost ? "known " : ""));
    }
    const ExitStatus written = write_output(host_, options_.dump, [&](Output& file) {
      return file.write(write_as(dump::format_of(options_.dump), *found, "registers"));
    });
    if (written == ExitStatus::done && banks_only && direct) {
      host_.print_summary(text_of_banks(*found));
    }
    return written;
  }

  const RegistersOptions& options_;
  Host& host_;
  DecodedCapture capture_{host_};
  // The registers of each slave that the traffic shows.
  std::map<unsigned, decode::SeenRegisters> slaves_;
  std::array<std::uint64_t, decode::access_outcome_count> counts_{};
  // A sequential access is one access of several bytes.
  std::uint64_t accesses_ = 0;
  std::uint64_t bytes_and_commands_ = 0;
};

}  // namespace

void add_registers(Command& command) {
  const auto options = std::make_shared<RegistersOptions>();
  Verb verb = command.add_verb(
      {.name = "registers",
       .purpose = "Read the control communication in a capture, one row per access",
       .examples = {"biss registers capture.vcd",
                    "biss registers capture.vcd -f pos26,nE,nW,crc6 --to jsonl",
                    "biss registers capture.sr --dump seen.hex"}},
      [options](Host& host) { return RegistersRun(*options, host).run(); });
  add_capture_options(verb, options->capture);
  verb.add_option(
          "--dump", options->dump,
          "Write the registers of a slave that the accesses show: as hex text, .ihex, .bin or .c")
      .file(FileUse::write);
  add_count_option(verb, "--id", into(options->id), "ID of the slave for --dump", 7);
  add_count_option(verb, "--bank", into(options->bank),
                   "Bank that is selected at the beginning of the capture, for --dump; by default "
                   "it is known from the first access to BSEL on",
                   255);
  verb.add_flag("--fail", options->fail_on_any, "Exit with 1 if an access did not end with ok");
  add_output_option(verb, options->output);
  add_to_option(verb, options->to);
}

}  // namespace biss::verbs
