// The functions that biss.mjs calls. Texts and arrays are in memory of this module until the next
// call.
#include <emscripten.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "biss/frame/status.hpp"
#include "biss/safety/verdict.hpp"
#include "decode/control_listener.hpp"
#include "device/words.hpp"
#include "report/row_store.hpp"
#include "verbs/common/help.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/decode/decode_run.hpp"
#include "verbs/registers/access_rows.hpp"
#include "wasm/cycle_json.hpp"
#include "wasm/line_store.hpp"

namespace biss::wasm {
namespace {

// A request for a verb by biss.mjs: the JSON object `{"words": ["decode", …], "options":
// [["--format", ["pos26"]], …]}`, see verbs::Command::run().
struct Request {
  std::vector<std::string> words;
  verbs::GivenOptions options;

  explicit Request(std::string_view json) {
    const auto object = nlohmann::json::parse(json);
    object.at("words").get_to(words);
    object.at("options").get_to(options);
  }
};

using nlohmann::json;
using wire::Level;

// In the order of decode::LineOrigin.
constexpr std::array<std::string_view, 3> origin_names{"given", "name", "behaviour"};

std::string_view line_kind(const verbs::CaptureInput& input) {
  if (input.is_analog()) return "voltages";
  return input.sample_period() == Picoseconds{} ? "changes" : "samples";
}

// Grow without a copy of all.
template <class T>
using Blocks = std::deque<T>;
using Rows = report::RowStore<Blocks>;

// A capture as `biss decode` reads it, step by step: its rows, and its lines as they are to be drawn.
// Messages are the same as on the command's stderr.
//
// Memory: about two bytes for each change of MA and SLO, and about 100 for each request cycle and for
// each access to a register.
class Session final : private flow::ChangeWatcher {
 public:
  // Opens the capture that a request of `decode` names.
  // \param any_lines if no lines look like MA and SLO, take the two busiest ones
  Session(const Request& request, bool any_lines)
      : accesses_(verbs::access_columns()), listener_([this](const decode::SeenAccess& access) {
          verbs::write_access(accesses_, access);
        }) {
    verbs::Command command(host_);
    const verbs::Verb verb = command.add_verb(verbs::decode_text(), [&](verbs::Host& /*host*/) {
      options_.capture.any_lines = any_lines;
      return begin();
    });
    verbs::add_decode_options(verb, options_);
    status_ = command.run(request.words, request.options);
  }
  Session(const Session&) = delete;

  // `done` when the capture is open; otherwise nothing below may be called. After the end of the
  // capture the exit status of the command.
  verbs::ExitStatus status() const { return status_; }

  // Reads on for at most about this time. False at the end of the capture; then the messages of the
  // command are on stderr.
  bool advance(double milliseconds) {
    using Clock = std::chrono::steady_clock;
    const auto until = Clock::now() + std::chrono::duration<double, std::milli>(milliseconds);
    while (!ended_) {
      if (!run_->capture().step()) end();
      if (Clock::now() >= until) break;
    }
    return !ended_;
  }

  // Facts about the capture, as a JSON object; see biss.d.mts.
  std::string about() {
    verbs::DecodedCapture& capture = run_->capture();
    const decode::FoundLines& found = capture.lines();
    json about{{"name", capture.input().name()},
               {"lines", capture.input().lines()},
               {"ma", capture.ma_name()},
               {"slo", capture.slo_name()},
               {"maInverted", found.lines.ma_inverted},
               {"sloInverted", found.lines.slo_inverted},
               {"linesBy", origin_names[static_cast<std::size_t>(found.origin)]},
               {"looksSwapped", found.look_swapped},
               {"sampleRate", capture.input().sample_rate().count},
               {"endTime", exact(capture.input().end_time())},
               {"lineKind", line_kind(capture.input())},
               {"cycles", rows_->rows()},
               {"accesses", accesses_.rows()},
               {"ended", ended_},
               {"status", static_cast<int>(status_)},
               {"error", capture.input().error()}};
    if (capture.format()) about["format"] = format_text(*capture.format()).view();
    const std::string& given = options_.capture.device.format;
    const auto device = biss::parse_device(given.empty() ? "none" : given);
    const bool named = device && (device->entry != nullptr || device->configuration != nullptr);
    if (named) about["formatName"] = given;
    const auto* finding = capture.finding();
    const auto* sure = finding != nullptr ? finding->sure() : nullptr;
    if (sure != nullptr) {
      about["confidence"] = sure->confidence;
      about["encoders"] = sure->encoders;
    }
    return dumped(about);
  }

  // The columns, as a JSON array.
  std::string columns_text() const {
    json columns = json::array();
    for (const auto& stored : rows_->columns()) {
      const report::Column& column = stored.column;
      columns.push_back({{"name", column.name},
                         {"kind", report::kind_names[static_cast<std::size_t>(column.kind)]},
                         {"valueUnit", column.value_unit},
                         {"role", report::role_names[static_cast<std::size_t>(column.role)]},
                         {"title", column.title},
                         {"plot", column.plot}});
    }
    return dumped(columns);
  }

  const Rows& rows() const { return *rows_; }
  // \param ma of MA, otherwise of SLO; as the capture shows it
  const LineStore& line(bool ma) const { return ma ? ma_ : slo_; }
  // As the command prints it.
  std::string summary() const { return run_->summary(); }

  // Accesses to registers, and commands, that take place within the cycles from number `first` to
  // before number `end`, as `biss registers --to jsonl` writes them.
  std::string accesses(std::uint64_t first, std::uint64_t end) const {
    const auto& cycle = accesses_.column("cycle");
    const auto& cycles = accesses_.column("cycles");
    // In the order of cycles, and one after the other; a command to several slaves has several rows.
    const auto from_cycle = [&](std::uint64_t wanted) {
      const auto& numbers = cycle.numbers;
      return static_cast<std::size_t>(std::lower_bound(numbers.begin(), numbers.end(), wanted) -
                                      numbers.begin());
    };
    std::size_t from = from_cycle(first);
    while (from > 0 && cycle.number(from - 1) + cycles.number(from - 1) > first) --from;
    return accesses_.text(report::Format::jsonl, from, std::max(from, from_cycle(end)));
  }

  // A cycle bit by bit and part by part, as a JSON object. Empty if its edges do not show it again.
  // \param number the number of the cycle; by default the number in its row
  // \pre row < rows().rows()
  std::optional<std::string> cycle(std::uint64_t row, std::optional<std::uint64_t> number) {
    // Cycles around it show the clock.
    constexpr std::uint64_t around = 2;
    const std::uint64_t last = rows_->rows() - 1;
    const Picoseconds time = time_of(row);
    const Picoseconds before = time_of(row - std::min(row, around));
    const bool to_end = last - row <= around;
    verbs::DecodedCapture& capture = run_->capture();
    const Picoseconds end = capture.input().end_time();
    const Picoseconds wanted = row <= around ? before - milliseconds(1) : before - picoseconds(1);
    const Picoseconds from = std::max({wanted, ma_.some_before(time), slo_.some_before(time)});
    const Picoseconds to = to_end ? end : time_of(row + around + 1);
    if (!number) number = rows_->column("cycle").number(static_cast<std::size_t>(row));
    const decode::Lines& lines = capture.lines().lines;
    std::vector<wire::Edge> all;
    ma_.append_edges(lines.ma, from, to, all);
    slo_.append_edges(lines.slo, from, to, all);
    std::stable_sort(all.begin(), all.end(),
                     [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
    std::optional<json> found;
    decode::CycleEdgeReader cycles(capture.reader(), lines, [&](const decode::CycleEdges& edges) {
      if (edges.cycle.time != time) return;
      found = cycle_json(*number, edges, capture.format(), capture.timing(), capture.margin());
    });
    cycles.push(all);
    if (!found) cycles.finish(to);
    if (!found) return std::nullopt;
    return dumped(*found);
  }

 private:
  Picoseconds time_of(std::uint64_t row) const {
    const std::uint64_t time = rows_->column("time_ns").number(static_cast<std::size_t>(row));
    return picoseconds(static_cast<std::int64_t>(time));
  }

  verbs::ExitStatus begin() {
    run_ = std::make_unique<verbs::DecodeRun>(options_, host_);
    verbs::ExitStatus status = run_->open();
    if (status != verbs::ExitStatus::done) return status;
    if (run_->capture().several()) {
      return host_.fail(
          verbs::ExitStatus::usage,
          "a page reads one capture and one pair of lines; name them with --ma and --slo");
    }
    status = run_->next();
    if (status != verbs::ExitStatus::done) return status;
    rows_.emplace(run_->columns());
    status = run_->begin_rows();
    if (status != verbs::ExitStatus::done) return status;
    const auto take = [this](std::uint64_t number, const decode::Cycle& cycle) {
      listener_.push(number, cycle);
      return run_->take(number, cycle, *rows_);
    };
    run_->capture().begin_steps(take, this);
    return verbs::ExitStatus::done;
  }

  void take(std::span<const wire::Edge> edges) override {
    const decode::Lines& lines = run_->capture().lines().lines;
    for (const wire::Edge& edge : edges) {
      if (edge.line == lines.ma) ma_.push(edge.time, edge.level);
      if (edge.line == lines.slo) slo_.push(edge.time, edge.level);
    }
  }

  void take(const capture::PairPiece& changes) override {
    const auto add = [](LineStore& store, const capture::LineChanges& line) {
      bool high = line.first_high;
      for (const std::int64_t time : line.times) {
        store.push(picoseconds(time), high ? Level::high : Level::low);
        high = !high;
      }
    };
    add(ma_, changes.ma);
    add(slo_, changes.slo);
  }

  void end() {
    ended_ = true;
    verbs::RunMessages messages;
    const bool read = run_->capture().end_steps();
    listener_.finish();
    status_ = run_->end_rows(read, messages);
    messages.print(host_);
  }

  verbs::ProcessHost host_;
  verbs::DecodeOptions options_;
  std::unique_ptr<verbs::DecodeRun> run_;
  std::optional<Rows> rows_;
  Rows accesses_;
  decode::ControlListener listener_;
  LineStore ma_;
  LineStore slo_;
  verbs::ExitStatus status_ = verbs::ExitStatus::done;
  bool ended_ = false;
};

std::string text;
LineView view;
std::vector<std::uint64_t> values;
std::vector<std::uint8_t> present;

const char* keep(std::string kept) {
  text = std::move(kept);
  return text.c_str();
}

}  // namespace
}  // namespace biss::wasm

using namespace biss::wasm;

extern "C" {

// Runs a verb on the files in memory.
EMSCRIPTEN_KEEPALIVE int biss_run(const char* json) {
  biss::verbs::ProcessHost host;
  try {
    const Request request(json);
    biss::verbs::Command command(host);
    biss::verbs::add_verbs(command, request.words.empty() ? "" : request.words.front());
    return static_cast<int>(command.run(request.words, request.options));
  } catch (const std::bad_alloc&) {
    return static_cast<int>(host.fail(biss::verbs::ExitStatus::io, "out of memory"));
  }
}

// The verbs and their options, as verbs::described() has them.
EMSCRIPTEN_KEEPALIVE const char* biss_verbs() {
  biss::verbs::ProcessHost host;
  biss::verbs::Command command(host);
  biss::verbs::add_verbs(command);
  return keep(biss::verbs::described(command.declared()));
}

// Statuses and verdicts with their words, in the order of their values.
EMSCRIPTEN_KEEPALIVE const char* biss_words() {
  nlohmann::json words;
  for (std::size_t i = 0; i < biss::cycle_status_count; ++i) {
    const auto status = static_cast<biss::CycleStatus>(i);
    words["statuses"].push_back({{"name", name_of(status)},
                                 {"seen", words_of(status).seen},
                                 {"fault", is_fault(status)},
                                 {"cut", is_cut(status)}});
  }
  for (std::size_t i = 0; i < biss::safety_verdict_count; ++i) {
    const biss::SafetyVerdict verdict = biss::verdict_of(i);
    words["verdicts"].push_back({{"name", name_of(verdict)}, {"fault", is_fault(verdict)}});
  }
  return keep(dumped(words));
}

// Null if memory has run out. If the capture cannot be opened, the session has only its status.
EMSCRIPTEN_KEEPALIVE Session* biss_open(const char* request, int any_lines) {
  try {
    return new Session(Request(request), any_lines != 0);
  } catch (const std::bad_alloc&) {
    biss::verbs::ProcessHost().warn("out of memory");
    return nullptr;
  }
}

EMSCRIPTEN_KEEPALIVE void biss_close(Session* session) { delete session; }

EMSCRIPTEN_KEEPALIVE int biss_status(const Session* session) {
  return static_cast<int>(session->status());
}

// 1: more is to be read; 0: the end; -1: memory has run out.
EMSCRIPTEN_KEEPALIVE int biss_advance(Session* session, double milliseconds) {
  try {
    return session->advance(milliseconds) ? 1 : 0;
  } catch (const std::bad_alloc&) {
    biss::verbs::ProcessHost().warn("out of memory");
    return -1;
  }
}

EMSCRIPTEN_KEEPALIVE const char* biss_about(Session* session) { return keep(session->about()); }

EMSCRIPTEN_KEEPALIVE const char* biss_columns(const Session* session) {
  return keep(session->columns_text());
}

EMSCRIPTEN_KEEPALIVE double biss_row_count(const Session* session) {
  return static_cast<double>(session->rows().rows());
}

EMSCRIPTEN_KEEPALIVE const char* biss_rows(const Session* session, double from, double to) {
  return keep(session->rows().text(biss::report::Format::csv, static_cast<std::size_t>(from),
                                   static_cast<std::size_t>(to)));
}

// The values; biss_present() has their presence. Bits are not values.
EMSCRIPTEN_KEEPALIVE const std::uint64_t* biss_column(const Session* session, int index,
                                                      double from, double to) {
  const auto& stored = session->rows().columns()[static_cast<std::size_t>(index)];
  values.clear();
  present.clear();
  for (auto row = static_cast<std::size_t>(from); row < static_cast<std::size_t>(to); ++row) {
    present.push_back(stored.is_absent(row) ? 0 : 1);
    if (stored.column.kind != biss::report::Kind::bits) values.push_back(stored.number(row));
  }
  return values.data();
}

EMSCRIPTEN_KEEPALIVE const std::uint8_t* biss_present() { return present.data(); }

// The texts of a text column, as a JSON array.
EMSCRIPTEN_KEEPALIVE const char* biss_column_texts(const Session* session, int index) {
  return keep(dumped(session->rows().columns()[static_cast<std::size_t>(index)].texts));
}

// How many entries the view has; biss_view_times() and biss_view_levels() have them.
EMSCRIPTEN_KEEPALIVE int biss_view(const Session* session, int ma, std::int64_t from,
                                   std::int64_t to, int columns) {
  view = session->line(ma != 0).view(biss::picoseconds(from), biss::picoseconds(to),
                                     static_cast<std::uint32_t>(columns));
  return static_cast<int>(view.times.size());
}

EMSCRIPTEN_KEEPALIVE const std::int64_t* biss_view_times() { return view.times.data(); }
EMSCRIPTEN_KEEPALIVE const std::uint8_t* biss_view_levels() { return view.shown.data(); }

EMSCRIPTEN_KEEPALIVE const char* biss_summary(const Session* session) {
  return keep(session->summary());
}

// Null if the edges do not show the cycle. A negative number stands for the number of the row.
EMSCRIPTEN_KEEPALIVE const char* biss_cycle(Session* session, double row, double number) {
  auto cycle =
      session->cycle(static_cast<std::uint64_t>(row),
                     number < 0 ? std::nullopt : std::optional(static_cast<std::uint64_t>(number)));
  return cycle ? keep(std::move(*cycle)) : nullptr;
}

EMSCRIPTEN_KEEPALIVE const char* biss_accesses(const Session* session, double first, double end) {
  return keep(
      session->accesses(static_cast<std::uint64_t>(first), static_cast<std::uint64_t>(end)));
}

}  // extern "C"
